//! Four f64 side by side: the exact tests of four triangles at once.
//!
//! Every operation is IEEE's, rounded once, so each of the four numbers has the bits that the
//! same steps give one at a time; nothing here is fused.

use crate::math::sqrt;

/// Four f64 side by side.
pub(crate) trait Quad: Copy {
    /// One decision for each of the four.
    type Mask: Copy;

    fn splat(x: f64) -> Self;
    fn load(x: &[f64; 4]) -> Self;
    fn widen(x: &[f32; 4]) -> Self;
    fn store(self) -> [f64; 4];
    /// The same but for the last number.
    #[inline(always)]
    fn with_last(self, x: f64) -> Self {
        let [a, b, c, _] = self.store();
        Self::load(&[a, b, c, x])
    }
    /// The nearest f32.
    #[inline(always)]
    fn narrow(self) -> [f32; 4] {
        let [a, b, c, d] = self.store();
        [a as f32, b as f32, c as f32, d as f32]
    }
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// `self > other`; false where one is NaN.
    fn above(self, other: Self) -> Self::Mask;
    /// `self ≥ other`; false where one is NaN.
    fn at_least(self, other: Self) -> Self::Mask;
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `yes` where the mask is set, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// 0 where the mask is set.
    #[inline(always)]
    fn cleared(self, mask: Self::Mask) -> Self {
        Self::select(mask, Self::splat(0.0), self)
    }
    /// Bit k is decision k.
    fn bits(mask: Self::Mask) -> u8;
    /// Columns as rows.
    #[inline(always)]
    fn transposed(rows: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = [
            rows[0].store(),
            rows[1].store(),
            rows[2].store(),
            rows[3].store(),
        ];
        let mut columns = rows;
        for k in 0..4 {
            columns[k] = Self::load(&[a[k], b[k], c[k], d[k]]);
        }
        columns
    }
    /// The larger of the two, `other` where one is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.above(other), self, other)
    }
    /// The smaller of the two, `self` where one is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.above(other), other, self)
    }
}

/// Methods that are one operator on each number of the operands.
macro_rules! operators {
    ($($name:ident = $operator:tt;)+) => {
        $(#[inline(always)]
        fn $name(self, other: Self) -> Self {
            self.zip(other, |a, b| a $operator b)
        })+
    };
}
pub(super) use operators;

/// The portable four.
#[derive(Clone, Copy)]
pub(crate) struct Array4([f64; 4]);

impl Array4 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self.0;
        for k in 0..4 {
            out[k] = f(out[k], other.0[k]);
        }
        Self(out)
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> [u64; 4] {
        let mut out = [0; 4];
        for k in 0..4 {
            out[k] = if f(self.0[k], other.0[k]) {
                u64::MAX
            } else {
                0
            };
        }
        out
    }
}

impl Quad for Array4 {
    type Mask = [u64; 4];

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    fn load(x: &[f64; 4]) -> Self {
        Self(*x)
    }

    #[inline(always)]
    fn widen(x: &[f32; 4]) -> Self {
        Self(x.map(f64::from))
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        self.0
    }

    operators! {
        add = +;
        sub = -;
        mul = *;
        div = /;
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([a.abs(), b.abs(), c.abs(), d.abs()])
    }

    #[inline(always)]
    fn above(self, other: Self) -> [u64; 4] {
        self.compare(other, |a, b| a > b)
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> [u64; 4] {
        self.compare(other, |a, b| a >= b)
    }

    #[inline(always)]
    fn both(a: [u64; 4], b: [u64; 4]) -> [u64; 4] {
        [a[0] & b[0], a[1] & b[1], a[2] & b[2], a[3] & b[3]]
    }

    #[inline(always)]
    fn either(a: [u64; 4], b: [u64; 4]) -> [u64; 4] {
        [a[0] | b[0], a[1] | b[1], a[2] | b[2], a[3] | b[3]]
    }

    #[inline(always)]
    fn select(mask: [u64; 4], yes: Self, no: Self) -> Self {
        let mut out = no.0;
        for k in 0..4 {
            out[k] =
                f64::from_bits((yes.0[k].to_bits() & mask[k]) | (no.0[k].to_bits() & !mask[k]));
        }
        Self(out)
    }

    #[inline(always)]
    fn bits(mask: [u64; 4]) -> u8 {
        let mut bits = 0;
        for k in 0..4 {
            bits |= (mask[k] as u8 & 1) << k;
        }
        bits
    }
}

/// The next four of `count` from `first` on, the last one again where they are fewer.
#[inline(always)]
pub(crate) fn four_of(count: usize, first: usize) -> Option<[usize; 4]> {
    if first >= count {
        return None;
    }
    let last = count - 1;
    Some([
        first,
        (first + 1).min(last),
        (first + 2).min(last),
        (first + 3).min(last),
    ])
}

/// Vectors of three coordinates, four side by side, with the same steps as [`crate::math`].
pub(crate) type Quad3<Q> = [Q; 3];

#[inline(always)]
pub(crate) fn splat3<Q: Quad>(a: [f64; 3]) -> Quad3<Q> {
    [Q::splat(a[0]), Q::splat(a[1]), Q::splat(a[2])]
}

#[inline(always)]
pub(crate) fn add3<Q: Quad>(a: Quad3<Q>, b: Quad3<Q>) -> Quad3<Q> {
    [a[0].add(b[0]), a[1].add(b[1]), a[2].add(b[2])]
}

#[inline(always)]
pub(crate) fn sub3<Q: Quad>(a: Quad3<Q>, b: Quad3<Q>) -> Quad3<Q> {
    [a[0].sub(b[0]), a[1].sub(b[1]), a[2].sub(b[2])]
}

#[inline(always)]
pub(crate) fn scale3<Q: Quad>(a: Quad3<Q>, k: Q) -> Quad3<Q> {
    [a[0].mul(k), a[1].mul(k), a[2].mul(k)]
}

#[inline(always)]
pub(crate) fn dot3<Q: Quad>(a: Quad3<Q>, b: Quad3<Q>) -> Q {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

#[inline(always)]
pub(crate) fn cross3<Q: Quad>(a: Quad3<Q>, b: Quad3<Q>) -> Quad3<Q> {
    [
        a[1].mul(b[2]).sub(a[2].mul(b[1])),
        a[2].mul(b[0]).sub(a[0].mul(b[2])),
        a[0].mul(b[1]).sub(a[1].mul(b[0])),
    ]
}

#[inline(always)]
pub(crate) fn select3<Q: Quad>(mask: Q::Mask, yes: Quad3<Q>, no: Quad3<Q>) -> Quad3<Q> {
    [
        Q::select(mask, yes[0], no[0]),
        Q::select(mask, yes[1], no[1]),
        Q::select(mask, yes[2], no[2]),
    ]
}
