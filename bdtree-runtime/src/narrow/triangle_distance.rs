//! Distance of two triangles, with a point of each.
//!
//! Disjoint triangles are nearest at a corner of one and the other triangle, or at two edges
//! (Ericson, *Real-Time Collision Detection*, 2005, 5.1.10). Touching is decided exactly first.

use super::exact::{height, tame};
use super::plane_minimum::plane_minimum;
use super::point_triangle::closest_weights;
use super::triangle_triangle::triangles_intersect;
use super::{Triangle, combine};
use crate::math::{add_scaled, clamp, cross, dot, sqrt, sub};
use crate::rounding::{BOXES_APART, MARGIN, NORMAL_EQUATIONS, TOUCHING_GAP};

/// The nearest points of two triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance {
    /// Their distance, 0 exactly if the closed triangles share a point.
    pub distance: f64,
    /// The point of the first triangle.
    pub point1: [f64; 3],
    /// The point of the second triangle; `point1` itself if they share a point.
    pub point2: [f64; 3],
    /// Weights of the first triangle's corners, none negative, sum 1 within 4 u.
    pub barycentric1: [f64; 3],
    /// Weights of the second triangle's corners, likewise.
    pub barycentric2: [f64; 3],
}

/// A pair of points, given by weights, and the square of their distance.
#[derive(Clone, Copy)]
struct Candidate {
    squared: f64,
    weights: [[f64; 3]; 2],
}

impl Candidate {
    /// Takes the other one if that is strictly nearer: the first of equals stays.
    #[inline]
    fn improve(&mut self, other: Self) {
        if other.squared < self.squared {
            *self = other;
        }
    }
}

/// Returns the distance of two triangles and where it is taken.
///
/// With u = 2⁻⁵³ and L the largest `|corner of a − corner of b|` of any coordinate: `distance` is
/// between exact − 32 u L and (tested, not proven) exact + 64 u L for all shapes; it is 0 if and only if the triangles share a
/// point, decided by [`triangles_intersect`]. Then `point1 = point2` is a point of a within rounding of b.
///
/// Among equals the first counts: for touching triangles first points where an edge passes through the
/// other's plane (edges of a, then of b) if one is within rounding, else and otherwise corners 0, 1, 2 of a against b, corners of b against a, then edges
/// 01, 12, 20 of a, each against those of b. Swapping a and b may choose another pair of points and
/// change the distance by rounding.
pub fn triangle_distance(a: &Triangle, b: &Triangle) -> PairDistance {
    distance_of::<3>(a, b, triangles_intersect(a, b), f64::INFINITY)
}

/// [`triangle_distance`] where [`triangles_intersect`] has answered `touching` already; of triangles farther apart than `limit`
/// some distance above that, and some points.
pub(crate) fn nearest_points(
    a: &Triangle,
    b: &Triangle,
    touching: bool,
    limit: f64,
) -> PairDistance {
    distance_of::<3>(a, b, touching, limit)
}

/// [`nearest_points`] where a is a triangle (`CORNERS` 3) or, its last two corners being the
/// same, a segment (2), whose repeated corner and edges need not be asked.
#[inline(always)]
pub(super) fn distance_of<const CORNERS: usize>(
    a: &Triangle,
    b: &Triangle,
    touching: bool,
    limit: f64,
) -> PairDistance {
    let edges_of_a = if CORNERS == 2 { 1 } else { 3 };
    // Above the squares of all distances that are computed as up to the limit, also where boxes say a little more.
    let reach = limit + BOXES_APART * span(a, b);
    let mut best = Candidate {
        // NaN is no bound.
        squared: f64::INFINITY.min(reach * reach * (1.0 + MARGIN) + f64::MIN_POSITIVE),
        weights: [[1.0, 0.0, 0.0]; 2],
    };
    let mut enough = 0.0;
    if touching {
        best.squared = f64::INFINITY;
        enough = rounding_squared(a, b);
        crossings(a, b, [0, 1], enough, &mut best);
        crossings(b, a, [1, 0], enough, &mut best);
    }
    if !touching || best.squared > enough {
        corners_against(&a[..CORNERS], b, [0, 1], &mut best);
        corners_against(b, a, [1, 0], &mut best);
        for i in 0..edges_of_a {
            for j in 0..3 {
                if let Some(candidate) = edges_minimum(a, i, b, j) {
                    best.improve(candidate);
                }
            }
        }
    }
    let [barycentric1, barycentric2] = best.weights;
    let point1 = combine(a, barycentric1);
    let (distance, point2) = if touching {
        (0.0, point1)
    } else {
        // Rounding may find 0 for triangles that do not touch; 0 is the word for touching.
        let apart = sqrt(best.squared).max(f64::MIN_POSITIVE);
        (apart, combine(b, barycentric2))
    };
    PairDistance {
        distance,
        point1,
        point2,
        barycentric1,
        barycentric2,
    }
}

/// Returns how long the box of both is.
fn span(a: &Triangle, b: &Triangle) -> f64 {
    let of = |k: usize| {
        let (p, q) = (a.map(|x| x[k]), b.map(|x| x[k]));
        let low = p[0].min(p[1]).min(p[2]).min(q[0]).min(q[1]).min(q[2]);
        let high = p[0].max(p[1]).max(p[2]).max(q[0]).max(q[1]).max(q[2]);
        high - low
    };
    of(0).max(of(1)).max(of(2))
}

