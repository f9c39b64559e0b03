//! Closest point of a triangle.
//!
//! Region tests by signs (Ericson, *Real-Time Collision Detection*, 2005, 5.1.5) go wrong on
//! slivers and divide by zero on degenerate triangles. Here every candidate is a convex
//! combination of the corners, and the nearest candidate wins: the foot in the plane where the
//! triangle has one, and the best point of each edge.

use super::plane_minimum::plane_minimum;
use super::triangle_triangle::triangles_intersect;
use super::{Triangle, combine};
use crate::math::{add_scaled, clamp, cross, dot, sqrt, sub};
use crate::rounding::{MARGIN, TOUCH};

/// The nearest point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The point, as `Σ barycentric[i] · corner[i]`.
    pub point: [f64; 3],
    /// Weights of the corners, none negative, sum 1 within 2 u.
    pub barycentric: [f64; 3],
    /// Its distance, computed from differences of coordinates, not from `point`; 0 if and only if the triangle
    /// holds the given point.
    pub distance: f64,
}

/// Returns the point of `tri` nearest to `p`.
///
/// With u = 2⁻⁵³, L the largest `|corner − p|` of any coordinate: `distance` ≥ exact distance − 32 u L
/// (each candidate lies on the triangle, only its evaluation rounds: 7 u L per coordinate), and, tested
/// and not proven, ≤ exact distance + 64 u L, slivers, needles and zero-area triangles included. Sound up to 2¹⁰⁰; differences below 2⁻⁵³⁷
/// count as 0. Whether the point lies on the triangle is decided exactly. Ties go to the foot in the plane, then to
/// the edges 01, 12, 20.
#[inline]
pub fn closest_point(p: [f64; 3], tri: &Triangle) -> Closest {
    let (barycentric, squared) = closest_weights(p, tri);
    Closest {
        point: combine(tri, barycentric),
        barycentric,
        distance: sqrt(squared),
    }
}

/// Returns the weights of the nearest point and its squared distance.
#[inline(always)]
pub(super) fn closest_weights(p: [f64; 3], tri: &Triangle) -> ([f64; 3], f64) {
    let (best, longest) = nearest_candidate(p, tri);
    if best.1 <= TOUCH * longest {
        return touching_or(best, p, tri);
    }
    best
}

/// What `best` becomes where it may be 0: a touch that rounding hides would be missed by limits, which are inclusive.
#[cold]
#[inline(never)]
fn touching_or(best: ([f64; 3], f64), p: [f64; 3], tri: &Triangle) -> ([f64; 3], f64) {
    for k in 0..3 {
        if tri[k] == p {
            let mut weights = [0.0; 3];
            weights[k] = 1.0;
            return (weights, 0.0);
        }
    }
    if triangles_intersect(&[p; 3], tri) {
        return (best.0, 0.0);
    }
    // Off the triangle by less than the candidates round: more than 0 all the same.
    (best.0, best.1.max(f64::MIN_POSITIVE))
}

/// Returns the weights of the nearest candidate with its squared distance, and the square of the longest side.
#[inline(always)]
fn nearest_candidate(p: [f64; 3], tri: &Triangle) -> (([f64; 3], f64), f64) {
    // Relative to p: what is large is only the distance itself.
    let r = [sub(tri[0], p), sub(tri[1], p), sub(tri[2], p)];
    let sides = [
        sub(tri[1], tri[0]),
        sub(tri[2], tri[1]),
        sub(tri[0], tri[2]),
    ];
    let lengths = [
        dot(sides[0], sides[0]),
        dot(sides[1], sides[1]),
        dot(sides[2], sides[2]),
    ];
    let longest = lengths[0].max(lengths[1]).max(lengths[2]);
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);

    let near = if let Some(foot) = foot_of_fair_triangle(r[0], sides, lengths) {
        let [w, s, t] = foot.weights;
        if (w >= 0.0) & (s >= 0.0) & (t >= 0.0) {
            let q = add_scaled(add_scaled(r[0], s, sides[0]), -t, sides[2]);
            best = (foot.weights, dot(q, q));
        }
        foot.near
    } else {
        // Corner `base` lies opposite the middle side: the longest and the shortest side start
        // there, which conditions needles as well as the triangle allows.
        let base = opposite_middle(lengths);
        let (i, j) = ((base + 1) % 3, (base + 2) % 3);
        let (e, g) = (sides[base], sub([0.0; 3], sides[j]));
        if let Some(m) = plane_minimum(r[base], e, g) {
            let t = clamp(m.t, 0.0, 1.0);
            let s = clamp(m.s, 0.0, 1.0 - t);
            let q = add_scaled(add_scaled(r[base], s, e), t, g);
            best.0[base] = (1.0 - t) - s;
            best.0[i] = s;
            best.0[j] = t;
            best.1 = dot(q, q);
            if m.trusted && t == m.t && s == m.s {
                return (best, longest);
            }
        }
        [true; 3]
    };
    for k in 0..3 {
        if !near[k] {
            continue;
        }
        let next = (k + 1) % 3;
        let (s, squared) = segment_minimum(r[k], r[next], sides[k], lengths[k]);
        if squared < best.1 {
            best.0 = [0.0; 3];
            best.0[k] = 1.0 - s;
            best.0[next] = s;
            best.1 = squared;
        }
    }
    (best, longest)
}

