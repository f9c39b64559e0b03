//! Hard cases in one list: meshes, what they can do, and the q and places at which they are asked.
//! docs/hard-cases.md has the table.

mod bodies;
pub mod bounded;
mod check;
pub mod exact;
mod front;
mod refused;

pub use bodies::hard_cases;
pub use check::{Placed, ROUNDS, check_case, check_pairs_of, rays_at};
pub use refused::{Refused, refused_cases};

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_runtime::{AlignedBytes, Asset, Transform};

use crate::{bake, poses};

/// A mesh with its fields and the q at which it is hardest.
#[derive(Debug, Clone)]
pub struct HardCase {
    /// As docs/hard-cases.md calls it.
    pub name: &'static str,
    /// The mesh.
    pub mesh: RawMesh,
    /// What it can do; frames are asked too.
    pub basis: Basis,
    /// q of its own beside those of every case.
    pub qs: Vec<Vec<f32>>,
    /// Whether its surface is closed and seen from the mean of its vertices without a shadow: at rest no
    /// ray from there misses it.
    pub is_star: bool,
}

impl HardCase {
    /// The file, with default settings.
    ///
    /// # Panics
    /// When the bake fails.
    pub fn bake(&self) -> AlignedBytes {
        bake::baked(&self.mesh, &self.basis)
    }

    /// At rest, at the typical range, ten times that with alternating signs, at the limits with alternating
    /// signs, subnormal, some q in between, and the case's own.
    pub fn poses(&self, asset: &Asset<'_>) -> Vec<Vec<f32>> {
        let modes = asset.modes();
        let each = |f: &dyn Fn(usize) -> f32| (0..modes.len()).map(f).collect::<Vec<f32>>();
        let limit = |j: usize| modes[j].q_limit.get();
        let range = |j: usize| modes[j].q_range.get();
        let sign = |j: usize| if j.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut all = vec![each(&|_| 0.0)];
        if modes.is_empty() {
            return all;
        }
        all.extend([
            each(&range),
            each(&|j| (sign(j) * 10.0 * range(j)).clamp(-limit(j), limit(j))),
            each(&|j| -sign(j) * limit(j)),
            each(&|j| sign(j) * f32::from_bits(1 + j as u32)),
            poses::random_q(asset, 0.3, &mut poses::rng(17)),
        ]);
        all.extend(self.qs.iter().cloned());
        all
    }
}

/// Where bodies are put: as they are, turned, 10⁶ and 10⁸ away, shrunk and enlarged a thousand times, and
/// both far and small.
pub fn placements() -> Vec<(&'static str, Transform)> {
    let turned = poses::random_transform(0.0, &mut poses::rng(23)).rotation;
    let place = |translation: [f64; 3], scale: f64| Transform {
        rotation: turned,
        translation,
        scale,
    };
    vec![
        ("as baked", Transform::IDENTITY),
        ("turned", place([0.5, -0.25, 3.0], 1.0)),
        ("1e6 away", place([1e6, -2e6, 3e6], 1.0)),
        ("1e8 away", place([-3e8, 1e8, 2e8], 1.0)),
        ("a thousandth", place([0.1, 0.2, 0.3], 1e-3)),
        ("a thousandfold", place([10.0, 20.0, -30.0], 1e3)),
        ("a thousandth, 1e8 away", place([1e8, 0.0, 0.0], 1e-3)),
    ]
}
