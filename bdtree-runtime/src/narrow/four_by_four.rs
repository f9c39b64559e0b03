//! Four triangles against four: which pairs certainly do not touch, or are farther apart than a tolerance, told before the exact
//! test.
//!
//! The rejections are those of [`triangles_intersect`](super::triangles_intersect), boxes and
//! planes, four at a time, and with a tolerance the line of their centers; a plane counts only where rounding cannot have turned a sign
//! (Shewchuk's first stage, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates", 1997).

use super::four::closest_four;
use super::{Triangle, closest_point};
use crate::rounding::{BOXES_APART, HEIGHT_FLUSHED, HEIGHT_ROUNDING, MARGIN};
use crate::simd::{Quad, Quad3, add3, cross3, dot3, splat3, sub3};

/// Largest sum of a triangle's coordinates, in magnitude, that is filtered: 2¹⁰⁰.
const LARGEST: f64 = f64::from_bits((1023 + 100) << 52);

/// Below this tolerance, 2⁻¹⁰⁰, boxes alone decide, and directions shorter than 2⁻⁵⁰⁰ decide nothing: squares of what is smaller
/// underflow.
const PLANES_FROM: f64 = f64::from_bits((1023 - 100) << 52);
const SHORTEST: f64 = f64::from_bits((1023 - 500) << 52);

/// Of each coordinate, that of four.
type Rows = [[f64; 4]; 3];

/// Four triangles, with their boxes and planes.
#[derive(Clone, Copy)]
pub(crate) struct WorldFour {
    corners: [Rows; 3],
    low: Rows,
    high: Rows,
    /// The box of all four.
    all: [[f64; 3]; 2],
    /// (b − a) × (c − a).
    normal: Rows,
    /// The same with the magnitudes of all products added up.
    size: Rows,
    /// The triangles that may be rejected: no NaN, nothing infinite or huge.
    fair: u8,
}

impl WorldFour {
    pub(crate) const EMPTY: Self = Self {
        corners: [[[0.0; 4]; 3]; 3],
        low: [[0.0; 4]; 3],
        high: [[0.0; 4]; 3],
        all: [[0.0; 3]; 2],
        normal: [[0.0; 4]; 3],
        size: [[0.0; 4]; 3],
        fair: 0,
    };

    /// Replaces the triangles.
    #[inline(always)]
    pub(crate) fn set<Q: Quad>(&mut self, corners: [Quad3<Q>; 3]) {
        let [a, b, c] = corners;
        let mut sum = Q::splat(0.0);
        for k in 0..3 {
            self.low[k] = a[k].min(b[k]).min(c[k]).store();
            self.high[k] = a[k].max(b[k]).max(c[k]).store();
            let ([p, q, r, s], [t, u, v, w]) = (self.low[k], self.high[k]);
            self.all[0][k] = p.min(q).min(r.min(s));
            self.all[1][k] = t.max(u).max(v.max(w));
            for i in 0..3 {
                self.corners[i][k] = corners[i][k].store();
                sum = sum.add(corners[i][k].abs());
            }
        }
        let (e, f) = (sub3(b, a), sub3(c, a));
        self.normal = store3(cross3(e, f));
        let (e, f) = (abs3(e), abs3(f));
        self.size = store3([
            e[1].mul(f[2]).add(e[2].mul(f[1])),
            e[2].mul(f[0]).add(e[0].mul(f[2])),
            e[0].mul(f[1]).add(e[1].mul(f[0])),
        ]);
        self.fair = Q::bits(Q::splat(LARGEST).at_least(sum));
    }

    /// Triangle `k`, below 4.
    #[inline(always)]
    pub(crate) fn triangle(&self, k: usize) -> Triangle {
        let mut corners = [[0.0; 3]; 3];
        for i in 0..3 {
            for axis in 0..3 {
                corners[i][axis] = self.corners[i][axis][k & 3];
            }
        }
        corners
    }

    /// The corners of all four.
    #[inline(always)]
    fn triangles<Q: Quad>(&self) -> [Quad3<Q>; 3] {
        let [a, b, c] = &self.corners;
        [load3(a), load3(b), load3(c)]
    }

    /// The corners of triangle `k`, below 4, four times.
    #[inline(always)]
    fn one_triangle<Q: Quad>(&self, k: usize) -> [Quad3<Q>; 3] {
        let [a, b, c] = &self.corners;
        [one3(a, k), one3(b, k), one3(c, k)]
    }

