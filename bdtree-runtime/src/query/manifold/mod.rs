//! From touching triangles to a few contact points with normals, depths and areas.
//!
//! *What is well defined.* Where two closed surfaces overlap, their triangles touch along a closed
//! contour. Its vector area `A = ½ ∮ x × dx` is that of either surface's part inside the other (Stokes),
//! and the gradient of the volume that both share with respect to moving one of them; so its direction
//! is the normal and its length the area that a penalty force acts on, whatever the meshing, and
//! `depth · area` over the points is the shared volume. Depth at a point is the length of the overlap
//! along the normal: the least translation along it that separates the two patches there.
//!
//! *Points* lie at one standard deviation of the contour's inside along its principal axes, to either
//! side, a quarter of the area each: so centre and second moments are kept, and with depths that vary up
//! to the third power over a rectangle the sum is exact (two-point Gauss quadrature in each direction).
//!
//! *Otherwise* (an open contour: a surface ends there; faces that only touch; near ones within a
//! tolerance) a region is one point: at the pair whose triangles need the largest of the least
//! translations that separate a pair, or at the nearest pair if none touches.

mod bodies;
mod contour;
mod least;
mod regions;

pub use regions::ManifoldSlot;

use crate::cache::{OwnCache, Posed};
use crate::contact::{PairContact, Sink, TriangleId};
use crate::error::QueryError;
use crate::traverse::StackEntry;
use crate::view::Asset;
use bodies::Bodies;

/// A connected region of contact. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRegion {
    /// Unit, from the first asset to the second.
    pub normal: [f64; 3],
    /// Of the region's projection along the normal.
    pub area: f64,
    /// How far the two overlap along the normal in the region's middle; 0 when they do not.
    pub depth: f64,
    /// Its first triangles: the lowest ids.
    pub triangles: [TriangleId; 2],
    points: [ContactPoint; 4],
    len: usize,
}

/// One point of a [`ContactRegion`]. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// The first asset's point.
    pub point1: [f64; 3],
    /// The second asset's point.
    pub point2: [f64; 3],
    /// Signed distance along the normal: negative is penetration depth.
    pub dist: f64,
    /// Its share of the region's area.
    pub area: f64,
    /// The first asset's triangle.
    pub triangle1: TriangleId,
    /// Weights of its corners that give `point1`.
    pub barycentric1: [f64; 3],
    /// The second asset's triangle.
    pub triangle2: TriangleId,
    /// Weights of its corners that give `point2`.
    pub barycentric2: [f64; 3],
}

impl ContactRegion {
    /// One point or four.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points[..self.len]
    }
}

/// Reports the regions of contact of what [`pair`](super::pair()) found, by their lowest ids. Both surfaces
/// list their corners counterclockwise as seen from outside, or both clockwise.
///
/// `pairs` is sorted by ids, so its order does not matter; all of them are needed. `memory` needs
/// [`ManifoldSlot::count`] slots and `stack` the longer [`Asset::stack_len`] of the two. Depths are found
/// by rays on both assets, five each way per region with a contour.
///
/// *Errors of depth, normal and area*: those of the meshes as surfaces, of second order in the edges'
/// length where the surfaces are smooth. Where the contour is far from flat, normal and area are those
/// of its projection. A point whose ray meets nothing counts from the contour's mean plane.
///
/// Returns whether the sink had no room for everything.
///
/// # Errors
/// A pose of another asset, pairs of other assets, too little memory, a corrupt asset.
pub fn manifold<'p, 'q>(
    (asset1, pose1): (&Asset<'_>, impl Into<Posed<'p>>),
    (asset2, pose2): (&Asset<'_>, impl Into<Posed<'q>>),
    pairs: &mut [PairContact],
    memory: &mut [ManifoldSlot],
    stack: &mut [StackEntry],
    sink: &mut impl Sink<ContactRegion>,
) -> Result<bool, QueryError> {
    let (posed1, posed2) = (pose1.into(), pose2.into());
    if !posed1.pose.belongs_to(asset1) || !posed2.pose.belongs_to(asset2) {
        return Err(QueryError::PoseMismatch);
    }
    let (mut own1, mut own2) = (OwnCache::default(), OwnCache::default());
    let mut bodies = Bodies {
        asset1,
        posed1: posed1.or_keep(&mut own1),
        asset2,
        posed2: posed2.or_keep(&mut own2),
        stack,
    };
    pairs.sort_unstable_by_key(|p| (p.triangle1, p.triangle2));
    let members = regions::regions(asset1, asset2, pairs, memory)?;
    for region in members.chunk_by(|x, y| x.region() == y.region()) {
        let members = region.iter().filter_map(|slot| pairs.get(slot.pair()));
        let found = bodies.region(members)?;
        if let Some(found) = found
            && sink.push(found).is_break()
        {
            return Ok(true);
        }
    }
    Ok(false)
}
