//! Distance of a segment and a triangle, with a point of each.
//!
//! A segment is a triangle of zero area: the steps are those of [`super::triangle_distance()`],
//! less what the repeated corner would ask twice.

use super::Triangle;
use super::triangle_distance::distance_of;
use super::triangle_triangle::triangles_intersect;

/// The nearest points of a segment and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentDistance {
    /// Their distance, 0 exactly if the closed sets share a point.
    pub distance: f64,
    /// The segment's point.
    pub on_segment: [f64; 3],
    /// The triangle's point.
    pub on_triangle: [f64; 3],
    /// Where `on_segment` lies: 0 at the first end, 1 at the second.
    pub parameter: f64,
    /// Weights of the triangle's corners that give `on_triangle`, none negative, sum 1 within 4 u.
    pub barycentric: [f64; 3],
}

/// Returns the distance of a segment, given by its ends, and a triangle, and where it is taken. A
/// segment of length 0 is a point.
///
/// With u = 2⁻⁵³ and L the largest `|end − corner|` of any coordinate: `distance` is between exact
/// − 32 u L and (tested, not proven) exact + 64 u L, and 0 if and only if the two share a point.
/// Then `on_segment` and `on_triangle` are the same up to rounding.
///
/// Among equals the first counts: the ends against the triangle, its corners against the segment,
/// then the segment against its edges 01, 12, 20.
pub fn segment_triangle_distance(segment: &[[f64; 3]; 2], tri: &Triangle) -> SegmentDistance {
    let [p, q] = *segment;
    let segment = [p, q, q];
    let nearest = distance_of::<2>(
        &segment,
        tri,
        triangles_intersect(&segment, tri),
        f64::INFINITY,
    );
    let [_, second, repeated] = nearest.barycentric1;
    let touching = nearest.distance == 0.0;
    SegmentDistance {
        distance: nearest.distance,
        on_segment: nearest.point1,
        on_triangle: if touching {
            super::combine(tri, nearest.barycentric2)
        } else {
            nearest.point2
        },
        parameter: (second + repeated).min(1.0),
        barycentric: nearest.barycentric2,
    }
}
