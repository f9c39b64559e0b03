//! The distance of two deforming assets.

use super::{Nearest, limit};
use crate::cache::{OwnCache, Posed};
use crate::contact::PairContact;
use crate::error::QueryError;
use crate::traverse::{Gap, LeafPairs, NearestTwo, SearchEntry, Stack};
use crate::view::Asset;

/// The nearest two triangles, one of each asset, and where they are nearest, if that is within
/// `max_distance` (which may be infinite): `dist` is their distance, 0 and `point1 = point2` when
/// they share a point. Of several pairs at the same distance: the lowest ids, those of the first
/// asset before those of the second.
///
/// `stack` needs [`Asset::distance_stack_len`] entries.
///
/// # Errors
/// A negative or NaN distance, a pose of another asset, too short a stack, a corrupt asset.
pub fn distance<'p, 'q>(
    (asset1, pose1): (&Asset<'_>, impl Into<Posed<'p>>),
    (asset2, pose2): (&Asset<'_>, impl Into<Posed<'q>>),
    max_distance: f64,
    stack: &mut [SearchEntry],
) -> Result<Nearest<PairContact>, QueryError> {
    let posed = [pose1.into().shorter(), pose2.into().shorter()];
    distance_posed([asset1, asset2], posed, max_distance, stack)
}

/// [`distance`], compiled here for all callers.
fn distance_posed(
    [asset1, asset2]: [&Asset<'_>; 2],
    posed: [Posed<'_>; 2],
    max_distance: f64,
    stack: &mut [SearchEntry],
) -> Result<Nearest<PairContact>, QueryError> {
    let [posed1, posed2] = posed.map(Posed::shorter);
    let max_distance = limit(max_distance, "max_distance: negative, NaN or beyond 2^100")?;
    if !posed1.pose.belongs_to(asset1) || !posed2.pose.belongs_to(asset2) {
        return Err(QueryError::PoseMismatch);
    }
    let mut frontier = Stack::new(stack, asset1.distance_stack_len(asset2))?;
    let (mut own1, mut own2) = (OwnCache::default(), OwnCache::default());
    let gap = Gap::new(&posed1, &posed2);
    let mut pairs = LeafPairs::new(max_distance);
    let walk = asset1.kernel.run(NearestTwo {
        a: (asset1, posed1.or_keep(&mut own1)),
        b: (asset2, posed2.or_keep(&mut own2)),
        gap: &gap,
        frontier: &mut frontier,
        pairs: &mut pairs,
    })?;
    Ok(Nearest {
        hit: pairs.best,
        nodes_visited: walk.nodes_visited,
        nodes_updated: walk.nodes_updated,
    })
}
