//! Arithmetic on rotations, of one node or of four side by side with the same bits.

#[cfg(test)]
mod tests;

use crate::math::sqrt;
use crate::simd::{Lanes, Quad, Work};

/// What the arithmetic is written over: one f64, or four of them. No operation is fused with another.
pub(super) trait Real: Copy {
    /// One decision for each number.
    type Mask: Copy;

    fn of(x: f64) -> Self;
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn root(self) -> Self;
    /// `self > other`; false where one is NaN.
    fn is_above(self, other: Self) -> Self::Mask;
    /// `self ≥ other`; false where one is NaN.
    fn is_at_least(self, other: Self) -> Self::Mask;
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `yes` where the mask is set, else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

impl Real for f64 {
    type Mask = bool;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn root(self) -> Self {
        sqrt(self)
    }

    #[inline(always)]
    fn is_above(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn is_at_least(self, other: Self) -> bool {
        self >= other
    }

    #[inline(always)]
    fn and(a: bool, b: bool) -> bool {
        a & b
    }

    #[inline(always)]
    fn choose(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl<Q: Quad> Real for Q {
    type Mask = Q::Mask;

    #[inline(always)]
    fn of(x: f64) -> Self {
        Q::splat(x)
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Quad::add(self, other)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Quad::sub(self, other)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Quad::mul(self, other)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Quad::div(self, other)
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn is_above(self, other: Self) -> Q::Mask {
        self.above(other)
    }

    #[inline(always)]
    fn is_at_least(self, other: Self) -> Q::Mask {
        self.at_least(other)
    }

    #[inline(always)]
    fn and(a: Q::Mask, b: Q::Mask) -> Q::Mask {
        Q::both(a, b)
    }

    #[inline(always)]
    fn choose(mask: Q::Mask, yes: Self, no: Self) -> Self {
        Q::select(mask, yes, no)
    }
}

#[inline(always)]
fn dot<R: Real>(a: [R; 4], b: [R; 4]) -> R {
    let sum = a[0].mul(b[0]).add(a[1].mul(b[1]));
    sum.add(a[2].mul(b[2])).add(a[3].mul(b[3]))
}

/// A quaternion of length 1; the identity for one without a direction.
#[inline(always)]
pub(super) fn unit<R: Real>(q: [R; 4]) -> [R; 4] {
    let length = dot(q, q).root();
    let has_direction = R::and(
        length.is_above(R::of(0.0)),
        R::of(f64::INFINITY).is_above(length),
    );
    let or = |x: R, other: f64| R::choose(has_direction, x.div(length), R::of(other));
    [or(q[0], 0.0), or(q[1], 0.0), or(q[2], 0.0), or(q[3], 1.0)]
}

/// Rows of the matrix of a quaternion of any length; of the identity for one without a direction, or shorter than 2⁻⁵¹¹.
///
/// Dividing by the square of the length takes no root and loses less than normalising first: of random quaternions, elements were
/// off by at most 5 · 2⁻⁵³ instead of 8 · 2⁻⁵³.
#[inline(always)]
pub(super) fn rows<R: Real>(q: [R; 4]) -> [[R; 3]; 3] {
    let square = dot(q, q);
    let has_direction = R::and(
        square.is_at_least(R::of(f64::MIN_POSITIVE)),
        R::of(f64::INFINITY).is_above(square),
    );
    let or = |x: R, other: f64| R::choose(has_direction, x, R::of(other));
    let [x, y, z, w] = [or(q[0], 0.0), or(q[1], 0.0), or(q[2], 0.0), or(q[3], 1.0)];
    let twice = R::of(2.0).div(or(square, 1.0));
    let one = R::of(1.0);
    let (xx, yy, zz) = (x.mul(x), y.mul(y), z.mul(z));
    let (xy, yz, zx) = (x.mul(y), y.mul(z), z.mul(x));
    let (wx, wy, wz) = (w.mul(x), w.mul(y), w.mul(z));
    [
        [
            one.sub(twice.mul(yy.add(zz))),
            twice.mul(xy.sub(wz)),
            twice.mul(zx.add(wy)),
        ],
        [
            twice.mul(xy.add(wz)),
            one.sub(twice.mul(xx.add(zz))),
            twice.mul(yz.sub(wx)),
        ],
        [
            twice.mul(zx.sub(wy)),
            twice.mul(yz.add(wx)),
            one.sub(twice.mul(xx.add(yy))),
        ],
    ]
}

/// Square of the chord between two unit quaternions below which [`shares`] holds: rotations by up to 58°.
pub(super) const NEAR: f64 = 0.25;

/// 1 / (i (2 i + 1)) and i / (2 i + 1) for i from 12 down to 1: terms of [`shares`]. Where [`NEAR`] ends, each is below 1/16 of
/// the one before, and the first left out below 2⁻⁵³.
const TERMS: [(f64, f64); 12] = [
    (1.0 / 300.0, 12.0 / 25.0),
    (1.0 / 253.0, 11.0 / 23.0),
    (1.0 / 210.0, 10.0 / 21.0),
    (1.0 / 171.0, 9.0 / 19.0),
    (1.0 / 136.0, 8.0 / 17.0),
    (1.0 / 105.0, 7.0 / 15.0),
    (1.0 / 78.0, 6.0 / 13.0),
    (1.0 / 55.0, 5.0 / 11.0),
    (1.0 / 36.0, 4.0 / 9.0),
    (1.0 / 21.0, 3.0 / 7.0),
    (1.0 / 10.0, 2.0 / 5.0),
    (1.0 / 3.0, 1.0 / 3.0),
];

/// sin((1 − t) θ) / sin θ and sin(t θ) / sin θ for t from 0 to 1 and the angle θ of a chord whose square is below [`NEAR`]:
/// a series in cos θ − 1 (Eberly, "A fast and accurate algorithm for computing SLERP", 2011). Its relative error is below
/// 3 · 2⁻⁵³, that of an arc cosine and sines 3.1 · 2⁻⁵³.
#[inline(always)]
pub(super) fn shares<R: Real>(chord_square: R, share: R) -> [R; 2] {
    let less = R::of(-0.5).mul(chord_square);
    let parts = [R::of(1.0).sub(share), share];
    let squares = [parts[0].mul(parts[0]), parts[1].mul(parts[1])];
    let mut sums = [R::of(1.0); 2];
    for (u, v) in TERMS {
        for k in 0..2 {
            let ratio = R::of(u).mul(squares[k]).sub(R::of(v)).mul(less);
            sums[k] = R::of(1.0).add(ratio.mul(sums[k]));
        }
    }
    [parts[0].mul(sums[0]), parts[1].mul(sums[1])]
}

/// Between two rotations along the shorter arc, of length 1, and where that holds: of those less than 58° apart, for shares
/// from 0 to 1.
#[inline(always)]
fn slerp_near<R: Real>(a: [R; 4], b: [R; 4], share: R) -> ([R; 4], R::Mask) {
    let one = R::of(1.0);
    let zero = R::of(0.0);
    let per_a = one.div(dot(a, a).root());
    let per_b = one.div(dot(b, b).root());
    // b and −b are the same rotation.
    let per_b = R::choose(zero.is_above(dot(a, b)), zero.sub(per_b), per_b);
    let mut apart = a;
    for k in 0..4 {
        apart[k] = a[k].mul(per_a).sub(b[k].mul(per_b));
    }
    let chord_square = dot(apart, apart);
    // NaN, of what has no direction, is not near.
    let is_near = R::of(NEAR).is_above(chord_square);
    let is_between = R::and(share.is_at_least(zero), one.is_at_least(share));
    let [from, to] = shares(chord_square, share);
    // Given quaternions need not be normalised, only what comes out.
    let (from, to) = (from.mul(per_a), to.mul(per_b));
    let mut turned = a;
    for k in 0..4 {
        turned[k] = a[k].mul(from).add(b[k].mul(to));
    }
    (unit(turned), R::and(is_near, is_between))
}

/// The same where [`slerp_near`] does not hold.
#[inline(never)]
fn slerp_far(a: [f64; 4], b: [f64; 4], share: f64) -> [f64; 4] {
    /// Quaternions nearer than this are on a straight line: its distance from the arc is below 2⁻⁵³.
    const STRAIGHT: f64 = 1.0 - 1.0 / (1_u64 << 45) as f64;
    let (a, b) = (unit(a), unit(b));
    let cosine = dot(a, b);
    let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
    let (from, to) = if cosine.abs() < STRAIGHT {
        let angle = libm::acos(cosine.abs());
        let sine = libm::sin(angle);
        (
            libm::sin(angle * (1.0 - share)) / sine,
            libm::sin(angle * share) / sine,
        )
    } else {
        (1.0 - share, share)
    };
    let to = sign * to;
    unit([
        from * a[0] + to * b[0],
        from * a[1] + to * b[1],
        from * a[2] + to * b[2],
        from * a[3] + to * b[3],
    ])
}

/// Between two rotations along the shorter arc (glTF 2.0, appendix C.4), of length 1.
pub(super) fn slerp(a: [f64; 4], b: [f64; 4], share: f64) -> [f64; 4] {
    let (turned, holds) = slerp_near(a, b, share);
    if holds {
        turned
    } else {
        slerp_far(a, b, share)
    }
}

/// Keys of rotations that [`Slerps`] takes at a time.
pub(super) const KEYS: usize = 16;

/// [`slerp`] between pairs of keys: `from` becomes what is between it and `to`.
pub(super) struct Slerps<'a> {
    pub(super) from: &'a mut [[f64; 4]; KEYS],
    pub(super) to: &'a [[f64; 4]; KEYS],
    pub(super) shares: &'a [f64; KEYS],
    /// How many of them there are.
    pub(super) count: usize,
}

impl Work for Slerps<'_> {
    type Output = ();

    /// Four rotations are side by side.
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (from, _) = self.from.as_chunks_mut::<4>();
        let (to, _) = self.to.as_chunks::<4>();
        let (shares, _) = self.shares.as_chunks::<4>();
        let fours = self.count.div_ceil(4);
        for ((from, to), shares) in from.iter_mut().zip(to).zip(shares).take(fours) {
            let (a, b) = (side_by_side::<L::Quad>(from), side_by_side::<L::Quad>(to));
            let (turned, holds) = slerp_near(a, b, L::Quad::load(shares));
            let turned = L::Quad::transposed(turned);
            let holds = L::Quad::bits(holds);
            for k in 0..4 {
                if holds & (1 << k) != 0 {
                    from[k] = turned[k].store();
                } else {
                    from[k] = slerp_far(from[k], to[k], shares[k]);
                }
            }
        }
    }
}

/// Of each component that of four quaternions.
#[inline(always)]
pub(super) fn side_by_side<Q: Quad>(four: &[[f64; 4]; 4]) -> [Q; 4] {
    Q::transposed([
        Q::load(&four[0]),
        Q::load(&four[1]),
        Q::load(&four[2]),
        Q::load(&four[3]),
    ])
}
