//! Ways to deform a body as far as figure 6 asks for.

use bdtree_fixtures::poses;
use bdtree_measure::Body;
use bdtree_measure::deform::Deformer;
use bdtree_runtime::Asset;
use rand::{Rng, RngExt};
use serde::Serialize;

use crate::workloads::scale;

/// What deformations of an amplitude look like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Way {
    /// Not at all.
    Rest,
    /// Vibration modes with about the same energy each; frames of an animation.
    Natural,
    /// All modes move about as far, the rough ones too.
    Even,
}

impl Way {
    /// For tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Natural => "natural",
            Self::Even => "even",
        }
    }

    /// Coordinates of such a deformation, of any size.
    pub(super) fn q(self, asset: &Asset<'_>, rng: &mut impl Rng) -> Vec<f32> {
        let modes = asset.modes();
        if self == Self::Natural && asset.frame_count() > 0 {
            let frame = asset.frame(rng.random_range(0..asset.frame_count()));
            return frame.map(|frame| frame.q().to_vec()).unwrap_or_default();
        }
        // Energy is ω² q² for modes of the same mass.
        let slowest = modes.first().map_or(0.0, |mode| mode.omega_rad_s.get());
        let weight = |omega: f64| match self {
            Self::Natural if omega > 0.0 => (slowest / omega) as f32,
            _ => 1.0,
        };
        let all = modes.iter().map(|mode| {
            let range = mode.q_range.get() * weight(mode.omega_rad_s.get());
            range * rng.random_range(-1.0..1.0_f32)
        });
        all.collect()
    }
}

/// A deformation that moves nothing is drawn again, so often at most: a body that nothing moves stays at rest.
const DRAWS_MAX: usize = 100;

/// Deformations of each way, of one amplitude.
pub(super) struct Deformations<'a, 'b> {
    asset: &'a Asset<'b>,
    body: &'a Body,
    deformer: Deformer,
    count: u16,
    seed: u64,
}

impl<'a, 'b> Deformations<'a, 'b> {
    /// `count` a way and amplitude, the same in every run.
    pub(super) fn new(asset: &'a Asset<'b>, body: &'a Body, count: u16, seed: u64) -> Self {
        Self {
            asset,
            body,
            deformer: Deformer::new(body),
            count,
            seed,
        }
    }

    /// Coordinates that move the farthest vertex by `amplitude` of the diagonal: of all amplitudes the same
    /// deformations, longer or shorter.
    pub(super) fn of(&self, way: Way, amplitude: f64) -> Vec<Vec<f32>> {
        let mut rng = poses::rng(self.seed);
        let mut out = vec![0.0; self.deformer.count];
        let one = |_| {
            let mut q = Vec::new();
            // An animation may show the rest pose, too.
            for _ in 0..DRAWS_MAX {
                q = way.q(self.asset, &mut rng);
                if scale(self.body, &self.deformer, &mut q, amplitude, &mut out) {
                    break;
                }
            }
            q
        };
        (0..self.count).map(one).collect()
    }
}
