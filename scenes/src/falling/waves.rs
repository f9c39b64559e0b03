//! Where and when bodies begin to fall: in waves, each a grid above what has fallen before.
//!
//! A wave begins a little above the heap, so that no body gets fast: contact spheres must not pass through each other
//! within a step.

use bdtree_runtime::Transform;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::workloads::random::Stream;

/// The arrangement of so many bodies; equal seeds give equal arrangements.
#[derive(Debug, Clone)]
pub(crate) struct Waves {
    pub(crate) seed: u64,
    /// Bodies in all.
    pub(crate) count: usize,
    /// Bodies of a wave along x and z, at most.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Distance of neighbors in a wave, from center of mass to center of mass, m.
    pub(crate) spacing: f64,
    /// Height of a center of mass above the ground, or above those below it, m.
    pub(crate) above: f64,
    /// Steps from a wave to the next.
    pub(crate) every: u64,
    /// Of the mesh: center of mass, and world units per mesh unit.
    pub(crate) center: Vector3<f64>,
    pub(crate) scale: f64,
    /// What bodies fall onto; nothing for flat ground.
    pub(crate) onto: Option<Heights>,
}

/// How high something reaches along x, m: equal parts from `from` on.
#[derive(Debug, Clone)]
pub(crate) struct Heights {
    pub(crate) from: f64,
    pub(crate) part: f64,
    pub(crate) tops: Vec<f64>,
}

impl Heights {
    /// The highest within `reach` of x.
    fn over(&self, x: f64, reach: f64) -> f64 {
        let part = |x: f64| ((x - self.from) / self.part).max(0.0) as usize;
        let last = self.tops.len().saturating_sub(1);
        let (first, end) = (part(x - reach).min(last), part(x + reach).min(last));
        let tops = self.tops.get(first..=end).unwrap_or_default();
        tops.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Waves {
    /// How far a wave's bodies are from the middle, at most, along x.
    pub(crate) fn half_width(&self) -> f64 {
        0.5 * self.spacing * self.columns as f64
    }

    /// Number of waves.
    pub(crate) fn waves(&self) -> usize {
        self.count.div_ceil(self.columns * self.rows)
    }

    /// The bodies that begin to fall before a step, where others have their centers of mass already.
    pub(crate) fn before(&self, step: u64, others: &[[f64; 3]]) -> Vec<Transform> {
        let each = self.columns * self.rows;
        let is_due =
            step.is_multiple_of(self.every) && step / self.every == (others.len() / each) as u64;
        let left = self.count - others.len().min(self.count);
        if !is_due {
            return Vec::new();
        }
        let size = left.min(each);
        let wave = step / self.every;
        // Numbers depend on the wave alone, so that a run goes on from a checkpoint as it would have.
        let mut stream = Stream::new(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ wave);
        // Not all waves fall onto the same places.
        let shift = match wave {
            0 => [0.0; 2],
            _ => [0, 1].map(|_| 0.25 * self.spacing * stream.signed()),
        };
        let columns = self.columns;
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
            let chance = stream.unit();
            let over = highest.map(|highest| highest.max(0.0) + self.above + 0.2 * chance);
            let y = match &self.onto {
                None => over.unwrap_or(1.0 + chance),
                Some(onto) => {
                    let free = onto.over(x, 0.5 * self.spacing) + self.above + chance;
                    over.map_or(free, |over| over.max(free))
                }
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
            translation: (Vector3::from(at) - turn * self.center * self.scale).into(),
            scale: self.scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The waves of so many bodies on the ground.
    fn waves(seed: u64, count: usize, side: usize, center: [f64; 3]) -> Waves {
        Waves {
            seed,
            count,
            columns: side,
            rows: side,
            spacing: 1.3,
            above: 1.5,
            every: 150,
            center: center.into(),
            scale: 1.0,
            onto: None,
        }
    }

    fn centers(waves: &Waves, all: &[Transform]) -> Vec<[f64; 3]> {
        let center = |at: &Transform| {
            let [x, y, z, w] = at.rotation;
            let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            (turn * waves.center * waves.scale + Vector3::from(at.translation)).into()
        };
        all.iter().map(center).collect()
    }

    #[test]
    fn twelve_bodies_are_one_wave_from_one_to_two_metres() {
        let waves_of = |seed: u64| waves(seed, 12, 4, [0.1, 0.4, -0.2]);
        let waves = waves_of(1);
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
        assert_ne!(waves_of(2).before(0, &[]), first);
    }

    #[test]
    fn waves_are_above_what_has_fallen() {
        let waves = waves(1, 400, 13, [0.0; 3]);
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

    /// Onto a roof that rises along x: above the highest part near each body, and above what falls there already.
    #[test]
    fn waves_are_above_what_they_fall_onto() {
        let roof = Waves {
            columns: 10,
            rows: 2,
            scale: 2.5,
            onto: Some(Heights {
                from: -6.5,
                part: 1.3,
                tops: (0..10).map(f64::from).collect(),
            }),
            ..waves(1, 60, 0, [0.1, 0.0, 0.0])
        };
        let first = centers(&roof, &roof.before(0, &[]));
        assert_eq!(first.len(), 20);
        for [x, y, _] in &first {
            let top = ((x + 6.5) / 1.3).floor();
            assert!((top + 1.499..top + 3.6).contains(y), "{x} {y}");
        }
        let second = centers(&roof, &roof.before(150, &first));
        assert_eq!(second.len(), 20);
        for (a, b) in first
            .iter()
            .flat_map(|a| second.iter().map(move |b| (a, b)))
        {
            let apart = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            assert!(apart > 1.29, "{apart}");
        }
    }
}
