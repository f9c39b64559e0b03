//! The exact tests that contenders who refit, and the paper's trees, use at their leaves: the product's public
//! functions for single triangles, on the same vertices. So they report the same contacts.
//!
//! They are not as quick as the product's own leaves. Those reject four triangles at a time before any exact
//! test, test balls four triangles at a time (the bits are those of [`closest_point`]), and for pairs of bodies
//! reject four triangles against four; here every triangle of a reached leaf, and every pair of two, is
//! tested alone. Where triangles dominate, part of the product's lead comes from that.

use bdtree_runtime::narrow::{Triangle, closest_point, triangle_distance, triangles_intersect};
use bdtree_runtime::{Contact, PairContact, TriangleId};

use crate::vector::{cross, length, minus};

/// Appends a triangle's contact with a ball, if they touch.
#[inline]
pub fn ball(id: u32, corners: &Triangle, center: [f64; 3], radius: f64, found: &mut Vec<Contact>) {
    let closest = closest_point(center, corners);
    if closest.distance > radius {
        return;
    }
    let away = minus(center, closest.point);
    found.push(Contact {
        triangle: TriangleId(id),
        point: closest.point,
        normal: if closest.distance > 0.0 {
            unit(away)
        } else {
            away
        },
        distance: closest.distance - radius,
        barycentric: closest.barycentric,
    });
}

/// Appends the contact of two triangles, if they share a point.
#[inline]
pub fn pair(
    (id1, one): (u32, &Triangle),
    (id2, two): (u32, &Triangle),
    found: &mut Vec<PairContact>,
) {
    if !triangles_intersect(one, two) {
        return;
    }
    let nearest = triangle_distance(one, two);
    found.push(PairContact {
        triangle1: TriangleId(id1),
        triangle2: TriangleId(id2),
        point1: nearest.point1,
        point2: nearest.point2,
        normal1: normal(one),
        normal2: normal(two),
        distance: nearest.distance,
        barycentric1: nearest.barycentric1,
        barycentric2: nearest.barycentric2,
    });
}

/// A triangle's unit normal; zero where it has no area.
fn normal([a, b, c]: &Triangle) -> [f64; 3] {
    let cross = cross(minus(*b, *a), minus(*c, *a));
    if cross == [0.0; 3] {
        cross
    } else {
        unit(cross)
    }
}

/// A vector of any length but 0 scaled to 1.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|c| c / length)
}
