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
        let m = self.asset.mode_count();
        let mut q = match k % KINDS {
            0 => self.spread(),
            1 => self.one_mode(),
            2 => self.alternating(),
            3 => self.near_limits(),
            4 => self.tiny(),
            5 => self.equal_reach(),
            6 => self.one_large(),
            7 => self.cancelling(),
            _ => vec![0.0; m],
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

    fn modes(&self) -> std::ops::Range<usize> {
        0..self.asset.mode_count()
    }

    fn sign(&mut self) -> f32 {
        if self.rng.random_range(0..2) == 0 {
            1.0
        } else {
            -1.0
        }
    }

    /// 10^x, x evenly between two exponents.
    fn power(&mut self, exponents: std::ops::Range<f32>) -> f32 {
        10.0_f32.powf(self.rng.random_range(exponents))
    }

    /// All modes at random within one size.
    fn spread(&mut self) -> Vec<f32> {
        let size = self.power(-6.0..1.5);
        self.modes()
            .map(|j| size * self.range(j) * self.rng.random_range(-1.0..1.0))
            .collect()
    }

    fn one_mode(&mut self) -> Vec<f32> {
        let mut q = vec![0.0; self.asset.mode_count()];
        if !q.is_empty() {
            let j = self.rng.random_range(0..q.len());
            q[j] = self.sign() * self.power(-6.0..2.0) * self.range(j);
        }
        q
    }

    fn alternating(&mut self) -> Vec<f32> {
        let size = self.sign() * self.power(-4.0..1.5);
        let sign = |j: usize| if j.is_multiple_of(2) { size } else { -size };
        self.modes().map(|j| sign(j) * self.range(j)).collect()
    }

    /// At the limit, just below it, or 0.
    fn near_limits(&mut self) -> Vec<f32> {
        self.modes()
            .map(|j| {
                let limit = self.asset.modes()[j].q_limit.get();
                let below = f32::from_bits(limit.to_bits() - self.rng.random_range(0..3));
                [below, -below, 0.0][self.rng.random_range(0..3)]
            })
            .collect()
    }

    /// Subnormal numbers, the least normal one, and others that hardly move anything.
    fn tiny(&mut self) -> Vec<f32> {
        let sizes = [
            0.0,
            f32::from_bits(1),
            f32::MIN_POSITIVE,
            1e-36,
            1e-30,
            1e-20,
        ];
        self.modes()
            .map(|_| self.sign() * sizes[self.rng.random_range(0..sizes.len())])
            .collect()
    }

    /// Every mode moves its farthest vertex equally far.
    fn equal_reach(&mut self) -> Vec<f32> {
        let largest = self.asset.header().position_norm_max.get();
        let size = largest * self.power(-5.0..1.5);
        self.modes()
            .map(|j| {
                let reach = self.asset.modes()[j].field_norm_max.get();
                self.sign() * size / reach.max(f32::MIN_POSITIVE)
            })
            .collect()
    }

    /// One mode beside others that are far smaller.
    fn one_large(&mut self) -> Vec<f32> {
        let small = self.power(-30.0..-3.0);
        let mut q: Vec<f32> = self
            .modes()
            .map(|j| self.sign() * small * self.range(j))
            .collect();
        if !q.is_empty() {
            let j = self.rng.random_range(0..q.len());
            q[j] = self.sign() * self.power(-1.0..1.0) * self.range(j);
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