/// Returns the square of 4 u L: what a computed gap between touching triangles may well be.
fn rounding_squared(a: &Triangle, b: &Triangle) -> f64 {
    let mut largest = 0.0_f64;
    for p in a {
        for q in b {
            largest = sub(*p, *q).iter().fold(largest, |m, x| m.max(x.abs()));
        }
    }
    let gap = TOUCHING_GAP * largest;
    gap * gap
}

/// Improves `best` by the corners of `from` against `to`; `order` says which of them is a and b.
#[inline]
fn corners_against(from: &[[f64; 3]], to: &Triangle, order: [usize; 2], best: &mut Candidate) {
    let [p, q, r] = *to;
    let low = [0, 1, 2].map(|k| p[k].min(q[k]).min(r[k]));
    let high = [0, 1, 2].map(|k| p[k].max(q[k]).max(r[k]));
    for (i, &corner) in from.iter().enumerate() {
        // What separates the corner from the box already, coordinate by coordinate.
        let gap = [0, 1, 2].map(|k| (low[k] - corner[k]).max(corner[k] - high[k]).max(0.0));
        if dot(gap, gap) > best.squared {
            continue;
        }
        let (weights_to, squared) = closest_weights(corner, to);
        let mut weights = [[0.0; 3]; 2];
        weights[order[0]][i] = 1.0;
        weights[order[1]] = weights_to;
        best.improve(Candidate { squared, weights });
    }
}

/// Returns the nearest points of edges i of a and j of b if they are inside both; ends are corners' business.
#[inline]
fn edges_minimum(a: &Triangle, i: usize, b: &Triangle, j: usize) -> Option<Candidate> {
    let (i2, j2) = ((i + 1) % 3, (j + 1) % 3);
    let w = sub(a[i], b[j]);
    let e = sub(a[i2], a[i]);
    let g = sub(b[j], b[j2]);
    if clearly_outside(w, e, g) {
        return None;
    }
    let m = plane_minimum(w, e, g)?;
    if m.trusted && !(m.s > 0.0 && m.s < 1.0 && m.t > 0.0 && m.t < 1.0) {
        return None;
    }
    let (s, t) = (clamp(m.s, 0.0, 1.0), clamp(m.t, 0.0, 1.0));
    let q = add_scaled(add_scaled(w, s, e), t, g);
    let mut weights = [[0.0; 3]; 2];
    weights[0][i] = 1.0 - s;
    weights[0][i2] = s;
    weights[1][j] = 1.0 - t;
    weights[1][j2] = t;
    Some(Candidate {
        squared: dot(q, q),
        weights,
    })
}

/// Returns whether the smallest `|w + s e + t g|` surely has s or t outside `[0, 1]`.
///
/// The normal equations, which lose digits on slivers, with a generous bound of what they lose. No
/// division: this sorts out most pairs of edges.
#[inline]
fn clearly_outside(w: [f64; 3], e: [f64; 3], g: [f64; 3]) -> bool {
    let (ee, eg, gg) = (dot(e, e), dot(e, g), dot(g, g));
    let (we, wg, ww) = (dot(w, e), dot(w, g), dot(w, w));
    let det = ee * gg - eg * eg;
    let (s, t) = (eg * wg - gg * we, eg * we - ee * wg);
    // |s| ≤ 2 gg |e||w| in parts, each wrong by some u; 2 |e||w| ≤ ee + ww.
    let lost_s = NORMAL_EQUATIONS * gg * (ee + ww);
    let lost_t = NORMAL_EQUATIONS * ee * (gg + ww);
    s < -lost_s || s - det > lost_s || t < -lost_t || t - det > lost_t
}

/// Improves `best` by the points where edges of `from` pass through the plane of `to`.
#[cold]
fn crossings(from: &Triangle, to: &Triangle, order: [usize; 2], enough: f64, best: &mut Candidate) {
    let [f, [p, q, r]] = tame([*from, *to]);
    let heights = f.map(|c| height(p, q, r, c));
    let normal = cross(sub(to[1], to[0]), sub(to[2], to[0]));
    for i in 0..3 {
        let j = (i + 1) % 3;
        let (hi, hj) = (heights[i], heights[j]);
        if !((hi < 0.0 && hj > 0.0) || (hi > 0.0 && hj < 0.0)) {
            continue;
        }
        let edge = sub(from[j], from[i]);
        let mut s = clamp(hi / (hi - hj), 0.0, 1.0);
        // The signs of the heights are exact, their values are not: two steps on the gap left.
        for _ in 0..3 {
            let mut weights = [[0.0; 3]; 2];
            weights[order[0]][i] = 1.0 - s;
            weights[order[0]][j] = s;
            let x = combine(from, weights[order[0]]);
            let (weights_to, squared) = closest_weights(x, to);
            weights[order[1]] = weights_to;
            best.improve(Candidate { squared, weights });
            if squared <= enough {
                return;
            }
            let gap = sub(combine(to, weights_to), x);
            s = clamp(s + dot(gap, normal) / dot(edge, normal), 0.0, 1.0);
        }
    }
}
