//! Triangles that touch in a point, along a line or in a plane: who sees it.

use bdtree_runtime::narrow::triangles_intersect;
use parry3d::math::{Pose, Vector};
use parry3d::query::intersection_test;
use parry3d::shape::Triangle;

use super::fixture;

use crate::prelude::*;

pub(super) const TITLE: &str = "Fixture touching, pairs of triangles whose boxes touch, in parry3d's intersection_test (the product's is exact, obvhs has none)";

/// Compares parry's test of two triangles with the exact one on all pairs of the fixture whose boxes
/// touch: coordinates are sixteenths, so f32 holds them.
pub(super) fn row() -> Result<Row> {
    let mesh = fixture("touching")?;
    let triangles: Vec<[[f64; 3]; 3]> = (mesh.triangles.iter())
        .map(|t| t.map(|v| mesh.positions[v as usize]))
        .collect();
    let ends = |t: &[[f64; 3]; 3], k: usize| {
        let all = t.iter().map(|x| x[k]);
        [
            all.clone().fold(f64::INFINITY, f64::min),
            all.fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    let (mut touching, mut apart, mut missed, mut wrong) = (0_usize, 0_usize, 0, 0);
    for (i, a) in triangles.iter().enumerate() {
        for b in &triangles[..i] {
            let meets = |k: usize| {
                let ([low, high], [from, to]) = (ends(a, k), ends(b, k));
                low <= to && from <= high
            };
            if !(0..3).all(meets) {
                continue;
            }
            let [one, two] = [a, b].map(|t| {
                let [a, b, c] = t.map(|p| Vector::from_array(p.map(|x| x as f32)));
                Triangle::new(a, b, c)
            });
            let here = Pose::IDENTITY;
            let found = intersection_test(&here, &one, &here, &two)?.intersecting;
            if triangles_intersect(a, b) {
                touching += 1;
                missed += usize::from(!found);
            } else {
                apart += 1;
                wrong += usize::from(found);
            }
        }
    }
    Ok(row! {
        "pairs that touch" => touching, "of them missed" => missed,
        "pairs that do not" => apart, "of them reported" => wrong,
    })
}
