//! The least translation that separates two triangles.

use super::super::unit;
use crate::math::{add, cross, dot, scale, sub};
use crate::narrow::{Triangle, area_vector};

/// How far the first triangle has to move, and the unit direction against which it moves: the least
/// overlap along the normals of both and the products of their edges (Gottschalk, Lin and Manocha,
/// "OBBTree", 1996), of the directions that do not point from the second's outside to the first's.
/// Along a direction that separates them already it is 0.
pub(super) fn least_translation(a: &Triangle, b: &Triangle) -> (f64, [f64; 3]) {
    let (normal_a, normal_b) = (unit(area_vector(a), ""), unit(area_vector(b), ""));
    let degenerate = [0.0; 3];
    let (normal_a, normal_b) = (
        normal_a.unwrap_or(degenerate),
        normal_b.unwrap_or(degenerate),
    );
    // From the first to the second, as far as their corners' order tells.
    let towards = sub(normal_a, normal_b);
    let mut best = (f64::INFINITY, [0.0, 0.0, 1.0]);
    let mut consider = |direction: [f64; 3]| {
        let Ok(direction) = unit(direction, "") else {
            return;
        };
        for sign in [1.0, -1.0] {
            let direction = scale(direction, sign);
            if dot(direction, towards) < 0.0 {
                continue;
            }
            let (mut high, mut low) = (f64::NEG_INFINITY, f64::INFINITY);
            for k in 0..3 {
                high = high.max(dot(sub(a[k], b[0]), direction));
                low = low.min(dot(sub(b[k], b[0]), direction));
            }
            let overlap = (high - low).max(0.0);
            if overlap < best.0 {
                best = (overlap, direction);
            }
        }
    };
    consider(add(normal_a, scale(normal_b, -1.0)));
    consider(normal_a);
    consider(normal_b);
    for i in 0..3 {
        for j in 0..3 {
            consider(cross(sub(a[(i + 1) % 3], a[i]), sub(b[(j + 1) % 3], b[j])));
        }
    }
    if best.0 == f64::INFINITY {
        best.0 = 0.0; // two points
    }
    best
}
