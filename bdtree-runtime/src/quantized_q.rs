//! q in whole numbers: what node bounds take of a pose (docs/design/guarantees.md, shares).
//!
//! A node's sums over modes are exact, because both its rows and q are whole numbers. So bounds are
//! those of another pose q̃ that is close to q, and what the two differ by is added to every radius.

use bdtree_format::ModeRecord;
use zerocopy::little_endian::{F32, F64};

use crate::rounding::{RATIO_MIN, SCALE_MIN, round_up};
use crate::simd::{Lanes, Quad, Work};

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

/// A mode that is not there.
const STILL: ModeRecord = ModeRecord {
    q_limit: F32::new(1.0),
    q_range: F32::new(1.0),
    step_scale: F32::new(1.0),
    field_norm_max: F32::new(0.0),
    omega_rad_s: F64::new(-1.0),
    modal_mass_kg: F64::new(-1.0),
};

/// Four modes of q side by side; those that are not there are still and move nothing.
#[derive(Clone, Copy)]
struct Modes<Q> {
    /// `q_j` over its limit: exact, since limits are powers of two.
    share: Q,
    /// `W_j` `q_limit`_j: exact.
    weight: Q,
}

impl<Q: Quad> Modes<Q> {
    #[inline(always)]
    fn of(records: &[ModeRecord], q: &[f32]) -> Self {
        let (records, q) = match (records.first_chunk(), q.first_chunk()) {
            (Some([a, b, c, d]), Some(q)) => ([a, b, c, d], *q),
            _ => {
                let (mut last, mut rest) = ([&STILL; 4], [0.0; 4]);
                for k in 0..records.len().min(q.len()).min(4) {
                    (last[k], rest[k]) = (&records[k], q[k]);
                }
                (last, rest)
            }
        };
        // Four numbers that follow each other in the file are one load.
        let mut rows = [Q::splat(0.0); 4];
        for k in 0..4 {
            let record = records[k];
            rows[k] = Q::widen(&[
                record.q_limit.get(),
                record.q_range.get(),
                record.step_scale.get(),
                record.field_norm_max.get(),
            ]);
        }
        let [limit, _, _, norm] = Q::transposed(rows);
        Self {
            share: Q::widen(&q).div(limit),
            weight: norm.mul(limit),
        }
    }

    /// How far a vertex is moved by the difference to other shares, at most.
    #[inline(always)]
    fn off(&self, shares: Q) -> Q {
        self.weight.mul(self.share.sub(shares).abs())
    }
}

/// Modes of which [`Fours`] keeps what it reads: one kilobyte.
const KEPT: usize = 64;

/// The given modes, four side by side. What rounding reads of the first ones is kept, because each pass asks for it again.
struct Fours<'a, Q> {
    given: Given<'a>,
    first: [Modes<Q>; KEPT / 4],
}

impl<'a, Q: Quad> Fours<'a, Q> {
    #[inline(always)]
    fn of(given: Given<'a>) -> Self {
        let zero = Q::splat(0.0);
        let still = Modes {
            share: zero,
            weight: zero,
        };
        let mut first = [still; KEPT / 4];
        let fours = given.modes.chunks(4).zip(given.q.chunks(4));
        for (kept, (modes, q)) in first.iter_mut().zip(fours) {
            *kept = Modes::of(modes, q);
        }
        Self { given, first }
    }

    /// Modes 4k to 4k + 3.
    #[inline(always)]
    fn at(&self, k: usize) -> Modes<Q> {
        match self.first.get(k) {
            Some(kept) => *kept,
            None => {
                core::hint::cold_path();
                let Given { modes, q } = self.given;
                let (modes, q) = (modes.get(4 * k..), q.get(4 * k..));
                Modes::of(modes.unwrap_or_default(), q.unwrap_or_default())
            }
        }
    }
}

/// Whole numbers, an even count of them, four side by side; what the last four lack is 0.
struct Wholes<'a> {
    fours: &'a mut [[i16; 4]],
    rest: &'a mut [i16],
    last: [i16; 4],
}

impl<'a> Wholes<'a> {
    #[inline(always)]
    fn of(numbers: &'a mut [i16]) -> Self {
        let (fours, rest) = numbers.as_chunks_mut();
        let last = match rest {
            [a, b] => [*a, *b, 0, 0],
            _ => [0; 4],
        };
        Self { fours, rest, last }
    }

