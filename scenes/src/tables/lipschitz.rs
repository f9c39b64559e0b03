//! Appendix A: ΔR_j ≤ 2 L_j R, with L_j the Lipschitz constant of field j over the node's vertices (P22), and
//! how often ΔR_j exceeds δR (P23).

use std::error::Error;

use bdtree_runtime::{Asset, VertexId};
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use crate::hierarchies::{Hierarchies, Kind};
use crate::report::Table;

/// ΔR is at most this times L R where Ū is the center of the smallest ball (Jung's theorem in space).
const JUNG: f64 = 1.224_744_871_391_589;

/// What rounding to f32 may add, relative.
const ROUNDING: f64 = 1e-6;

/// Over all nodes that are small enough, and all modes.
#[derive(Serialize)]
pub(super) struct Pairs {
    spheres: &'static str,
    /// What the theorem allows.
    bound: f64,
    /// Nodes with two vertices or more, times modes.
    nodes_times_modes: u64,
    /// Largest ΔR_j / (L_j R).
    largest: f64,
    /// Mean of the same; the sum, until all are added.
    mean: f64,
    /// Where it is above the bound.
    violations: u64,
    /// Where L_j is above the parent's.
    rising_constants: u64,
    /// Share where ΔR_j > δR; their number, until all are added.
    share_above_common: f64,
}

impl Pairs {
    fn new(kind: Kind) -> Self {
        Self {
            spheres: kind.short(),
            bound: if kind == Kind::Ours { JUNG } else { 2.0 },
            nodes_times_modes: 0,
            largest: 0.0,
            mean: 0.0,
            violations: 0,
            rising_constants: 0,
            share_above_common: 0.0,
        }
    }

    fn add(&mut self, growth: f64, lipschitz: f64, radius: f64, common: f64) {
        let limit = lipschitz * radius;
        // Constant fields have neither.
        let ratio = if growth == 0.0 { 0.0 } else { growth / limit };
        self.nodes_times_modes += 1;
        self.largest = self.largest.max(ratio);
        self.mean += ratio;
        self.violations += u64::from(!(ratio <= self.bound * (1.0 + ROUNDING)));
        if growth > common * (1.0 + ROUNDING) {
            self.share_above_common += 1.0;
        }
    }

    /// After all are added.
    fn finished(self) -> Self {
        let count = self.nodes_times_modes as f64;
        Self {
            mean: self.mean / count,
            share_above_common: self.share_above_common / count,
            ..self
        }
    }
}

/// The numbers of the vertices of an asset (stored units, f64).
struct Points {
    modes: usize,
    positions: Vec<Vector3<f64>>,
    /// Vertex after vertex.
    fields: Vec<Vector3<f64>>,
    /// ‖U_i:‖₂.
    norms: Vec<f64>,
}

impl Points {
    fn new(asset: &Asset<'_>) -> Result<Self, Box<dyn Error>> {
        let modes = asset.mode_count();
        let wide = |[x, y, z]: [f32; 3]| Vector3::new(x, y, z).map(f64::from);
        let mut fields = Vec::with_capacity(modes * asset.vertex_count());
        let mut norms = Vec::with_capacity(asset.vertex_count());
        for i in 0..asset.vertex_count() as u32 {
            let own = asset.displacements(VertexId(i))?;
            let mut square = Matrix3::zeros();
            for j in 0..modes {
                let u = wide(own.of(j));
                square += u * u.transpose();
                fields.push(u);
            }
            norms.push(square.symmetric_eigenvalues().max().max(0.0).sqrt());
        }
        Ok(Self {
            modes,
            positions: asset.positions().iter().map(|p| wide(*p)).collect(),
            fields,
            norms,
        })
    }

    /// L_j of all fields over some vertices, by all pairs; infinite where two vertices in one place move apart.
    fn lipschitz(&self, vertices: &[u32]) -> Vec<f64> {
        let m = self.modes;
        let mut squares = vec![0.0_f64; m];
        for (k, a) in vertices.iter().map(|v| *v as usize).enumerate() {
            for b in vertices[k + 1..].iter().map(|v| *v as usize) {
                let apart = (self.positions[a] - self.positions[b]).norm_squared();
                let (ua, ub) = (&self.fields[a * m..][..m], &self.fields[b * m..][..m]);
                for j in 0..m {
                    let moved = (ua[j] - ub[j]).norm_squared();
                    if moved > 0.0 {
                        squares[j] = squares[j].max(moved / apart);
                    }
                }
            }
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

/// The paper's spheres (mean Ū) and ours (ball-centered Ū) of all nodes of at most `most` vertices.
pub(super) fn measure(
    asset: &Asset<'_>,
    trees: &Hierarchies<'_>,
    most: usize,
) -> Result<[Pairs; 2], Box<dyn Error>> {
    let points = Points::new(asset)?;
    let mut all = [Kind::Paper, Kind::Ours].map(Pairs::new);
    // L_j of the last node of each level: in preorder a node's parent is the last of the level above.
    let mut above: Vec<Option<Vec<f64>>> = vec![None; trees.depth()];
    for (node, (level, triangles)) in trees.nodes.iter().enumerate() {
        let vertices = trees.vertices(triangles);
        if !(2..=most).contains(&vertices.len()) {
            above[*level] = None;
            continue;
        }
        let lipschitz = points.lipschitz(&vertices);
        let common = vertices
            .iter()
            .map(|v| points.norms[*v as usize])
            .fold(0.0, f64::max);
        let numbers = trees.tree.numbers(node);
        let ours = trees.ours(triangles)?;
        for j in 0..points.modes {
            let growths = [f64::from(numbers[1 + j][3]), ours.growth_of(j)];
            let radii = [f64::from(numbers[0][3]), ours.radius];
            for (pairs, (growth, radius)) in all.iter_mut().zip(growths.into_iter().zip(radii)) {
                pairs.add(growth, lipschitz[j], radius, common);
                let parent = level.checked_sub(1).and_then(|level| above[level].as_ref());
                pairs.rising_constants +=
                    u64::from(parent.is_some_and(|parent| lipschitz[j] > parent[j]));
            }
        }
        above[*level] = Some(lipschitz);
    }
    Ok(all.map(Pairs::finished))
}

/// A row for each mesh and kind.
pub(super) fn table(most: u16, rows: &[(&str, &Pairs)]) -> Table {
    let title = format!(
        "Appendix A: ΔR_j / (L_j R) over all nodes of at most {most} vertices and all modes, which may not exceed \
         2 (Ū the mean) or √(3/2) (Ū the center of the smallest ball); where L_j exceeds the parent's; and share \
         of nodes and modes where ΔR_j exceeds δR."
    );
    Table::of(
        "appendix-a",
        title,
        rows,
        &[
            ("mesh", &|(mesh, _)| (*mesh).into()),
            ("spheres", &|(_, p)| p.spheres.into()),
            ("nodes × modes", &|(_, p)| p.nodes_times_modes.into()),
            ("bound", &|(_, p)| p.bound.into()),
            ("largest", &|(_, p)| p.largest.into()),
            ("mean", &|(_, p)| p.mean.into()),
            ("above the bound", &|(_, p)| p.violations.into()),
            ("L above the parent's", &|(_, p)| p.rising_constants.into()),
            ("ΔR_j > δR, %", &|(_, p)| {
                (100.0 * p.share_above_common).into()
            }),
        ],
    )
}
