//! The touching triangles of two deforming meshes.

use core::ops::ControlFlow;

use super::ball::{direction, normal};
use super::length;
use crate::cache::Posed;
use crate::contact::{PairContact, Sink, TriangleId, TrianglePair};
use crate::error::QueryError;
use crate::math::scale;
use crate::narrow::{Triangle, nearest_points, triangles_intersect};
use crate::pair_frame::PairFrame;
use crate::traverse::{PairStackEntry, PairVisitor, Two, Walk};

/// Hands on every pair of triangles, one of each asset, that share a point (tolerance 0; exact,
/// coplanar overlap and touching count) or whose distance is at most the visitor's tolerance. The trees are
/// walked in the frame of the first.
///
/// # Errors
/// A corrupt asset.
pub(super) fn walk(
    posed: [Posed<'_>; 2],
    stack: &mut [PairStackEntry],
    visitor: &mut dyn PairVisitor,
) -> Result<Walk, QueryError> {
    let [posed1, posed2] = posed.map(Posed::shorter);
    let Some(frame) = PairFrame::new(&posed1, &posed2, visitor.tolerance()) else {
        return Ok(Walk::default());
    };
    let two = Two {
        posed: [posed1, posed2],
        frame: &frame,
        leaves: None,
    };
    two.walk(stack, visitor)
}

/// A tolerance.
///
/// # Errors
/// One that is negative, not finite or beyond 2^100.
pub(super) fn tolerance(prediction: f64) -> Result<f64, QueryError> {
    length(
        prediction,
        "prediction: negative, not finite or beyond 2^100",
    )
}

/// Unit normals at the points of a pair: towards each other, or the triangles' own where they touch.
pub(super) fn normals(
    pair: &PairContact,
    corners1: &Triangle,
    corners2: &Triangle,
) -> [[f64; 3]; 2] {
    if pair.distance > 0.0
        && let Some(towards) = direction(pair.point1, pair.point2)
    {
        return [towards, scale(towards, -1.0)];
    }
    [normal(corners1), normal(corners2)]
}

pub(super) struct Contacts<'s> {
    pub(super) tolerance: f64,
    /// Whether normals are asked for, and points of triangles that touch: [`manifolds`](super::manifold::manifolds) looks at the
    /// points of the others alone.
    pub(super) is_complete: bool,
    pub(super) sink: &'s mut (dyn Sink<PairContact> + 's),
}

impl PairVisitor for Contacts<'_> {
    fn tolerance(&self) -> f64 {
        self.tolerance
    }

    fn triangles(
        &mut self,
        [triangle1, triangle2]: [TriangleId; 2],
        [corners1, corners2]: [&Triangle; 2],
    ) -> ControlFlow<()> {
        let touching = triangles_intersect(corners1, corners2);
        if !touching && self.tolerance == 0.0 {
            return ControlFlow::Continue(());
        }
        let mut contact = PairContact {
            triangle1,
            triangle2,
            distance: 0.0,
            ..PairContact::EMPTY
        };
        if self.is_complete || !touching {
            let nearest = nearest_points(corners1, corners2, touching, self.tolerance);
            if nearest.distance > self.tolerance {
                return ControlFlow::Continue(());
            }
            contact.distance = nearest.distance;
            (contact.point1, contact.point2) = (nearest.point1, nearest.point2);
            contact.barycentric1 = nearest.barycentric1;
            contact.barycentric2 = nearest.barycentric2;
        }
        if self.is_complete {
            [contact.normal1, contact.normal2] = normals(&contact, corners1, corners2);
        }
        self.sink.push(contact)
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
        [triangle1, triangle2]: [TriangleId; 2],
        [corners1, corners2]: [&Triangle; 2],
    ) -> ControlFlow<()> {
        let meet = triangles_intersect(corners1, corners2)
            || self.tolerance > 0.0
                && nearest_points(corners1, corners2, false, self.tolerance).distance
                    <= self.tolerance;
        if !meet {
            return ControlFlow::Continue(());
        }
        self.sink.push(TrianglePair {
            triangle1,
            triangle2,
        })
    }
}
