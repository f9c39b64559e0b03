//! Whether two triangles share a point, decided exactly.
//!
//! Guigue and Devillers, "Fast and Robust Triangle-Triangle Overlap Test Using Orientation
//! Predicates" (2003), on exact signs. Coplanar and zero-area triangles go to exact tests of points,
//! segments and triangles, seen along an axis that does not lie in their common plane.

use super::Triangle;
use super::exact::{above, encloses, open_axis, sides, tame, turn};

/// Returns whether the closed triangles share a point; exact, so symmetric and independent of corner order.
///
/// Coordinates must be 0 or between 2⁻³⁰⁰ and 2³⁰⁰ in magnitude, see [`super`]. Coplanar overlap and
/// touching count. A triangle of zero area is the segment or point that it covers.
#[inline]
pub fn triangles_intersect(a: &Triangle, b: &Triangle) -> bool {
    if boxes_apart(a, b) {
        return false;
    }
    // Copies of a mesh in the same place; the signs would be 0, which takes them longest.
    if a.iter().any(|p| b.contains(p)) {
        return true;
    }
    let [a, b] = tame([*a, *b]);
    let sides_b = sides(&a, &b);
    if strictly_one_side(sides_b) {
        return false;
    }
    let sides_a = sides(&b, &a);
    if strictly_one_side(sides_a) {
        return false;
    }
    // A triangle of zero area sees all others in its plane.
    if sides_a == [0; 3] || sides_b == [0; 3] {
        return flat_intersect((&a, sides_a), (&b, sides_b));
    }
    intervals_overlap(turned(&a, sides_a), turned(&b, sides_b))
}

/// Returns whether a coordinate separates the bounding boxes.
#[inline]
fn boxes_apart(a: &Triangle, b: &Triangle) -> bool {
    let low = |t: &Triangle, k: usize| t[0][k].min(t[1][k]).min(t[2][k]);
    let high = |t: &Triangle, k: usize| t[0][k].max(t[1][k]).max(t[2][k]);
    (0..3).any(|k| high(a, k) < low(b, k) || high(b, k) < low(a, k))
}

#[inline]
fn strictly_one_side(sides: [i8; 3]) -> bool {
    sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2]
}

/// Returns the triangle with the corner first that its other triangle's plane cuts off, and the side of that corner.
///
/// A corner in the plane with both others on one side counts as being on the opposite side.
#[inline]
fn turned(tri: &Triangle, sides: [i8; 3]) -> (Triangle, i8) {
    let rotated = |i: usize| [tri[i], tri[(i + 1) % 3], tri[(i + 2) % 3]];
    for i in 0..3 {
        let (s, next, last) = (sides[i], sides[(i + 1) % 3], sides[(i + 2) % 3]);
        if s != 0 && next != s && last != s {
            return (rotated(i), s);
        }
    }
    let i = sides.iter().position(|&s| s == 0).unwrap_or(0);
    (rotated(i), -sides[(i + 1) % 3])
}

/// Returns whether the two triangles cut overlapping pieces from the line that their planes share.
#[inline]
fn intervals_overlap((a, side_a): (Triangle, i8), (b, side_b): (Triangle, i8)) -> bool {
    let ([p1, mut q1, mut r1], [p2, mut q2, mut r2]) = (a, b);
    // Orient each plane so that the other's first corner is above it.
    if side_a < 0 {
        core::mem::swap(&mut q2, &mut r2);
    }
    if side_b < 0 {
        core::mem::swap(&mut q1, &mut r1);
    }
    above(q2, p2, p1, q1) >= 0 && above(r2, p2, r1, p1) >= 0
}

/// A triangle without repeated or inner points: its corners, its two ends, or one point.
struct Reduced {
    points: Triangle,
    count: usize,
}

impl Reduced {
    fn new(tri: &Triangle) -> Self {
        if open_axis(tri[0], tri[1], tri[2]).is_some() {
            return Self {
                points: *tri,
                count: 3,
            };
        }
        // On a line the order by x, then y, then z is the order along it.
        let (mut low, mut high) = (tri[0], tri[0]);
        for &p in &tri[1..] {
            if p < low {
                low = p;
            }
            if p > high {
                high = p;
            }
        }
        Self {
            points: [low, high, high],
            count: if low == high { 1 } else { 2 },
        }
    }

