//! q in whole numbers: what node bounds take of a pose (docs/guarantees.md, shares).
//!
//! A node's sums over modes are exact, because both its rows and q are whole numbers. So bounds are
//! those of another pose q̃ that is close to q, and what the two differ by is added to every radius.

use bdtree_format::ModeRecord;

/// Σ |n_j| is at most this: times 2¹⁵ it fits 32 bits.
const TOTAL_MAX: f64 = 65_535.0;

/// Largest |n_j|: that of an `i16` whose opposite is one too.
const LARGEST: f64 = 32_767.0;

/// Least λ: 2⁻¹⁰⁰, so that no product of it and a whole number is subnormal.
const SCALE_MIN: f64 = f64::from_bits((1023 - 100) << 52);

/// Least ρ: 2⁻³⁰.
const RATIO_MIN: f64 = f64::from_bits((1023 - 30) << 52);

/// A pose's q̃ of q̃_j = (n_j + ρ m_j) λ `q_limit`_j, two modes side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shares<'p> {
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

/// Memory for [`Shares`]: one entry each for every two modes.
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

impl Given<'_> {
    /// The two modes of a pair; the second of the last may be missing.
    fn pair(self, k: u32) -> [Mode; 2] {
        [2 * k as usize, 2 * k as usize + 1].map(|j| {
            let (Some(record), Some(q)) = (self.modes.get(j), self.q.get(j)) else {
                return Mode {
                    share: 0.0,
                    weight: 0.0,
                };
            };
            let limit = f64::from(record.q_limit.get());
            Mode {
                share: f64::from(*q) / limit,
                weight: f64::from(record.field_norm_max.get()) * limit,
            }
        })
    }

    /// How far a pair moves a vertex at most.
    fn reach(self, k: u32) -> f64 {
        let [a, b] = self.pair(k);
        a.weight * a.share.abs() + b.weight * b.share.abs()
    }

    /// q̃ and Σ `W_j` |q_j − q̃_j|.
    ///
    /// The pairs that move least are left out as long as they move no vertex by more than
    /// `tolerance` together. q̃ has a second part where one alone would be off by more than `coarse`
    /// (all in stored units).
    pub(crate) fn round(
        self,
        tolerance: f64,
        coarse: f64,
        memory: Memory<'_>,
    ) -> (Shares<'_>, f64) {
        let Memory {
            coarse: first,
            fine: second,
            active,
        } = memory;
        for (k, pair) in (0..).zip(active.iter_mut()) {
            *pair = k;
        }
        let (mut kept, left_out) = self.drop_least(tolerance, active);
        first.fill([0; 2]);

        let mut size = Size::default();
        for &k in &active[..kept] {
            self.pair(k).iter().for_each(|mode| size.add(mode.share));
        }
        let scale = round_up(size.unit(self.q.len()).max(SCALE_MIN));
        let wide = f64::from(scale);
        let mut off = 0.0;
        for &k in &active[..kept] {
            let n = self.pair(k).map(|mode| {
                let n = nearest(mode.share / wide);
                off += mode.weight * (mode.share - f64::from(n) * wide).abs();
                n
            });
            put(first, k, n);
        }

        let mut ratio = 0.0;
        let in_two = off > coarse;
        if in_two {
            // The first part towards zero, so that the second has its sign.
            let rest = |mode: &Mode| {
                let n = (mode.share / wide) as i16;
                (n, mode.share - f64::from(n) * wide)
            };
            let mut size = Size::default();
            for &k in &active[..kept] {
                self.pair(k).iter().for_each(|mode| size.add(rest(mode).1));
            }
            ratio = round_up((size.unit(self.q.len()) / wide).max(RATIO_MIN));
            let step = wide * f64::from(ratio);
            second.fill([0; 2]);
            off = 0.0;
            for &k in &active[..kept] {
                let pair = self.pair(k).map(|mode| {
                    let (n, rest) = rest(&mode);
                    let m = nearest(rest / step);
                    off += mode.weight * (rest - f64::from(m) * step).abs();
                    [n, m]
                });
                put(first, k, [pair[0][0], pair[1][0]]);
                put(second, k, [pair[0][1], pair[1][1]]);
            }
        }
        let fine: &[[i16; 2]] = if in_two { second } else { &[] };

        // Pairs that came out zero are nothing to sum.
        let mut used = 0;
        for i in 0..kept {
            let k = active[i];
            let is_zero = |part: &[[i16; 2]]| part.get(k as usize).is_none_or(|n| *n == [0; 2]);
            if !(is_zero(first) && is_zero(fine)) {
                active[used] = k;
                used += 1;
            }
        }
        kept = used;
        let shares = Shares {
            coarse: first,
            fine,
            active: &active[..kept],
            scale,
            ratio,
            mode_count: self.q.len(),
        };
        (shares, left_out + off)
    }

    /// Moves the pairs that stay to the front of `active`, ascending; how many they are, and by how
    /// much the others move a vertex.
    fn drop_least(self, tolerance: f64, active: &mut [u32]) -> (usize, f64) {
        if tolerance == 0.0 {
            return (active.len(), 0.0);
        }
        active.sort_unstable_by(|a, b| self.reach(*a).total_cmp(&self.reach(*b)));
        let (mut dropped, mut sum) = (0, 0.0);
        for &k in active.iter() {
            let with = sum + self.reach(k);
            if with > tolerance {
                break;
            }
            (dropped, sum) = (dropped + 1, with);
        }
        active.copy_within(dropped.., 0);
        let kept = active.len() - dropped;
        active[..kept].sort_unstable();
        (kept, sum)
    }
}

/// Largest magnitude and sum of magnitudes.
#[derive(Default)]
struct Size {
    largest: f64,
    total: f64,
}

impl Size {
    fn add(&mut self, x: f64) {
        self.largest = self.largest.max(x.abs());
        self.total += x.abs();
    }

    /// A unit in which `count` such numbers, rounded to the nearest, keep the limits above.
    fn unit(&self, count: usize) -> f64 {
        (self.largest / LARGEST).max(self.total / (TOTAL_MAX - count as f64))
    }
}

/// The nearest whole number of 16 bits; ties go away from zero.
fn nearest(x: f64) -> i16 {
    (x + 0.5_f64.copysign(x)) as i16
}

/// An f32 that is not below x, which is positive and normal.
fn round_up(x: f64) -> f32 {
    (x * (1.0 + 1.0 / (1 << 22) as f64)) as f32
}

fn put(part: &mut [[i16; 2]], k: u32, n: [i16; 2]) {
    if let Some(place) = part.get_mut(k as usize) {
        *place = n;
    }
}
