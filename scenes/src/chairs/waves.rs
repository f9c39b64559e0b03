//! Where and when chairs begin to fall: in waves, each a square grid above what has fallen before.
//!
//! A wave begins a little above the heap, so that no chair gets much faster than 6 m/s: contact spheres must not pass
//! through each other within a step.

use bdtree_runtime::Transform;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::workloads::random::Stream;

/// Distance of neighbors in a wave, from center of mass to center of mass, m; more for larger bodies.
const SPACING: f64 = 1.3;

/// Chairs along a side of a wave, at most: with 3601 chairs, 22 waves make a heap several meters high.
const SIDE_MAX: usize = 13;

/// Height of a chair's center of mass above the ground, or above those below it, m.
const ABOVE: f64 = 1.5;

/// Steps from a wave to the next.
const EVERY: u64 = 150;

/// The arrangement of so many chairs; equal seeds give equal arrangements.
#[derive(Debug, Clone)]
pub(super) struct Waves {
    seed: u64,
    count: usize,
    side: usize,
    spacing: f64,
    /// Of the mesh: center of mass.
    center: Vector3<f64>,
}

impl Waves {
    /// `extent` is how far a body reaches from its center of mass.
    pub(super) fn new(seed: u64, count: usize, center: [f64; 3], extent: f64) -> Self {
        Self {
            seed,
            count,
            side: ((count as f64).sqrt().ceil() as usize).clamp(1, SIDE_MAX),
            spacing: f64::max(SPACING, 2.1 * extent),
            center: center.into(),
        }
    }

    /// How far a wave's chairs are from the middle, at most, along an axis.
    pub(super) fn half_width(&self) -> f64 {
        0.5 * self.spacing * self.side as f64
    }

    /// Number of waves.
    pub(super) fn waves(&self) -> usize {
        self.count.div_ceil(self.side * self.side)
    }

    /// The chairs that begin to fall before a step, where others have their centers of mass already.
    pub(super) fn before(&self, step: u64, others: &[[f64; 3]]) -> Vec<Transform> {
        let each = self.side * self.side;
        let is_due = step.is_multiple_of(EVERY) && step / EVERY == (others.len() / each) as u64;
        let left = self.count - others.len().min(self.count);
        if !is_due {
            return Vec::new();
        }
        let size = left.min(each);
        let wave = step / EVERY;
        // Numbers depend on the wave alone, so that a run goes on from a checkpoint as it would have.
        let mut stream = Stream::new(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ wave);
        // Not all waves fall onto the same places.
        let shift = match wave {
            0 => [0.0; 2],
            _ => [0, 1].map(|_| 0.25 * self.spacing * stream.signed()),
        };
        let columns = self.side;
        let rows = size.div_ceil(columns);
        let place = |k: usize| {
            let (column, row) = (k % columns, k / columns);
            let along = |at: usize, of: usize| (at as f64 - 0.5 * (of as f64 - 1.0)) * self.spacing;
            [
                along(column, columns) + shift[0],
                along(row, rows) + shift[1],
            ]
        };
        let fall = |k: usize| {
            let [x, z] = place(k);
            let below = others
                .iter()
                .filter(|[a, _, b]| (a - x).hypot(b - z) < self.spacing);
            let highest = below.map(|at| at[1]).reduce(f64::max);
            let y = match highest {
                Some(highest) => highest.max(0.0) + ABOVE + 0.2 * stream.unit(),
                None => 1.0 + stream.unit(),
            };
            self.placed([x, y, z], stream.rotation())
        };
        (0..size).map(fall).collect()
    }

    /// The mesh turned about its center of mass, and that put to a place.
    fn placed(&self, at: [f64; 3], rotation: [f64; 4]) -> Transform {
        let [x, y, z, w] = rotation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Transform {
            rotation,
            translation: (Vector3::from(at) - turn * self.center).into(),
            scale: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn centers(waves: &Waves, all: &[Transform]) -> Vec<[f64; 3]> {
        let center = |at: &Transform| {
            let [x, y, z, w] = at.rotation;
            let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            (turn * waves.center + Vector3::from(at.translation)).into()
        };
        all.iter().map(center).collect()
    }

    #[test]
    fn twelve_chairs_are_one_wave_from_one_to_two_metres() {
        let waves = Waves::new(1, 12, [0.1, 0.4, -0.2], 0.6);
        let first = waves.before(0, &[]);
        assert_eq!(first.len(), 12);
        let centers = centers(&waves, &first);
        for (k, a) in centers.iter().enumerate() {
            assert!((1.0..2.0).contains(&a[1]), "{a:?}");
            for b in &centers[..k] {
                let apart = (a[0] - b[0]).hypot(a[2] - b[2]);
                assert!(apart > 1.299, "{apart}");
            }
        }
        assert!(waves.before(150, &centers).is_empty());
        assert_eq!(waves.before(0, &[]), first);
        assert_ne!(
            Waves::new(2, 12, [0.1, 0.4, -0.2], 0.6).before(0, &[]),
            first
        );
    }

    #[test]
    fn waves_are_above_what_has_fallen() {
        let waves = Waves::new(1, 400, [0.0; 3], 0.6);
        let mut all = Vec::new();
        for (step, size) in [(0, 169), (150, 169), (300, 62), (450, 0)] {
            assert!(waves.before(step + 1, &all).is_empty());
            let next = centers(&waves, &waves.before(step, &all));
            assert_eq!(next.len(), size, "{step}");
            for a in &next {
                for b in &all {
                    let apart = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
                    assert!(apart > 1.29, "{apart}");
                }
            }
            all.extend(next);
        }
        assert_eq!(all.len(), 400);
    }
}
