//! From touching triangles to a few contact points with normals, depths and areas.
//!
//! *What is well defined.* Where two closed surfaces overlap, their triangles touch along a closed
//! contour. Its vector area `A = ½ ∮ x × dx` is that of either surface's part inside the other (Stokes),
//! and the gradient of the volume that both share with respect to moving one of them; so its direction
//! is the normal and its length the area that a penalty force acts on, whatever the meshing, and
//! `depth · area` over the points is the shared volume. Depth at a point is the least translation along the
//! normal that separates the two patches there: the length of the overlap, unless one body passes right
//! through the other, where it reaches to the far side.
//!
//! *Points* lie at one standard deviation of the contour's inside along its principal axes, to either
//! side, a quarter of the area each: so center and second moments are kept, and with depths that vary up
//! to the third power over a rectangle the sum is exact (two-point Gauss quadrature in each direction).
//!
//! *A point's distance* is measured between the two points that it reports, so that a solver may take either.
//! They are where the line through the point along the normal leaves the first body forwards and the
//! second backwards. A contour is rarely flat, so the line may begin outside a body whose surface is then
//! behind it: a smaller depth, or a gap. Where the line does not leave one of the bodies (it passes through
//! a hole of the region, or beside it), the nearest points of both stand for them.
//!
//! *Otherwise* (an open contour: a surface ends there; faces that only touch; near ones within a
//! tolerance; a contour whose projection covers itself in opposite senses so that its second moments are
//! not positive) a region is one point: at the pair whose triangles need the largest of the least
//! translations that separate a pair, or at the nearest pair if none touches.

mod bodies;
mod contour;
mod least;
mod regions;

pub(crate) use regions::ManifoldSlot;

use crate::cache::{OwnCache, Posed};
use crate::contact::{Coverage, PairContact, Sink, TriangleId};
use crate::error::QueryError;
use crate::traverse::StackEntry;
use bodies::Bodies;

/// A connected region of contact, condensed to a few points. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactManifold {
    /// Unit, from the first mesh to the second.
    pub normal1: [f64; 3],
    /// Unit, from the second mesh to the first.
    pub normal2: [f64; 3],
    /// Of the region's projection along the normal; in a region of one point an estimate, that of its triangles
    /// at most.
    pub area: f64,
    /// How far the two overlap along the normal: the largest depth at the region's points and in its middle, 0 when
    /// there is no overlap at any of them.
    pub depth: f64,
    /// Its first triangles: the lowest ids.
    pub triangles: [TriangleId; 2],
    points: [ContactPoint; 4],
    len: usize,
}

/// One point of a [`ContactManifold`]. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// On the first mesh: where a line along `normal1` leaves it. In a region of one point that overlaps: where the
    /// deepest pair of triangles would touch if the first moved back by `−distance` along the normal.
    pub point1: [f64; 3],
    /// On the second mesh: where the same line, followed backwards, leaves it. Where the line leaves only one of the
    /// meshes or none, each is its mesh's point nearest to where the line meets the contour's mean plane, and the two may
    /// lie apart across the normal.
    pub point2: [f64; 3],
    /// `(point2 − point1) · normal1`: negative is penetration depth, positive a gap, which a point of a region that
    /// overlaps elsewhere may have.
    pub distance: f64,
    /// The part of the region's area that it stands for: those of all points add up to it.
    pub area: f64,
    /// The first mesh's triangle.
    pub triangle1: TriangleId,
    /// Weights of its corners that give `point1`.
    pub barycentric1: [f64; 3],
    /// The second mesh's triangle.
    pub triangle2: TriangleId,
    /// Weights of its corners that give `point2`.
    pub barycentric2: [f64; 3],
}

impl ContactManifold {
    /// One point or four.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points[..self.len]
    }
}

/// Reports the regions of contact of these pairs, by their lowest ids. Both surfaces
/// list their corners counterclockwise as seen from outside, or both clockwise.
///
/// `pairs` is sorted by ids, so its order does not matter; all of them are needed, and one that is there twice counts once. `memory` has
/// [`ManifoldSlot::count`] slots and `stack` the longer `stack_len` of the two. Points are found
/// by rays on both meshes, five per mesh and region with a contour, or up to ten where it is far from flat.
///
/// # Errors
/// Pairs of other meshes, a corrupt asset.
pub(super) fn manifolds(
    [posed1, posed2]: [Posed<'_>; 2],
    pairs: &mut [PairContact],
    memory: &mut [ManifoldSlot],
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<ContactManifold>,
) -> Result<Coverage, QueryError> {
    let (asset1, asset2) = (posed1.pose.asset, posed2.pose.asset);
    let (mut own1, mut own2) = (OwnCache::default(), OwnCache::default());
    let mut bodies = Bodies {
        posed1: posed1.or_keep(&mut own1),
        posed2: posed2.or_keep(&mut own2),
        stack,
    };
    let pairs = regions::sorted_once(pairs, memory)?;
    let members = regions::regions(asset1, asset2, pairs, memory)?;
    for region in members.chunk_by(|x, y| x.region() == y.region()) {
        let members = region.iter().filter_map(|slot| pairs.get(slot.pair()));
        let found = bodies.region(members)?;
        if let Some(found) = found
            && sink.push(found).is_break()
        {
            return Ok(Coverage::Truncated);
        }
    }
    Ok(Coverage::Complete)
}
