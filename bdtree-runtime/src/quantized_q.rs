//! q in whole numbers: what node bounds take of a pose (docs/design/guarantees.md, shares).
//!
//! A node's sums over modes are exact, because both its rows and q are whole numbers. So bounds are
//! those of another pose q̃ that is close to q, and what the two differ by is added to every radius.

use bdtree_format::ModeRecord;

use crate::rounding::{RATIO_MIN, SCALE_MIN, round_up};

/// Σ |n_j| is at most this: times 2¹⁵ it fits 32 bits.
const TOTAL_MAX: f64 = 65_535.0;

/// Largest |n_j|: that of an `i16` whose opposite is one too.
const LARGEST: f64 = 32_767.0;

/// A pose's q̃ of q̃_j = (n_j + ρ m_j) λ `q_limit`_j, two modes side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QuantizedQ<'p> {
    /// n.
    pub(crate) coarse: &'p [[i16; 2]],
    /// m, of the same signs; empty where q̃ has one part only.
    pub(crate) fine: &'p [[i16; 2]],
    /// The pairs that are not zero, ascending.
    pub(crate) active: &'p [u32],
    /// λ.
    pub(crate) scale: f32,
    /// ρ.
    pub(crate) ratio: f32,
    pub(crate) mode_count: usize,
}

/// Memory for [`QuantizedQ`]: one entry each for every two modes.
pub(crate) struct Memory<'p> {
    pub(crate) coarse: &'p mut [[i16; 2]],
    pub(crate) fine: &'p mut [[i16; 2]],
    pub(crate) active: &'p mut [u32],
}

/// q, finite and within its limits, with the records of its modes.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) modes: &'a [ModeRecord],
    pub(crate) q: &'a [f32],
}

/// One mode of q.
struct Mode {
    /// `q_j` over its limit: exact, since limits are powers of two.
    share: f64,
    /// `W_j` `q_limit`_j: exact.
    weight: f64,
}

impl Mode {
    fn of((record, q): (&ModeRecord, &f32)) -> Self {
        let limit = record.q_limit.get();
        Self {
            share: f64::from(*q) * reciprocal(limit),
            weight: f64::from(record.field_norm_max.get()) * f64::from(limit),
        }
    }

    /// How far a vertex is moved by the difference to another share, at most.
    fn off(&self, share: f64) -> f64 {
        self.weight * (self.share - share).abs()
    }
}