    fn points(&self) -> &[[f64; 3]] {
        &self.points[..self.count]
    }
}

/// Returns the answer if the triangles are coplanar or one has zero area; each with the sides of its corners.
#[cold]
fn flat_intersect((a, sides_a): (&Triangle, [i8; 3]), (b, sides_b): (&Triangle, [i8; 3])) -> bool {
    let (reduced_a, reduced_b) = (Reduced::new(a), Reduced::new(b));
    let (big, small, corners, sides) = if reduced_a.count >= reduced_b.count {
        (&reduced_a, &reduced_b, b, sides_b)
    } else {
        (&reduced_b, &reduced_a, a, sides_a)
    };
    let ([p, q, r], [v, w, _]) = (big.points, small.points);
    match (big.count, small.count) {
        (3, 3) => {}
        (3, _) => {
            // Known already, and slow to find where they are 0. For a point, w is v.
            let side = |end| (0..3).find(|&k| corners[k] == end).map_or(0, |k| sides[k]);
            let (side_v, side_w) = (side(v), side(w));
            if side_v * side_w > 0 {
                return false;
            }
            if side_v != 0 || side_w != 0 {
                let turns = [above(v, w, p, q), above(v, w, q, r), above(v, w, r, p)];
                return !turns.contains(&1) || !turns.contains(&-1);
            }
        }
        (2, 2) if above(p, q, v, w) != 0 => return false,
        _ => {}
    }
    planar_intersect(big.points(), small.points())
}

/// Returns whether convex sets of at most three corners in a common plane share a point.
fn planar_intersect(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let axis = injective_axis(a, b);
    let edges = |s: &[[f64; 3]]| if s.len() == 3 { 3 } else { 1 };
    let edge = |s: &[[f64; 3]], i: usize| (s[i], s[(i + 1) % s.len()]);
    let crossing =
        (0..edges(a)).any(|i| (0..edges(b)).any(|j| segments_meet(axis, edge(a, i), edge(b, j))));
    let contains = |set: &[[f64; 3]], p: [f64; 3]| {
        let corners: Result<Triangle, _> = set.try_into();
        corners.is_ok_and(|corners| encloses(axis, corners, p))
    };
    crossing || contains(a, b[0]) || contains(b, a[0])
}

/// Returns an axis along which the common plane (line) of the points can be projected without folding.
fn injective_axis(a: &[[f64; 3]], b: &[[f64; 3]]) -> usize {
    let at = |i: usize| if i < a.len() { a[i] } else { b[i - a.len()] };
    let count = a.len() + b.len();
    for i in 0..count {
        for j in i + 1..count {
            for k in j + 1..count {
                if let Some(axis) = open_axis(at(i), at(j), at(k)) {
                    return axis;
                }
            }
        }
    }
    // All on a line: any axis that is not its direction.
    let along_z = (1..count).all(|i| at(i)[0] == at(0)[0] && at(i)[1] == at(0)[1]);
    if along_z { 0 } else { 2 }
}

/// Returns whether two closed segments meet in the plane without `axis`; both may be points.
fn segments_meet(axis: usize, (p, q): ([f64; 3], [f64; 3]), (r, s): ([f64; 3], [f64; 3])) -> bool {
    let across_pq = [turn(axis, p, q, r), turn(axis, p, q, s)];
    let across_rs = [turn(axis, r, s, p), turn(axis, r, s, q)];
    if across_pq == [0; 2] && across_rs == [0; 2] {
        return [(axis + 1) % 3, (axis + 2) % 3]
            .into_iter()
            .all(|k| p[k].max(q[k]) >= r[k].min(s[k]) && r[k].max(s[k]) >= p[k].min(q[k]));
    }
    across_pq[0] * across_pq[1] <= 0 && across_rs[0] * across_rs[1] <= 0
}
