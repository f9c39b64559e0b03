//! One tree against a question that the nearest answers: nearest first.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::leaves::Leaves;
use super::visit::{NO_NODE, TOGETHER, look};
use super::visitor::{Visitor, Walk};
use super::{StackEntry, Subtree, lane_subtree};
use crate::cache::Posed;
use crate::depth::DepthLimit;
use crate::error::QueryError;
use crate::simd::Lanes;
use crate::view::Asset;

/// Bytes of rows that near caches hold, more or less. Of larger assets all lanes that a node leads to are asked for
/// ahead, of smaller ones the nearest alone: few of the others are visited before a hit ends the walk
/// (docs/measured/benchmarks.md, rays).
const NEAR_BYTES: usize = 8 << 20;

/// Visits nodes and leaves in the order of their keys, as far as the stack shows it, until the
/// visitor wants no more.
#[inline(always)]
pub(super) fn nearest_first<L: Lanes, V: Visitor>(
    posed: &mut Posed<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
    limit: &mut Option<DepthLimit<'_>>,
) -> Result<Walk, QueryError> {
    let pose = posed.pose;
    let asset = pose.asset;
    let mut walk = Walk::default();
    let visits_max = asset.node_count() as u64;
    let mut keys: [Row; TOGETHER] = [[0.0; LANES]; TOGETHER];
    let mut leaves = Leaves::new(asset);
    stack[0] = StackEntry {
        key: f32::NEG_INFINITY,
        ..StackEntry::default()
    };
    let ahead = if size_of_val(asset.rows) > NEAR_BYTES {
        LANES
    } else {
        1
    };
    let mut len = 1;
    while len > 0 {
        len -= 1;
        let StackEntry { at, key } = stack[len];
        if !visitor.wanted(key) {
            continue;
        }
        if at.triangles > 0 {
            let flow = leaves.take::<L, V>(asset, posed, at, visitor)?;
            if flow.is_break() {
                walk.stopped = true;
                return Ok(walk);
            }
            continue;
        }
        // The next one too, where it is a node: its numbers do not wait for the first one's. Not with a limit: what
        // ends at the nearer may rule out what the other would report.
        let mut entries = [at.start; TOGETHER];
        let mut together = 1;
        if limit.is_none()
            && let Some(next) = stack.get(len.wrapping_sub(1))
            && next.at.triangles == 0
            && visitor.wanted(next.key)
        {
            entries[0] = next.at.start;
            together = 2;
            len -= 1;
        }
        walk.nodes_visited += together as u64;
        if walk.nodes_visited > visits_max {
            return Err(asset.endless(visits_max).into());
        }
        let mut found = [(&NO_NODE, 0); TOGETHER];
        // The farther one first, so that what lies below the nearer is popped next.
        for k in TOGETHER - together..TOGETHER {
            let met = look::<L, V>(
                posed,
                entries[k],
                &mut keys[k],
                &mut leaves,
                visitor,
                limit,
                &mut walk,
            )?;
            match met {
                ControlFlow::Continue(met) => found[k] = met,
                ControlFlow::Break(()) => return Ok(walk),
            }
        }
        for k in TOGETHER - together..TOGETHER {
            let (node, mut mask) = found[k];
            // Sorted into the stack: the nearest on top, of equal ones the lowest lane.
            let Some(room) = stack.get_mut(len..len + LANES) else {
                return Err(asset.too_deep().into());
            };
            let mut count = 0;
            while mask != 0 {
                let lane = (7 - mask.leading_zeros()) as usize;
                mask &= !(1 << lane);
                let at = lane_subtree(node, lane);
                if node.leaf_mask & (1 << lane) != 0 && at.triangles == 0 {
                    continue; // a corrupt file's
                }
                let key = keys[k][lane];
                let mut place = count;
                while place > 0 && room[place - 1].key < key {
                    room[place] = room[place - 1];
                    place -= 1;
                }
                room[place] = StackEntry { at, key };
                count += 1;
            }
            len += count;
            for StackEntry { at, .. } in room[..count].iter().rev().take(ahead) {
                if at.triangles == 0 {
                    posed.prefetch_node(asset, at.start);
                } else {
                    prefetch_leaf(asset, posed, *at)?;
                }
            }
        }
    }
    walk.triangles = leaves.taken(asset);
    walk.stopped = leaves.finish::<L, V>(posed, visitor)?.is_break();
    Ok(walk)
}

/// Asks for the vertices of a leaf's triangles, unless these are kept. Leaves that a walk by keys meets lie
/// apart: which vertices they share is not worth finding out.
#[inline(never)]
fn prefetch_leaf(asset: &Asset<'_>, posed: &Posed<'_>, leaf: Subtree) -> Result<(), QueryError> {
    if !posed.keeps_leaf(leaf.start) {
        asset.prefetch_vertices(asset.leaf(leaf)?);
    }
    Ok(())
}