    /// The triangles whose boxes meet that of all of `others`.
    #[inline(always)]
    pub(crate) fn meeting<Q: Quad>(&self, others: &Self) -> u8 {
        let [low, high] = others.all;
        let mut meet = Q::splat(0.0).at_least(Q::splat(0.0));
        for axis in 0..3 {
            meet = Q::both(
                meet,
                Q::load(&self.high[axis]).at_least(Q::splat(low[axis])),
            );
            meet = Q::both(
                meet,
                Q::splat(high[axis]).at_least(Q::load(&self.low[axis])),
            );
        }
        // Where something is not fair, its box may mean nothing.
        let all = if others.fair & 15 == 15 { 0 } else { u8::MAX };
        Q::bits(meet) | !self.fair | all
    }

    /// Those of `others` that may share a point with triangle `k`.
    #[inline(always)]
    pub(crate) fn touching<Q: Quad>(&self, k: usize, others: &Self) -> u8 {
        if self.fair & (1 << k) == 0 {
            return u8::MAX;
        }
        let mut meet = Q::splat(0.0).at_least(Q::splat(0.0));
        for axis in 0..3 {
            let low: Q = one(&self.low, axis, k);
            let high: Q = one(&self.high, axis, k);
            meet = Q::both(meet, Q::load(&others.high[axis]).at_least(low));
            meet = Q::both(meet, high.at_least(Q::load(&others.low[axis])));
        }
        let mut left = Q::bits(meet) & others.fair;
        if left != 0 {
            let (mine, theirs) = (self.one_triangle(k), others.triangles());
            let zero = Q::splat(0.0);
            let (normal, size) = (one3(&self.normal, k), one3(&self.size, k));
            left &= !beside::<Q>(mine[0], normal, size, &theirs, zero);
            if left != 0 {
                let (normal, size) = (load3(&others.normal), load3(&others.size));
                left &= !beside::<Q>(theirs[0], normal, size, &mine, zero);
            }
        }
        left | !others.fair
    }

    /// Those of `others` whose distance to triangle `k` may be at most `tolerance`, as
    /// [`triangle_distance`](super::triangle_distance()) computes it: their boxes, their planes and what they reach along the line
    /// of their centers say so, with room for its rounding.
    #[inline(always)]
    pub(crate) fn near<Q: Quad>(&self, k: usize, others: &Self, tolerance: f64) -> u8 {
        if self.fair & (1 << k) == 0 {
            return u8::MAX;
        }
        let mut near = Q::splat(0.0).at_least(Q::splat(0.0));
        let mut widest = Q::splat(0.0);
        for axis in 0..3 {
            let low1: Q = one(&self.low, axis, k);
            let high1: Q = one(&self.high, axis, k);
            let (low2, high2) = (Q::load(&others.low[axis]), Q::load(&others.high[axis]));
            let gap = low2.sub(high1).max(low1.sub(high2));
            let span = high1.max(high2).sub(low1.min(low2));
            let reach = Q::splat(tolerance).add(span.mul(Q::splat(BOXES_APART)));
            near = Q::both(near, reach.at_least(gap));
            widest = widest.max(span);
        }
        let mut left = Q::bits(near) & others.fair;
        if left != 0 && tolerance >= PLANES_FROM {
            let reach = Q::splat(tolerance).add(widest.mul(Q::splat(BOXES_APART)));
            let (mine, theirs) = (self.one_triangle(k), others.triangles());
            let (normal, size) = (one3(&self.normal, k), one3(&self.size, k));
            left &= !far_beside::<Q>(mine[0], normal, size, &theirs, reach);
            if left != 0 {
                let (normal, size) = (load3(&others.normal), load3(&others.size));
                left &= !far_beside::<Q>(theirs[0], normal, size, &mine, reach);
            }
            if left != 0 {
                left &= !far_apart::<Q>(&mine, &theirs, reach);
            }
        }
        left | !others.fair
    }

    /// The triangles whose distance to `point`, as [`closest_point`] computes it, is at most `reach`, which must hold that
    /// function's error: where boxes say that they are farther, it is not asked.
    #[inline(always)]
    pub(crate) fn within<Q: Quad>(&self, point: [f64; 3], reach: f64) -> u8 {
        let mut squared = Q::splat(0.0);
        for axis in 0..3 {
            let x = Q::splat(point[axis]);
            let (low, high) = (Q::load(&self.low[axis]), Q::load(&self.high[axis]));
            let gap = low.sub(x).max(x.sub(high)).max(Q::splat(0.0));
            squared = squared.add(gap.mul(gap));
        }
        let limit = Q::splat(reach * reach * (1.0 + 4.0 * MARGIN));
        let near = !(Q::bits(squared.above(limit)) & self.fair);
        if near & 15 == 0 {
            return 0;
        }
        let corners: [Quad3<Q>; 3] = self.triangles();
        // A corner that is near settles it at a fifth of the arithmetic.
        let limit = Q::splat(reach * reach * (1.0 - 4.0 * MARGIN));
        let p = splat3::<Q>(point);
        let squared = |corner: Quad3<Q>| {
            let d = sub3(corner, p);
            dot3(d, d)
        };
        let nearest = squared(corners[0])
            .min(squared(corners[1]))
            .min(squared(corners[2]));
        let settled = Q::bits(limit.above(nearest));
        if near & !settled & 15 == 0 {
            return near;
        }
        let closest = closest_four::<Q>(point, &corners);
        let far = Q::bits(closest.distance.above(Q::splat(reach)));
        let mut within = near & !(far & closest.fair);
        // Slivers, and triangles that seem to touch the point, one by one.
        let mut left = within & !closest.fair & 15;
        while left != 0 {
            let k = left.trailing_zeros() as usize & 3;
            left &= left - 1;
            if closest_point(point, &self.triangle(k)).distance > reach {
                within &= !(1 << k);
            }
        }
        within
    }
}

