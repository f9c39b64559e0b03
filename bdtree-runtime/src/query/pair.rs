//! The touching triangles of two deforming assets.

use core::ops::ControlFlow;

use super::{Outcome, length};
use crate::cache::Posed;
use crate::contact::{PairContact, Sink, TriangleId, TrianglePair};
use crate::error::QueryError;
use crate::narrow::{Triangle, nearest_points, triangle_distance, triangles_intersect};
use crate::pair_frame::PairFrame;
use crate::traverse::{PairStackEntry, PairVisitor, Two, Walk};
use crate::view::Asset;

/// Reports every pair of triangles, one of each asset, that share a point (tolerance 0; exact,
/// coplanar overlap and touching count) or whose distance is at most `tolerance`. The trees are
/// walked in the frame of the first.
///
/// # Errors
/// A tolerance that is negative, not finite or beyond 2^100, a pose of another asset, too short
/// a stack, a corrupt asset.
pub fn pair<'p, 'q>(
    (asset1, pose1): (&Asset<'_>, impl Into<Posed<'p>>),
    (asset2, pose2): (&Asset<'_>, impl Into<Posed<'q>>),
    tolerance: f64,
    stack: &mut [PairStackEntry],
    sink: &mut impl Sink<PairContact>,
) -> Result<Outcome, QueryError> {
    let posed = [pose1.into().shorter(), pose2.into().shorter()];
    pair_posed([asset1, asset2], posed, tolerance, stack, sink)
}

/// [`pair`], compiled here for all callers.
fn pair_posed(
    assets: [&Asset<'_>; 2],
    posed: [Posed<'_>; 2],
    tolerance: f64,
    stack: &mut [PairStackEntry],
    sink: &mut dyn Sink<PairContact>,
) -> Result<Outcome, QueryError> {
    let tolerance = length(tolerance, TOLERANCE)?;
    walk(assets, posed, stack, &mut Contacts { tolerance, sink })
}

/// Reports which pairs of triangles [`pair`] would report, without their points: several times
/// faster where many touch.
///
/// # Errors
/// Those of [`pair`].
pub fn touching<'p, 'q>(
    (asset1, pose1): (&Asset<'_>, impl Into<Posed<'p>>),
    (asset2, pose2): (&Asset<'_>, impl Into<Posed<'q>>),
    tolerance: f64,
    stack: &mut [PairStackEntry],
    sink: &mut impl Sink<TrianglePair>,
) -> Result<Outcome, QueryError> {
    let posed = [pose1.into().shorter(), pose2.into().shorter()];
    touching_posed([asset1, asset2], posed, tolerance, stack, sink)
}

/// [`touching`], compiled here for all callers.
fn touching_posed(
    assets: [&Asset<'_>; 2],
    posed: [Posed<'_>; 2],
    tolerance: f64,
    stack: &mut [PairStackEntry],
    sink: &mut dyn Sink<TrianglePair>,
) -> Result<Outcome, QueryError> {
    let tolerance = length(tolerance, TOLERANCE)?;
    walk(assets, posed, stack, &mut Ids { tolerance, sink })
}

pub(super) const TOLERANCE: &str = "tolerance: negative, not finite or beyond 2^100";

fn walk(
    assets: [&Asset<'_>; 2],
    posed: [Posed<'_>; 2],
    stack: &mut [PairStackEntry],
    visitor: &mut dyn PairVisitor,
) -> Result<Outcome, QueryError> {
    let [posed1, posed2] = posed.map(Posed::shorter);
    let (pose1, pose2) = (posed1.pose, posed2.pose);
    if !pose1.belongs_to(assets[0]) || !pose2.belongs_to(assets[1]) {
        return Err(QueryError::PoseMismatch);
    }
    let Some(frame) = PairFrame::new(&posed1, &posed2, visitor.tolerance()) else {
        return Ok(outcome(None));
    };
    let two = Two {
        assets,
        posed: [posed1, posed2],
        frame: &frame,
        leaves: None,
    };
    let walk = two.walk(stack, visitor)?;
    Ok(outcome(Some(walk)))
}

/// What a walk did; without one nothing.
pub(super) fn outcome(walk: Option<Walk>) -> Outcome {
    let walk = walk.unwrap_or_default();
    Outcome {
        nodes_visited: walk.nodes_visited,
        nodes_updated: walk.nodes_updated,
        truncated: walk.stopped,
    }
}

pub(super) struct Contacts<'s> {
    pub(super) tolerance: f64,
    pub(super) sink: &'s mut (dyn Sink<PairContact> + 's),
}

impl PairVisitor for Contacts<'_> {
    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn triangles(
        &mut self,
        triangle1: TriangleId,
        corners1: &Triangle,
        triangle2: TriangleId,
        corners2: &Triangle,
    ) -> ControlFlow<()> {
        let touching = triangles_intersect(corners1, corners2);
        if !touching && self.tolerance == 0.0 {
            return ControlFlow::Continue(());
        }
        let nearest = nearest_points(corners1, corners2, touching);
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

pub(super) struct Ids<'s> {
    pub(super) tolerance: f64,
    pub(super) sink: &'s mut (dyn Sink<TrianglePair> + 's),
}

impl PairVisitor for Ids<'_> {
    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn triangles(
        &mut self,
        triangle1: TriangleId,
        corners1: &Triangle,
        triangle2: TriangleId,
        corners2: &Triangle,
    ) -> ControlFlow<()> {
        let meet = if self.tolerance == 0.0 {
            triangles_intersect(corners1, corners2)
        } else {
            triangle_distance(corners1, corners2).distance <= self.tolerance
        };
        if !meet {
            return ControlFlow::Continue(());
        }
        self.sink.push(TrianglePair {
            triangle1,
            triangle2,
        })
    }
}
