//! How far normals from fields are from exact ones.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_fixtures::poses;
use bdtree_gpu::NormalFields;
use bdtree_runtime::{Asset, Model, TriangleId, VertexId};
use clap::Args;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Baked files
    #[arg(required = true)]
    assets: Vec<PathBuf>,
    /// Displacement of the farthest vertex, as a share of the bounding box's diagonal
    #[arg(long, default_value_t = 0.1)]
    share: f64,
    /// Random mixtures of all modes, beside each mode alone
    #[arg(long, default_value_t = 20)]
    mixtures: usize,
    /// Seed of the mixtures
    #[arg(long, default_value_t = 7)]
    seed: u64,
}

type Vector = [f64; 3];

fn add(a: Vector, b: Vector, k: f64) -> Vector {
    [0, 1, 2].map(|i| a[i] + k * b[i])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

fn degrees(a: Vector, b: Vector) -> f64 {
    norm(cross(a, b)).atan2(dot(a, b)).to_degrees()
}

/// Positions and fields in f64, and the triangles.
struct Mesh {
    rest: Vec<Vector>,
    /// Mode by mode.
    fields: Vec<Vec<Vector>>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    fn of(asset: &Asset<'_>) -> Result<Self, Box<dyn Error>> {
        let n = asset.vertex_count();
        let mut fields = vec![vec![[0.0; 3]; n]; asset.mode_count()];
        for i in 0..n {
            for (mode, u) in asset.displacements(VertexId(i as u32))?.iter() {
                fields[mode][i] = u.map(f64::from);
            }
        }
        let triangle = |id| Ok(asset.triangle(TriangleId(id))?.map(|v| v.0 as usize));
        Ok(Self {
            rest: asset.positions().iter().map(|p| p.map(f64::from)).collect(),
            fields,
            triangles: (0..asset.triangle_count() as u32)
                .map(triangle)
                .collect::<Result<_, Box<dyn Error>>>()?,
        })
    }

    fn displaced(&self, q: &[f32]) -> Vec<Vector> {
        let mut sum = vec![[0.0; 3]; self.rest.len()];
        for (field, q) in self.fields.iter().zip(q) {
            for (sum, u) in sum.iter_mut().zip(field) {
                *sum = add(*sum, *u, f64::from(*q));
            }
        }
        sum
    }

    /// Area-weighted normals, Σ e × f, and Σ ‖e‖ ‖f‖, which tells where they cancel.
    fn normals(&self, at: &[Vector]) -> Vec<(Vector, f64)> {
        self.sums(|own, b, c| {
            let (e, f) = (add(at[b], at[own], -1.0), add(at[c], at[own], -1.0));
            (cross(e, f), norm(e) * norm(f))
        })
    }

    /// What a displacement changes of them in first order: the best that three numbers per mode can do.
    fn first_order(&self, by: &[Vector]) -> Vec<(Vector, f64)> {
        self.sums(|own, b, c| {
            let edge = |of: &[Vector], v: usize| add(of[v], of[own], -1.0);
            let (e, f) = (edge(&self.rest, b), edge(&self.rest, c));
            let (de, df) = (edge(by, b), edge(by, c));
            (add(cross(de, f), cross(e, df), 1.0), 0.0)
        })
    }

    fn sums(&self, of: impl Fn(usize, usize, usize) -> (Vector, f64)) -> Vec<(Vector, f64)> {
        let mut sums = vec![([0.0; 3], 0.0); self.rest.len()];
        for corners in &self.triangles {
            for k in 0..3 {
                let [own, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                let (v, size) = of(own, b, c);
                sums[own] = (add(sums[own].0, v, 1.0), sums[own].1 + size);
            }
        }
        sums
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    println!(
        "angles to exact normals in degrees, modes alone and {} mixtures, farthest vertex moved by {} of the diagonal",
        arguments.mixtures, arguments.share
    );
    println!(
        "asset, fields: largest, 99.9 %, 99 %, mean; over 1 degree; bytes; vertices recomputed, seconds to make"
    );
    for path in &arguments.assets {
        let model = Model::read(path)?;
        let asset = model.asset();
        let (n, m) = (asset.vertex_count(), asset.mode_count());
        let mesh = Mesh::of(asset)?;
        let start = Instant::now();
        let fields = NormalFields::new(asset)?;
        let seconds = start.elapsed().as_secs_f64();
        let at_rest = mesh.normals(&mesh.rest);
        let mut rng = poses::rng(arguments.seed);
        let alone = (0..m).map(|j| (0..m).map(|k| f32::from(u8::from(j == k))).collect());
        let mixed = (0..arguments.mixtures).map(|_| poses::random_q(asset, 0.1, &mut rng));
        let mut marked = vec![false; n];
        for vertex in fields.marked() {
            marked[*vertex as usize] = true;
        }
        let mut angles = [Vec::new(), Vec::new(), Vec::new()];
        for mut q in alone.chain(mixed).collect::<Vec<Vec<f32>>>() {
            let most = mesh.displaced(&q).into_iter().map(norm).fold(0.0, f64::max);
            let goal = arguments.share * poses::diagonal(asset);
            q.iter_mut().for_each(|q| *q *= (goal / most) as f32);
            let by = mesh.displaced(&q);
            let at: Vec<Vector> = mesh
                .rest
                .iter()
                .zip(&by)
                .map(|(p, u)| add(*p, *u, 1.0))
                .collect();
            let (exact, linear) = (mesh.normals(&at), mesh.first_order(&by));
            for i in 0..n {
                let (normal, size) = exact[i];
                // Where triangles cancel, as needles that coincide do, there is no normal to compare with.
                if norm(normal) > 1e-3 * size && norm(at_rest[i].0) > 1e-3 * at_rest[i].1 {
                    let [(a, _), (b, _)] = fields.tangents(i, &q);
                    angles[0].push(degrees(add(at_rest[i].0, linear[i].0, 1.0), normal));
                    let from_fields = degrees(cross(a, b), normal);
                    angles[1].push(from_fields);
                    // Exact up to rounding, which bdtree-gpu's tests of normals assert.
                    angles[2].push(if marked[i] { 0.0 } else { from_fields });
                }
            }
        }
        let tangents = fields.bytes() as usize;
        let bytes = [
            12 * n * (m + 1),
            tangents - fields.marked_bytes() as usize,
            tangents,
        ];
        let share = 100.0 * fields.marked().len() as f64 / n as f64;
        let made = format!("{share:.2} %, {seconds:.3}");
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        for ((angles, bytes), (what, made)) in angles.iter_mut().zip(bytes).zip([
            ("linear", "-"),
            ("tangents", "-"),
            ("recomputed", &made),
        ]) {
            angles.sort_by(f64::total_cmp);
            let at = |share: f64| angles[((angles.len() - 1) as f64 * share) as usize];
            let over = angles.iter().filter(|a| **a > 1.0).count() as f64 / angles.len() as f64;
            println!(
                "{name}, {what}: {:.2}, {:.2}, {:.3}, {:.4}; {:.4} %; {bytes}; {made}",
                at(1.0),
                at(0.999),
                at(0.99),
                angles.iter().sum::<f64>() / angles.len() as f64,
                100.0 * over,
            );
        }
    }
    Ok(())
}
