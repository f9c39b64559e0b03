//! How far a pose has moved from the one that nodes were evaluated at (paper, eqs. 8–11).

use bdtree_format::Row;

use crate::math::sqrt;
use crate::pose::Pose;
use crate::rounding::{DRIFT, MARGIN, round_up};
use crate::simd::Lanes;

/// What the spheres of another pose need so that they hold at this one: R'' = R' + δR ‖q − q₀‖ + slack; with bones
/// R'' = R' + σ δR ‖q − q₀‖ + max_b ‖T_b − T⁰_b‖ + slack, σ that of the other pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drift {
    /// ‖q − q₀‖ and, if it bounds anything, ‖S⁻¹ (q − q₀)‖, from above.
    norm: f32,
    scaled_norm: Option<f32>,
    /// The slack at q, and how far bones move any point; the slack at q₀ is in the radii already (stored units).
    slack: f32,
}

impl Drift {
    /// The drift from `reference` to `pose`, if both are poses of one asset.
    pub(crate) fn new(reference: &Pose<'_>, pose: &Pose<'_>) -> Option<Self> {
        let asset = pose.asset;
        if !reference.belongs_to(asset) {
            return None;
        }
        let (mut square, mut scaled_square) = (0.0, 0.0);
        let steps = pose.q().iter().zip(reference.q());
        for ((q, q0), mode) in steps.zip(asset.modes()) {
            // Exact but for one rounding: both are f32.
            let step = f64::from(*q) - f64::from(*q0);
            square += step * step;
            if step != 0.0 {
                let scaled = step / f64::from(mode.step_scale.get());
                scaled_square += scaled * scaled;
            }
        }
        // q stays below its limits, so squares are finite; a scale of 0 gives infinity.
        // Σ_b w_b ≤ 2 where weights are kept as stored, so both terms of bones count with it.
        let sum = asset.skin_record();
        let sum = 1.0 + sum.map_or(0.0, |record| f64::from(record.weight_defect));
        let stretch = f64::from(reference.stretch) * sum;
        let scaled_norm = sqrt(scaled_square) * stretch;
        let slack = match reference.bones_apart(pose) * sum {
            0.0 => pose.slack,
            apart => round_up(f64::from(pose.slack) + apart * (1.0 + MARGIN)),
        };
        Some(Self {
            norm: norm_up(sqrt(square) * stretch),
            scaled_norm: (scaled_norm < f64::from(f32::MAX) / 2.0).then(|| norm_up(scaled_norm)),
            slack,
        })
    }

    /// What eight radii grow by: `steps` are the rows δR and scaled δR of the node. The smaller of the
    /// two bounds; its product rounds by u, which the norms have in them.
    #[inline(always)]
    pub(crate) fn wide<L: Lanes>(&self, steps: &[Row; 2]) -> L {
        let mut step = L::load(&steps[0]).mul(L::splat(self.norm));
        if let Some(norm) = self.scaled_norm {
            step = step.min(L::load(&steps[1]).mul(L::splat(norm)));
        }
        step.add(L::splat(self.slack))
    }

    /// [`Drift::wide`] without vectors.
    pub(crate) fn added(&self, steps: &[Row; 2]) -> Row {
        let mut added = steps[0].map(|x| x * self.norm);
        if let Some(norm) = self.scaled_norm {
            for (x, y) in added.iter_mut().zip(&steps[1]) {
                *x = x.min(y * norm);
            }
        }
        added.map(|x| x + self.slack)
    }
}

/// An f32 above `norm` by at least 8u of it; 0 for 0.
fn norm_up(norm: f64) -> f32 {
    if norm == 0.0 {
        return 0.0;
    }
    round_up(norm * (1.0 + DRIFT))
}
