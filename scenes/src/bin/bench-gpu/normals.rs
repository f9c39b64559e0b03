//! How far normals from fields are from exact ones.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_fixtures::poses;
use bdtree_gpu::NormalFields;
use bdtree_measure::Body;
use bdtree_runtime::{Asset, Model};
use bdtree_scenes::report::{Report, table};
use bdtree_scenes::row;
use clap::Args;
use nalgebra::Vector3;

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

type Vector = Vector3<f64>;

fn degrees(a: Vector, b: Vector) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
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
        let body = Body::of_asset(asset)?;
        let wide = |all: &[[f32; 3]]| all.iter().map(|p| p.map(f64::from).into()).collect();
        let fields = body.fields.chunks(asset.vertex_count());
        let triangles = body.triangles.iter().map(|t| t.map(|v| v as usize));
        Ok(Self {
            rest: wide(&body.positions),
            fields: fields.map(wide).collect(),
            triangles: triangles.collect(),
        })
    }

    fn displaced(&self, q: &[f32]) -> Vec<Vector> {
        let mut sum = vec![Vector::zeros(); self.rest.len()];
        for (field, q) in self.fields.iter().zip(q) {
            for (sum, u) in sum.iter_mut().zip(field) {
                *sum += *u * f64::from(*q);
            }
        }
        sum
    }

    /// Area-weighted normals, Σ e × f, and Σ ‖e‖ ‖f‖, which tells where they cancel.
    fn normals(&self, at: &[Vector]) -> Vec<(Vector, f64)> {
        self.sums(|own, b, c| {
            let (e, f) = (at[b] - at[own], at[c] - at[own]);
            (e.cross(&f), e.norm() * f.norm())
        })
    }

    /// What a displacement changes of them in first order: the best that three numbers per mode can do.
    fn first_order(&self, by: &[Vector]) -> Vec<(Vector, f64)> {
        let rest = &self.rest;
        self.sums(|own, b, c| {
            let (e, f) = (rest[b] - rest[own], rest[c] - rest[own]);
            let (de, df) = (by[b] - by[own], by[c] - by[own]);
            (de.cross(&f) + e.cross(&df), 0.0)
        })
    }

    fn sums(&self, of: impl Fn(usize, usize, usize) -> (Vector, f64)) -> Vec<(Vector, f64)> {
        let mut sums = vec![(Vector::zeros(), 0.0); self.rest.len()];
        for corners in &self.triangles {
            for k in 0..3 {
                let [own, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                let (v, size) = of(own, b, c);
                sums[own].0 += v;
                sums[own].1 += size;
            }
        }
        sums
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut rows = Vec::new();
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
            let most = mesh
                .displaced(&q)
                .iter()
                .map(Vector::norm)
                .fold(0.0, f64::max);
            let goal = arguments.share * poses::diagonal(asset);
            q.iter_mut().for_each(|q| *q *= (goal / most) as f32);
            let by = mesh.displaced(&q);
            let at: Vec<Vector> = mesh.rest.iter().zip(&by).map(|(p, u)| p + u).collect();
            let (exact, linear) = (mesh.normals(&at), mesh.first_order(&by));
            for i in 0..n {
                let ((normal, size), (rest, rest_size)) = (exact[i], at_rest[i]);
                // Where triangles cancel, as needles that coincide do, there is no normal to compare with.
                if normal.norm() > 1e-3 * size && rest.norm() > 1e-3 * rest_size {
                    let [a, b] = fields
                        .tangents(i, &q)
                        .map(|(tangent, _)| Vector::from(tangent));
                    angles[0].push(degrees(rest + linear[i].0, normal));
                    let from_fields = degrees(a.cross(&b), normal);
                    angles[1].push(from_fields);
                    // Exact up to rounding, which bdtree-gpu's tests of normals assert.
                    angles[2].push(if marked[i] { 0.0 } else { from_fields });
                }
            }
        }
        let all = fields.bytes() as usize;
        let bytes = [12 * n * (m + 1), all - fields.marked_bytes() as usize, all];
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let whats = ["linear", "tangents", "recomputed"];
        for ((angles, bytes), what) in angles.iter_mut().zip(bytes).zip(whats) {
            angles.sort_by(f64::total_cmp);
            let at = |share: f64| angles[((angles.len() - 1) as f64 * share) as usize];
            let count = angles.len() as f64;
            let over = angles.iter().filter(|a| **a > 1.0).count() as f64;
            let mut row = row! {
                "asset" => name.as_ref(), "fields" => what,
                "largest" => at(1.0), "99.9 %" => at(0.999), "99 %" => at(0.99),
                "mean" => angles.iter().sum::<f64>() / count,
                "over 1 degree, %" => 100.0 * over / count, "bytes" => bytes,
            };
            if what == "recomputed" {
                row.extend(row! {
                    "vertices recomputed, %" => 100.0 * fields.marked().len() as f64 / n as f64,
                    "seconds to make" => seconds,
                });
            }
            rows.push(row);
        }
    }
    let title = format!(
        "Angles to exact normals in degrees, modes alone and {} mixtures, farthest vertex moved by {} of the diagonal",
        arguments.mixtures, arguments.share
    );
    Report::of_tables("normals", vec![table("normals", title, &rows)]).show(None)
}