/// Squares between these are normal numbers with room for products.
pub(super) const SMALL: f64 = f64::from_bits((1023 - 200) << 52);
pub(super) const LARGE: f64 = f64::from_bits((1023 + 200) << 52);

/// The foot of the perpendicular in the plane of a triangle that is no sliver.
struct Foot {
    /// Weights of the corners, sum 1; negative where the foot lies outside.
    weights: [f64; 3],
    /// The edges 01, 12, 20 that the foot is not clearly inside of. The nearest point of the
    /// triangle is the foot or on one of these: on an edge that the foot is inside of it cannot
    /// be, the triangle being convex.
    near: [bool; 3],
}

/// Returns the foot for `r` = corner 0 − p where height and sides differ by at most about 8, so
/// that the weights are right to 64 u |r| / side; `None` for slivers and for triangles or
/// distances whose squares leave the normal numbers. One division's wait instead of three.
#[inline(always)]
fn foot_of_fair_triangle(r: [f64; 3], sides: [[f64; 3]; 3], lengths: [f64; 3]) -> Option<Foot> {
    let [e, _, back] = sides;
    let g = sub([0.0; 3], back);
    let n = cross(e, g);
    let nn = dot(n, n);
    let longest = lengths[0].max(lengths[1]).max(lengths[2]);
    let rr = dot(r, r);
    let fair = nn * 64.0 >= longest * longest && longest > SMALL && longest < LARGE && rr < LARGE;
    if !fair {
        return None;
    }
    // p − corner 0 = −r in the basis e, g: areas over the whole area.
    let s = dot(cross(g, r), n) / nn;
    let t = dot(cross(r, e), n) / nn;
    let weights = [(1.0 - t) - s, s, t];
    // |r| / side is at most the larger of its square and 1; heights are above sides / 8.
    let shortest = lengths[0].min(lengths[1]).min(lengths[2]);
    // Weights near 0 lose 64v.
    let margin = MARGIN * (1.0 + rr / shortest);
    Some(Foot {
        weights,
        near: [t <= margin, weights[0] <= margin, s <= margin],
    })
}

/// Returns the corner that the longest and the shortest side share.
#[inline(always)]
fn opposite_middle([l01, l12, l20]: [f64; 3]) -> usize {
    let middle = |x: f64, y: f64, z: f64| (y <= x && x <= z) || (z <= x && x <= y);
    if middle(l12, l01, l20) {
        0
    } else if middle(l20, l01, l12) {
        1
    } else {
        2
    }
}

/// Returns s in `[0, 1]` and the squared length of the shortest `(1 − s) w + s v`, where `e = v − w`.
#[inline(always)]
fn segment_minimum(w: [f64; 3], v: [f64; 3], e: [f64; 3], ee: f64) -> (f64, f64) {
    // A side so short that its square vanishes is a point; NaN from 0/0 clamps to 0.
    let s = clamp(-(dot(w, e) / ee), 0.0, 1.0);
    // From the nearer end, so that s = 1 is v itself.
    let q = if s <= 0.5 {
        add_scaled(w, s, e)
    } else {
        add_scaled(v, -(1.0 - s), e)
    };
    (s, dot(q, q))
}
