//! q that is hard on bounds: every size, from nothing to the limit, in every company.

use bdtree_runtime::{Asset, VertexId};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Kinds of q that [`HardPoses::kind`] makes.
pub(super) const KINDS: u64 = 9;

/// A generator of q within the limits of an asset.
pub(super) struct HardPoses<'a> {
    asset: Asset<'a>,
    rng: Pcg64Mcg,
}

impl<'a> HardPoses<'a> {
    /// `stream` tells generators of one seed apart.
    pub(super) fn new(asset: Asset<'a>, seed: u64, stream: u64) -> Self {
        // Neighbouring numbers must not give related sequences.
        let mixed = seed ^ stream.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Self {
            asset,
            rng: Pcg64Mcg::seed_from_u64(mixed),
        }
    }

    pub(super) fn rng(&mut self) -> &mut Pcg64Mcg {
        &mut self.rng
    }

    /// q of kind `k` (modulo [`KINDS`]).
    pub(super) fn kind(&mut self, k: u64) -> Vec<f32> {
        let mut q = match k % KINDS {
            // All modes at random within one size.
            0 => {
                let size = self.power(-6.0..1.5);
                self.each(|own, j| size * own.range(j) * own.rng.random_range(-1.0..1.0))
            }
            1 => self.with_one(vec![0.0; self.asset.mode_count()], -6.0..2.0),
            // Of alternating sign.
            2 => {
                let size = self.sign() * self.power(-4.0..1.5);
                let sign = |j: usize| if j.is_multiple_of(2) { size } else { -size };
                self.each(|own, j| sign(j) * own.range(j))
            }
            // At the limit, just below it, or 0.
            3 => self.each(|own, j| {
                let limit = own.asset.modes()[j].q_limit.get();
                let below = f32::from_bits(limit.to_bits() - own.rng.random_range(0..3));
                [below, -below, 0.0][own.rng.random_range(0..3)]
            }),
            // Subnormal numbers, the least normal one, and others that hardly move anything.
            4 => {
                let subnormal = f32::from_bits(1);
                let sizes = [0.0, subnormal, f32::MIN_POSITIVE, 1e-36, 1e-30, 1e-20];
                self.each(|own, _| own.sign() * sizes[own.rng.random_range(0..sizes.len())])
            }
            // Every mode moves its farthest vertex equally far.
            5 => {
                let largest = self.asset.header().position_norm_max.get();
                let size = largest * self.power(-5.0..1.5);
                self.each(|own, j| {
                    let reach = own.asset.modes()[j].field_norm_max.get();
                    own.sign() * size / reach.max(f32::MIN_POSITIVE)
                })
            }
            // One mode beside others that are far smaller.
            6 => {
                let small = self.power(-30.0..-3.0);
                let q = self.each(|own, j| own.sign() * small * own.range(j));
                self.with_one(q, -1.0..1.0)
            }
            7 => self.cancelling(),
            _ => vec![0.0; self.asset.mode_count()],
        };
        self.clamp(&mut q);
        q
    }

    /// Puts every entry within its mode's limit.
    pub(super) fn clamp(&self, q: &mut [f32]) {
        for (q, mode) in q.iter_mut().zip(self.asset.modes()) {
            let limit = mode.q_limit.get();
            *q = if q.is_nan() {
                0.0
            } else {
                q.clamp(-limit, limit)
            };
        }
    }

    fn range(&self, j: usize) -> f32 {
        self.asset.modes()[j].q_range.get()
    }

    fn each(&mut self, of: impl Fn(&mut Self, usize) -> f32) -> Vec<f32> {
        (0..self.asset.mode_count()).map(|j| of(self, j)).collect()
    }

    fn sign(&mut self) -> f32 {
        match self.rng.random_range(0..2) {
            0 => 1.0,
            _ => -1.0,
        }
    }

    /// 10^x, x evenly between two exponents.
    fn power(&mut self, exponents: std::ops::Range<f32>) -> f32 {
        10.0_f32.powf(self.rng.random_range(exponents))
    }

    /// `q` with a mode at random of another size, over its range.
    fn with_one(&mut self, mut q: Vec<f32>, exponents: std::ops::Range<f32>) -> Vec<f32> {
        if !q.is_empty() {
            let j = self.rng.random_range(0..q.len());
            q[j] = self.sign() * self.power(exponents) * self.range(j);
        }
        q
    }

    /// A vertex ends near the plane through the origin that is normal to its rest position: what it
    /// is made of is much larger than what comes out.
    fn cancelling(&mut self) -> Vec<f32> {
        let mut q = vec![0.0; self.asset.mode_count()];
        let i = self.rng.random_range(0..self.asset.vertex_count() as u32);
        let p = self.asset.positions()[i as usize].map(f64::from);
        let Ok(fields) = self.asset.displacements(VertexId(i)) else {
            return q;
        };
        let along = |u: [f32; 3]| (0..3).map(|k| p[k] * f64::from(u[k])).sum::<f64>();
        let squares: f64 = fields.iter().map(|(_, u)| along(u).powi(2)).sum();
        let square: f64 = p.iter().map(|x| x * x).sum();
        // A little more or less than what cancels.
        let share = 1.0 + f64::from(self.sign() * self.power(-9.0..-1.0));
        if squares > 0.0 {
            for (mode, u) in fields.iter() {
                q[mode] = (-share * square / squares * along(u)) as f32;
            }
        }
        q
    }
}