    /// How many fours there are.
    #[inline(always)]
    fn count(&self) -> usize {
        self.fours.len() + usize::from(!self.rest.is_empty())
    }

    #[inline(always)]
    fn at(&mut self, k: usize) -> &mut [i16; 4] {
        self.fours.get_mut(k).unwrap_or(&mut self.last)
    }

    /// Writes the last four.
    #[inline(always)]
    fn end(self) {
        if let ([a, b], [x, y, ..]) = (self.rest, self.last) {
            (*a, *b) = (x, y);
        }
    }
}

impl Given<'_> {
    /// How far a pair moves a vertex at most.
    #[inline(never)] // a sort that compares in dozens of places calls it
    fn reach(self, k: u32) -> f64 {
        let modes = self.modes.chunks(2).nth(k as usize).unwrap_or_default();
        let q = self.q.chunks(2).nth(k as usize).unwrap_or_default();
        let norms = modes
            .iter()
            .map(|mode| f64::from(mode.field_norm_max.get()));
        norms
            .zip(q)
            .map(|(norm, q)| norm * f64::from(q.abs()))
            .sum()
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

/// What rounding makes of q.
pub(crate) struct Rounded<'p> {
    /// q̃.
    pub(crate) quantized: QuantizedQ<'p>,
    /// Σ `W_j` |q_j − q̃_j|.
    pub(crate) off: f64,
    /// Σ `W_j` |q_j|.
    pub(crate) reach: f64,
}

/// Rounds q to q̃, four modes side by side.
///
/// The pairs that move least are left out as long as they move no vertex by more than
/// `tolerance` together. q̃ has a second part where one alone would be off by more than `coarse`
/// (all in stored units).
pub(crate) struct Rounding<'a, 'p> {
    pub(crate) given: Given<'a>,
    pub(crate) tolerance: f64,
    pub(crate) coarse: f64,
    pub(crate) memory: Memory<'p>,
}

impl<'p> Work for Rounding<'_, 'p> {
    type Output = Rounded<'p>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Rounded<'p> {
        let Self {
            given,
            tolerance,
            coarse,
            memory,
        } = self;
        let Memory {
            coarse: first,
            fine: second,
            active,
        } = memory;
        let count = given.q.len();
        let fours = Fours::<L::Quad>::of(given);
        // Nothing is left out: then marks need not be read.
        let is_whole = tolerance == 0.0;
        let left_out = given.drop_least(tolerance, first, active);
        let n = first.as_flattened_mut();
        n[count..].fill(0); // the mode that an odd count lacks

        let zero = L::Quad::splat(0.0);
        let mut reach = zero;
        let mut size = Size::<L::Quad>::new();
        let mut n = Wholes::of(n);
        for k in 0..n.count() {
            let four = fours.at(k);
            reach = reach.add(four.off(zero));
            size.hold(marked(four.share, n.at(k), is_whole));
        }
        let scale = round_up(size.unit(count).max(SCALE_MIN));
        let wide = L::Quad::splat(f64::from(scale));
        let per_wide = L::Quad::splat(1.0 / f64::from(scale));
        // What is left out is off by all of it.
        let mut sum = zero;
        for k in 0..n.count() {
            let (four, n) = (fours.at(k), n.at(k));
            let nearest = Whole::nearest(marked(four.share.mul(per_wide), n, is_whole));
            sum = sum.add(four.off(nearest.value.mul(wide)));
            *n = nearest.bits();
        }
        let mut off = total(sum);

        let mut ratio = 0.0;
        let in_two = off - left_out > coarse;
        if in_two {
            given.drop_least(tolerance, second, active);
            let m = second.as_flattened_mut();
            m[count..].fill(0);
            let mut size = Size::<L::Quad>::new();
            let mut m = Wholes::of(m);
            for k in 0..m.count() {
                let share = marked(fours.at(k).share, m.at(k), is_whole);
                // The first part towards zero, so that the second has its sign: where rounding makes the
                // first too large, what remains is below 2⁻⁶ of a step and the second is 0.
                let first = Whole::towards_zero(share.mul(per_wide));
                size.hold(share.sub(first.value.mul(wide)));
            }
            ratio = round_up((size.unit(count) / f64::from(scale)).max(RATIO_MIN));
            let step = wide.mul(L::Quad::splat(f64::from(ratio)));
            let mut sum = zero;
            for k in 0..m.count() {
                let (four, m) = (fours.at(k), m.at(k));
                let share = marked(four.share, m, is_whole);
                let first = Whole::towards_zero(share.mul(per_wide));
                let coarse = first.value.mul(wide);
                let rest = Whole::nearest(share.sub(coarse).div(step));
                sum = sum.add(four.off(coarse.add(rest.value.mul(step))));
                *n.at(k) = first.bits();
                *m = rest.bits();
            }
            m.end();
            off = total(sum);
        }
        n.end();
        let fine: &[[i16; 2]] = if in_two { second } else { &[] };

        // Pairs that came out zero are nothing to sum.
        let mut used = 0;
        for (k, n) in first.iter().enumerate() {
            if *n != [0; 2] || fine.get(k).is_some_and(|m| *m != [0; 2]) {
                active[used] = k as u32;
                used += 1;
            }
        }
        Rounded {
            quantized: QuantizedQ {
                coarse: first,
                fine,
                active: &active[..used],
                scale,
                ratio,
                mode_count: count,
            },
            off,
            reach: total(reach),
        }
    }
}

