//! Narrow phase: exact and certified questions about single `f64` triangles.
//!
//! A triangle is a closed set, two-sided; one of zero area acts as the segment or point that it
//! is, and rays miss it. All functions are pure, allocate nothing, do not panic and use only
//! `+ − × ÷ √`, so every processor returns the same bits.
//!
//! *What a hit is worth.* With u = 2⁻⁵³ and L the largest coordinate difference between the
//! corners of the two things compared (ray, point and box: between corner and origin, point or center):
//!
//! | function | statement |
//! |---|---|
//! | [`triangles_intersect`] | exact: τ = 0 |
//! | [`closest_point`], [`triangle_distance()`], [`segment_triangle_distance`] | computed ≥ exact − τ, τ = 32 u L = 2⁻⁴⁸ L |
//! | [`OrientedBox::contact`] | exact in the box's axes as computed: exact distance ≤ τ = 256 u L = 2⁻⁴⁵ L |
//! | [`Frustum::triangle`] | inside: exact, τ = 0; outside: no point in common |
//! | [`ray_hit`] | a point of the exact triangle lies within τ = 128 u L = 2⁻⁴⁶ L of origin + t·direction |
//!
//! The constants add up the roundings of each step at their worst; tests against rational arithmetic
//! find at most 5 u L. All products and sums are the same on every machine, so a caller that adds τ to
//! the bounds it prunes with gets the answers of brute force with these functions.
//!
//! *Range.* Coordinates that are 0 or between 2⁻³⁰⁰ and 2³⁰⁰ in magnitude. Below, they count as 0;
//! above, results are meaningless but still come back. Distances are sound up to 2¹⁰⁰.

pub mod box_triangle;
mod clip;
mod exact;
pub(crate) mod four;
pub(crate) mod four_by_four;
pub mod frustum_triangle;
mod plane_minimum;
pub mod point_triangle;
pub mod ray_triangle;
pub mod segment_triangle;
pub mod triangle_distance;
pub mod triangle_triangle;

pub use box_triangle::{BoxContact, OrientedBox};
pub use frustum_triangle::{Frustum, FrustumState};
pub use point_triangle::{Closest, closest_point};
pub use ray_triangle::{PreparedRay, RayHit, ray_hit};
pub use segment_triangle::{SegmentDistance, segment_triangle_distance};
pub(crate) use triangle_distance::nearest_points;
pub use triangle_distance::{PairDistance, triangle_distance};
pub use triangle_triangle::triangles_intersect;

use crate::math::{add_scaled, cross, scale, sub};

/// The corners of a triangle.
pub type Triangle = [[f64; 3]; 3];

/// Returns the convex combination of the corners, built from the corner of largest weight.
///
/// So weights of 1 return that corner itself, and the error is below 8 u times the longest edge
/// plus u times the result.
#[inline(always)]
pub(crate) fn combine(tri: &Triangle, weights: [f64; 3]) -> [f64; 3] {
    let [w0, w1, w2] = weights;
    let base = if w0 >= w1 && w0 >= w2 {
        0
    } else if w1 >= w2 {
        1
    } else {
        2
    };
    let (i, j) = ((base + 1) % 3, (base + 2) % 3);
    let mut offset = [0.0; 3];
    offset = add_scaled(offset, weights[i], sub(tri[i], tri[base]));
    offset = add_scaled(offset, weights[j], sub(tri[j], tri[base]));
    add_scaled(tri[base], 1.0, offset)
}

/// Half the cross product of two edges.
pub(crate) fn area_vector([p, q, r]: &Triangle) -> [f64; 3] {
    scale(cross(sub(*q, *p), sub(*r, *p)), 0.5)
}
