//! The touching triangles of two deforming assets.

use core::ops::ControlFlow;

use super::{Outcome, length};
use crate::contact::{PairContact, Sink, TriangleId};
use crate::error::QueryError;
use crate::frame::PairFrame;
use crate::narrow::{Triangle, triangle_distance, triangles_intersect};
use crate::pose::Pose;
use crate::traverse::{PairStackEntry, PairVisitor, two};
use crate::view::Asset;

/// Reports every pair of triangles, one of each asset, that share a point (tolerance 0; exact,
/// coplanar overlap and touching count) or whose distance is at most `tolerance`. The trees are
/// walked in the frame of the first.
///
/// # Errors
/// A tolerance that is negative, not finite or beyond 2^100, a pose of another asset, too short
/// a stack, a corrupt asset.
pub fn pair(
    (asset1, pose1): (&Asset<'_>, &Pose<'_>),
    (asset2, pose2): (&Asset<'_>, &Pose<'_>),
    tolerance: f64,
    stack: &mut [PairStackEntry],
    sink: &mut impl Sink<PairContact>,
) -> Result<Outcome, QueryError> {
    let tolerance = length(tolerance, "tolerance: negative, not finite or beyond 2^100")?;
    if !pose1.belongs_to(asset1) || !pose2.belongs_to(asset2) {
        return Err(QueryError::PoseMismatch);
    }
    let Some(frame) = PairFrame::new(pose1, pose2, tolerance) else {
        return Ok(Outcome {
            nodes_visited: 0,
            truncated: false,
        });
    };
    let mut visitor = Pair { tolerance, sink };
    let walk = two(
        (asset1, pose1),
        (asset2, pose2),
        &frame,
        stack,
        &mut visitor,
    )?;
    Ok(Outcome {
        nodes_visited: walk.nodes_visited,
        truncated: walk.stopped,
    })
}

struct Pair<'s, S> {
    tolerance: f64,
    sink: &'s mut S,
}

impl<S: Sink<PairContact>> PairVisitor for Pair<'_, S> {
    fn triangles(
        &mut self,
        triangle1: TriangleId,
        corners1: &Triangle,
        triangle2: TriangleId,
        corners2: &Triangle,
    ) -> ControlFlow<()> {
        // Most candidates do not touch: the exact test says so from their boxes alone.
        if self.tolerance == 0.0 && !triangles_intersect(corners1, corners2) {
            return ControlFlow::Continue(());
        }
        if self.tolerance > 0.0 && boxes_apart(corners1, corners2, self.tolerance) {
            return ControlFlow::Continue(());
        }
        let nearest = triangle_distance(corners1, corners2);
        if nearest.distance > self.tolerance {
            return ControlFlow::Continue(());
        }
        self.sink.push(PairContact {
            triangle1,
            triangle2,
            point1: nearest.point1,
            point2: nearest.point2,
            dist: nearest.distance,
            barycentric1: nearest.barycentric1,
            barycentric2: nearest.barycentric2,
        })
    }
}

/// Whether the gap of the boxes along some axis is above the tolerance, with room for the
/// rounding of the distance that it spares.
fn boxes_apart(a: &Triangle, b: &Triangle, tolerance: f64) -> bool {
    (0..3).any(|k| {
        let range = |t: &Triangle| {
            let [x, y, z] = [t[0][k], t[1][k], t[2][k]];
            (x.min(y).min(z), x.max(y).max(z))
        };
        let ((low1, high1), (low2, high2)) = (range(a), range(b));
        let gap = (low2 - high1).max(low1 - high2);
        let span = high1.max(high2) - low1.min(low2);
        gap > tolerance + 1e-12 * span
    })
}