/// 0 where the mark of a mode is 0.
#[inline(always)]
fn marked<Q: Quad>(numbers: Q, marks: &[i16; 4], is_whole: bool) -> Q {
    if is_whole {
        return numbers;
    }
    let [a, b, c, d] = *marks;
    numbers.mul(Q::load(&[a.into(), b.into(), c.into(), d.into()]))
}

/// The sum of all four, in the same order everywhere.
#[inline(always)]
fn total<Q: Quad>(sums: Q) -> f64 {
    let [a, b, c, d] = sums.store();
    (a + b) + (c + d)
}

/// Largest magnitude and sum of magnitudes, of every fourth mode.
struct Size<Q> {
    largest: Q,
    total: Q,
}

impl<Q: Quad> Size<Q> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            largest: Q::splat(0.0),
            total: Q::splat(0.0),
        }
    }

    /// Counts numbers that are not NaN.
    #[inline(always)]
    fn hold(&mut self, numbers: Q) {
        let size = numbers.abs();
        self.largest = size.max(self.largest);
        self.total = self.total.add(size);
    }

    /// A unit in which `count` such numbers, rounded to the nearest, keep the limits above.
    #[inline(always)]
    fn unit(&self, count: usize) -> f64 {
        let [a, b, c, d] = self.largest.store();
        let largest = a.max(b).max(c.max(d));
        (largest / LARGEST).max(total(self.total) / (TOTAL_MAX - count as f64))
    }
}

/// Four whole numbers of 16 bits.
struct Whole<Q> {
    value: Q,
    /// Its value beside [`BIG`].
    beside: Q,
}

/// Beside it no fractions are left, and the number is in the lowest bits.
const BIG: f64 = 1.5 * (1_u64 << 52) as f64;

impl<Q: Quad> Whole<Q> {
    /// The nearest to x, of less than 2¹⁵ in magnitude; ties go to the even one.
    #[inline(always)]
    fn nearest(x: Q) -> Self {
        let beside = x.add(Q::splat(BIG));
        Self {
            value: beside.sub(Q::splat(BIG)),
            beside,
        }
    }

    /// The next to x, of less than 2¹⁵ in magnitude, that is not farther from 0.
    #[inline(always)]
    fn towards_zero(x: Q) -> Self {
        let (size, one) = (x.abs(), Q::splat(1.0));
        let nearest = size.add(Q::splat(BIG)).sub(Q::splat(BIG));
        let below = Q::select(nearest.above(size), nearest.sub(one), nearest);
        let zero = Q::splat(0.0);
        Self::nearest(Q::select(zero.above(x), zero.sub(below), below))
    }

    #[inline(always)]
    fn bits(&self) -> [i16; 4] {
        let [a, b, c, d] = self.beside.store();
        // Spelled out: `array::map` is left as calls.
        [
            a.to_bits() as i16,
            b.to_bits() as i16,
            c.to_bits() as i16,
            d.to_bits() as i16,
        ]
    }
}
