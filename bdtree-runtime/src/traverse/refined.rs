//! A walk of one tree whose pose is refined: boxes instead of spheres, and leaves that are deformed already.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::leaves::{Near, take_near, test};
use super::shared::Shared;
use super::visitor::{Visitor, Walk};
use super::{StackEntry, Subtree};
use crate::cache::CHUNK;
use crate::error::QueryError;
use crate::pose::Pose;
use crate::refined::Refined;
use crate::simd::{Lanes, Work, prefetch_lines};

/// Lanes that are asked for ahead, the nearest first: few of the others are visited before a hit ends the walk.
const AHEAD: usize = 2;

/// What is walked: the same pose twice.
#[derive(Clone, Copy)]
pub(crate) struct RefinedTree<'w> {
    pub(crate) pose: &'w Pose<'w>,
    pub(crate) refined: Refined<'w>,
}

/// A walk and who it is for.
pub(super) struct RefinedWalk<'w, V> {
    pub(super) tree: RefinedTree<'w>,
    pub(super) stack: &'w mut [StackEntry],
    pub(super) visitor: &'w mut V,
}

impl<V: Visitor> RefinedWalk<'_, V> {
    #[inline(always)]
    fn shared<L: Lanes, const ORDERED: bool>(self) -> Result<Walk, QueryError> {
        L::apart(RefinedWalk {
            tree: self.tree,
            stack: self.stack,
            visitor: &mut Shared::<ORDERED>(self.visitor),
        })
    }
}

impl<V: Visitor> Work for RefinedWalk<'_, V> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        if L::IS_COMPACT && !V::IS_SHARED {
            return if V::ORDERED {
                self.shared::<L, true>()
            } else {
                self.shared::<L, false>()
            };
        }
        let Self {
            tree,
            stack,
            visitor,
        } = self;
        let mut walk = Walk::default();
        let mut near = Near::default();
        stack[0] = StackEntry {
            key: f32::NEG_INFINITY,
            ..StackEntry::default()
        };
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let StackEntry { at, key } = stack[len];
            if V::ORDERED && !visitor.wanted(key) {
                continue;
            }
            let (len, near, walk) = (&mut len, &mut near, &mut walk);
            if visit::<L, V>(tree, at, stack, len, near, visitor, walk)?.is_break() {
                return Ok(*walk);
            }
        }
        if V::IN_FOURS {
            walk.stopped = take_near::<L, V>(&mut near, &tree.pose.placement, visitor).is_break();
        }
        Ok(walk)
    }
}

/// One visit: of a leaf, or of a node, whose lanes are put onto the stack, of which `len` entries are left.
#[inline(always)]
pub(super) fn visit<L: Lanes, V: Visitor>(
    tree: RefinedTree<'_>,
    at: Subtree,
    stack: &mut [StackEntry],
    len: &mut usize,
    near: &mut Near,
    visitor: &mut V,
    walk: &mut Walk,
) -> Result<ControlFlow<()>, QueryError> {
    let RefinedTree { pose, refined } = tree;
    let asset = pose.asset;
    if at.triangles > 0 {
        walk.triangles += u64::from(at.triangles);
        // Nodes of a corrupt file may share leaves, which preparing does not see.
        asset.fewer(asset.triangle_count() as u64, walk.triangles)?;
        let flow = leaf::<L, V>(tree, at, near, visitor);
        walk.stopped = flow.is_break();
        return Ok(flow);
    }
    walk.nodes_visited += 1;
    let visits_max = refined.nodes.len() as u64;
    let node = refined.nodes.get(at.start as usize);
    let (Some(node), true) = (node, walk.nodes_visited <= visits_max) else {
        return Err(asset.endless(visits_max).into());
    };
    let mut keys: Row = [0.0; LANES];
    let mut mask = visitor.boxes::<L>(&node.boxes, &mut keys);
    mask &= node.inner_mask | node.leaf_mask;
    let Some(room) = stack.get_mut(*len..*len + LANES) else {
        return Err(asset.too_deep().into());
    };
    let mut count = 0;
    while mask != 0 {
        let lane = (7 - mask.leading_zeros()) as usize;
        mask &= !(1 << lane);
        let entry = StackEntry {
            at: node.subtree(lane),
            key: keys[lane],
        };
        // The nearest on top, of equal ones the lowest lane.
        let mut place = count;
        if V::ORDERED {
            while place > 0 && room[place - 1].key < entry.key {
                room[place] = room[place - 1];
                place -= 1;
            }
        }
        room[place] = entry;
        count += 1;
    }
    *len += count;
    for entry in room[..count].iter().rev().take(AHEAD) {
        ask_for(refined, entry.at);
    }
    Ok(ControlFlow::Continue(()))
}

/// Asks for all of what is visited soon, wherever that begins in a line.
#[inline(always)]
fn ask_for(refined: Refined<'_>, at: Subtree) {
    let start = at.start as usize;
    if at.triangles > 0 {
        prefetch_lines::<3, _>(refined.leaves.as_ptr().wrapping_add(start));
    } else {
        prefetch_lines::<4, _>(refined.nodes.as_ptr().wrapping_add(start));
    }
}

/// Hands the triangles of a leaf to the visitor, or, in fours, keeps some of them back.
#[inline(always)]
fn leaf<L: Lanes, V: Visitor>(
    tree: RefinedTree<'_>,
    at: Subtree,
    near: &mut Near,
    visitor: &mut V,
) -> ControlFlow<()> {
    let start = at.start as usize;
    let end = start + (at.triangles as usize).div_ceil(CHUNK);
    let mut count = at.triangles;
    for leaf in tree.refined.leaves.get(start..end).unwrap_or_default() {
        let misses = visitor.misses_four::<L::Quad>(&leaf.corners);
        let mut left = !misses & !(u8::MAX << count.min(CHUNK as u32));
        count = count.saturating_sub(CHUNK as u32);
        while left != 0 {
            let k = (left.trailing_zeros() & 3) as usize;
            left &= left - 1;
            let corners = leaf.corners.map(|corner| corner.map(|of| of[k]));
            test::<L, V>(near, &tree.pose.placement, leaf.ids[k], &corners, visitor)?;
        }
    }
    ControlFlow::Continue(())
}