/// Where all corners surely lie farther than `reach` from the plane through `a`, on one side of it.
#[inline(always)]
fn far_beside<Q: Quad>(
    a: Quad3<Q>,
    normal: Quad3<Q>,
    size: Quad3<Q>,
    corners: &[Quad3<Q>; 3],
    reach: Q,
) -> u8 {
    let length = dot3(normal, normal).sqrt();
    // Not less than the exact normal's, as far as squares do not underflow.
    let rounding = size[0]
        .add(size[1])
        .add(size[2])
        .mul(Q::splat(HEIGHT_ROUNDING));
    let longest = length.mul(Q::splat(1.0 + MARGIN)).add(rounding);
    let is_normal = Q::bits(length.at_least(Q::splat(SHORTEST)));
    beside(a, normal, size, corners, longest.mul(reach)) & is_normal
}

/// Where the gap along the line of the centers of `a` and `b` is surely wider than `reach`.
#[inline(always)]
fn far_apart<Q: Quad>(a: &[Quad3<Q>; 3], b: &[Quad3<Q>; 3], reach: Q) -> u8 {
    let sum = |t: &[Quad3<Q>; 3]| add3(add3(t[0], t[1]), t[2]);
    let along = sub3(sum(b), sum(a));
    let length = dot3(along, along).sqrt();
    let first = sub3(b[0], a[0]);
    let (mut high, mut low) = (Q::splat(0.0), dot3(first, along));
    let mut squared = dot3(first, first);
    for k in 1..3 {
        let (x, y) = (sub3(a[k], a[0]), sub3(b[k], a[0]));
        high = high.max(dot3(x, along));
        low = low.min(dot3(y, along));
        squared = squared.max(dot3(x, x)).max(dot3(y, y));
    }
    let rounding = squared.sqrt().mul(Q::splat(MARGIN));
    let wider = reach.mul(Q::splat(1.0 + MARGIN)).add(rounding);
    let is_line = length.at_least(Q::splat(SHORTEST));
    Q::bits(Q::both(is_line, low.sub(high).above(wider.mul(length))))
}

/// Where all corners surely lie on one side of the plane through `a`, with heights above `least`, both times the normal's length.
#[inline(always)]
fn beside<Q: Quad>(
    a: Quad3<Q>,
    normal: Quad3<Q>,
    size: Quad3<Q>,
    corners: &[Quad3<Q>; 3],
    least: Q,
) -> u8 {
    let yes = Q::splat(0.0).at_least(Q::splat(0.0));
    let (mut above, mut below) = (yes, yes);
    for corner in corners {
        let d = sub3(*corner, a);
        let height = dot3(normal, d);
        let error = dot3(size, abs3(d))
            .mul(Q::splat(HEIGHT_ROUNDING))
            .add(Q::splat(HEIGHT_FLUSHED));
        let limit = least.add(error);
        above = Q::both(above, height.above(limit));
        below = Q::both(below, Q::splat(0.0).sub(height).above(limit));
    }
    Q::bits(above) | Q::bits(below)
}

/// Coordinate `axis` of triangle `k` four times.
#[inline(always)]
fn one<Q: Quad>(rows: &Rows, axis: usize, k: usize) -> Q {
    Q::splat(rows[axis][k & 3])
}

#[inline(always)]
fn one3<Q: Quad>(rows: &Rows, k: usize) -> Quad3<Q> {
    [one(rows, 0, k), one(rows, 1, k), one(rows, 2, k)]
}

#[inline(always)]
fn load3<Q: Quad>([x, y, z]: &Rows) -> Quad3<Q> {
    [Q::load(x), Q::load(y), Q::load(z)]
}

#[inline(always)]
fn store3<Q: Quad>([x, y, z]: Quad3<Q>) -> Rows {
    [x.store(), y.store(), z.store()]
}

#[inline(always)]
fn abs3<Q: Quad>([x, y, z]: Quad3<Q>) -> Quad3<Q> {
    [x.abs(), y.abs(), z.abs()]
}

#[cfg(test)]
mod tests;
