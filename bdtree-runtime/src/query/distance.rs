//! The distance of two deforming meshes.

use super::limit;
use super::pair::normals;
use crate::cache::{OwnCache, Posed};
use crate::contact::PairContact;
use crate::error::QueryError;
use crate::pose::Pose;
use crate::traverse::{Gap, LeafPairs, NearestTwo, SearchEntry, Stack, Walk};

/// The nearest two triangles, one of each asset, and where they are nearest, if that is within
/// `max_distance` (which may be infinite). Of several pairs at the same distance: the lowest ids, those of
/// the first asset before those of the second.
///
/// `stack` has `distance_stack_len` entries.
///
/// # Errors
/// A negative or NaN distance, a corrupt asset.
pub(super) fn closest_points(
    [posed1, posed2]: [Posed<'_>; 2],
    max_distance: f64,
    stack: &mut [SearchEntry],
) -> Result<(Option<PairContact>, Walk), QueryError> {
    let max_distance = limit(max_distance)?;
    let (pose1, pose2) = (posed1.pose, posed2.pose);
    let mut frontier = Stack::new(stack, pose1.asset.distance_stack_len(pose2.asset))?;
    let (mut own1, mut own2) = (OwnCache::default(), OwnCache::default());
    let gap = Gap::new(&posed1, &posed2);
    let mut pairs = LeafPairs::new(max_distance);
    let walk = pose1.asset.kernel.run(NearestTwo {
        posed: [posed1.or_keep(&mut own1), posed2.or_keep(&mut own2)],
        gap: &gap,
        frontier: &mut frontier,
        pairs: &mut pairs,
    })?;
    Ok((whole([pose1, pose2], pairs.best)?, walk))
}

/// The best pair with its normals, which only the last best one gets.
pub(super) fn whole(
    [pose1, pose2]: [&Pose<'_>; 2],
    best: Option<PairContact>,
) -> Result<Option<PairContact>, QueryError> {
    let Some(mut best) = best else {
        return Ok(None);
    };
    let corners1 = pose1.deformed_triangle(best.triangle1)?;
    let corners2 = pose2.deformed_triangle(best.triangle2)?;
    [best.normal1, best.normal2] = normals(&best, &corners1, &corners2);
    Ok(Some(best))
}