impl<'a> Given<'a> {
    fn each(self) -> impl Iterator<Item = Mode> + use<'a> {
        self.modes.iter().zip(self.q).map(Mode::of)
    }

    /// How far a pair moves a vertex at most.
    #[inline(never)] // a sort that compares in dozens of places calls it
    fn reach(self, k: u32) -> f64 {
        let modes = self.modes.chunks(2).nth(k as usize).unwrap_or_default();
        let q = self.q.chunks(2).nth(k as usize).unwrap_or_default();
        let pair = Given { modes, q };
        pair.each().map(|mode| mode.off(0.0)).sum()
    }

    /// q̃ and Σ `W_j` |q_j − q̃_j|.
    ///
    /// The pairs that move least are left out as long as they move no vertex by more than
    /// `tolerance` together. q̃ has a second part where one alone would be off by more than `coarse`
    /// (all in stored units).
    pub(crate) fn round<'p>(
        self,
        tolerance: f64,
        coarse: f64,
        memory: Memory<'p>,
    ) -> (QuantizedQ<'p>, f64) {
        let Memory {
            coarse: first,
            fine: second,
            active,
        } = memory;
        let count = self.q.len();
        let left_out = self.drop_least(tolerance, first, active);
        let n = first.as_flattened_mut();
        n[count..].fill(0); // the mode that an odd count lacks

        let shares = self
            .each()
            .zip(&*n)
            .map(|(mode, kept)| mode.share * f64::from(*kept));
        let scale = round_up(Size::of(shares).unit(count).max(SCALE_MIN));
        let wide = f64::from(scale);
        let per_wide = 1.0 / wide;
        // What is left out is off by all of it.
        let mut off = 0.0;
        for (mode, n) in self.each().zip(&mut *n) {
            let nearest = Nearest::to(mode.share * per_wide * f64::from(*n));
            off += mode.off(nearest.value * wide);
            *n = nearest.number;
        }

        let mut ratio = 0.0;
        let in_two = off - left_out > coarse;
        if in_two {
            self.drop_least(tolerance, second, active);
            let m = second.as_flattened_mut();
            m[count..].fill(0);
            // The first part towards zero, so that the second has its sign: where rounding makes the
            // first too large, what remains is below 2⁻⁶ of a step and the second is 0.
            let parts = |mode: &Mode, kept: i16| {
                let share = mode.share * f64::from(kept);
                let n = (share * per_wide) as i16;
                (n, share - f64::from(n) * wide)
            };
            let rests = self
                .each()
                .zip(&*m)
                .map(|(mode, kept)| parts(&mode, *kept).1);
            ratio = round_up((Size::of(rests).unit(count) * per_wide).max(RATIO_MIN));
            let step = wide * f64::from(ratio);
            off = 0.0;
            for ((mode, n), m) in self.each().zip(n).zip(m) {
                let (number, rest) = parts(&mode, *m);
                let nearest = Nearest::to(rest / step);
                off += mode.off(f64::from(number) * wide + nearest.value * step);
                (*n, *m) = (number, nearest.number);
            }
        }
        let fine: &[[i16; 2]] = if in_two { second } else { &[] };

        // Pairs that came out zero are nothing to sum.
        let mut used = 0;
        for (k, n) in first.iter().enumerate() {
            if *n != [0; 2] || fine.get(k).is_some_and(|m| *m != [0; 2]) {
                active[used] = k as u32;
                used += 1;
            }
        }
        let shares = QuantizedQ {
            coarse: first,
            fine,
            active: &active[..used],
            scale,
            ratio,
            mode_count: count,
        };
        (shares, off)
    }

    /// Marks the pairs that stay in `kept` by ones, the others by zeros; by how much these move a vertex
    /// at most. `order` is overwritten.
    fn drop_least(self, tolerance: f64, kept: &mut [[i16; 2]], order: &mut [u32]) -> f64 {
        kept.fill([1; 2]);
        let mut left_out = 0.0;
        if tolerance == 0.0 {
            return left_out;
        }
        for (k, pair) in (0..).zip(order.iter_mut()) {
            *pair = k;
        }
        order.sort_unstable_by(|a, b| self.reach(*a).total_cmp(&self.reach(*b)));
        for &k in order.iter() {
            let with = left_out + self.reach(k);
            if with > tolerance {
                break;
            }
            left_out = with;
            if let Some(kept) = kept.get_mut(k as usize) {
                *kept = [0; 2];
            }
        }
        left_out
    }
}

/// Largest magnitude and sum of magnitudes.
#[derive(Default)]
struct Size {
    largest: f64,
    total: f64,
}

impl Size {
    /// Of numbers that are not NaN.
    fn of(numbers: impl Iterator<Item = f64>) -> Self {
        let mut size = Self::default();
        for x in numbers {
            let x = x.abs();
            size.largest = if x > size.largest { x } else { size.largest };
            size.total += x;
        }
        size
    }

    /// A unit in which `count` such numbers, rounded to the nearest, keep the limits above.
    fn unit(&self, count: usize) -> f64 {
        (self.largest / LARGEST).max(self.total / (TOTAL_MAX - count as f64))
    }
}

/// Of a power of two from 2⁻¹²⁶ to 2¹²⁶, as limits are: exact, and no division.
fn reciprocal(limit: f32) -> f64 {
    // The exponents of a number and its reciprocal add up to twice the bias.
    f64::from(f32::from_bits((254 << 23) - limit.to_bits()))
}

/// A whole number of 16 bits.
struct Nearest {
    number: i16,
    value: f64,
}

impl Nearest {
    /// The nearest to x, of less than 2¹⁵ in magnitude; ties go to the even one.
    fn to(x: f64) -> Self {
        /// Beside it no fractions are left, and the number is in the lowest bits.
        const BIG: f64 = 1.5 * (1_u64 << 52) as f64;
        let sum = x + BIG;
        Self {
            number: sum.to_bits() as i16,
            value: sum - BIG,
        }
    }
}
