//! Many rays, which share the nodes that they evaluate.

use bdtree_runtime::{
    Asset, LeafSlot, NodeSlot, Posed, QueryError, RayHit, StackEntry, StepCache, query,
};

use super::lines::Answer;
use crate::scene::RaysMode;

/// Nodes that are kept between rays, at most.
const NODES_MAX: usize = 1 << 16;

/// Memory for what rays compute, so that others need not.
pub(super) fn cache(asset: &Asset<'_>) -> StepCache<Vec<NodeSlot>, [LeafSlot; 0]> {
    let nodes = asset.node_count().min(NODES_MAX);
    StepCache::new(vec![NodeSlot::EMPTY; nodes], [])
}

/// The answer and the nodes visited.
pub(super) fn solve(
    asset: &Asset<'_>,
    posed: Posed<'_>,
    mode: RaysMode,
    rays: &[query::Ray],
    stack: &mut [StackEntry],
) -> Result<(Answer, u64), QueryError> {
    match mode {
        RaysMode::First => {
            let mut hits = vec![None; rays.len()];
            let outcome = query::rays(asset, posed, rays, stack, &mut hits)?;
            let hits = hits.into_iter().map(Into::into).collect();
            Ok((Answer::First { hits }, outcome.nodes_visited))
        }
        RaysMode::Any => {
            let mut hits = vec![false; rays.len()];
            let outcome = query::rays_any(asset, posed, rays, stack, &mut hits)?;
            Ok((Answer::Any { hits }, outcome.nodes_visited))
        }
        RaysMode::All => {
            let mut found: Vec<(usize, RayHit)> = Vec::new();
            let outcome = query::rays_all(asset, posed, rays, stack, &mut found)?;
            found.sort_by(|(i, a), (j, b)| {
                let by_distance = a.distance.total_cmp(&b.distance);
                i.cmp(j).then(by_distance).then(a.triangle.cmp(&b.triangle))
            });
            let mut hits: Vec<Vec<_>> = rays.iter().map(|_| Vec::new()).collect();
            for (i, hit) in found {
                hits[i].push(Some(hit).into());
            }
            Ok((Answer::All { hits }, outcome.nodes_visited))
        }
    }
}
