//! Refines one branch: its nodes, level by level, and its leaves.

use bdtree_format::NodeRecord;
use core::ops::Range;

use super::record::groups_in;
use super::sweep::{Inner, Leaves};
use super::{RefinedLeaf, RefinedNode};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::view::Asset;

/// Where a branch may be put.
pub(super) struct Room<'r> {
    pub(super) nodes: &'r mut [RefinedNode],
    /// The number of the first of them.
    pub(super) first_node: u32,
    pub(super) leaves: &'r mut [RefinedLeaf],
    pub(super) first_leaf: u32,
}

/// The nodes that a subtree has on each level, from its root on: they follow each other, since nodes stand breadth first (SPEC 6.3).
pub(super) struct Levels<'a> {
    asset: &'a Asset<'a>,
    next: Range<usize>,
    /// Levels to come, at most.
    left: usize,
}

impl<'a> Levels<'a> {
    pub(super) fn new(asset: &'a Asset<'a>, root: usize) -> Self {
        Self {
            asset,
            next: root..root + 1,
            left: asset.depth(),
        }
    }
}

/// Triangles below a node.
pub(super) fn triangles_below(asset: &Asset<'_>, root: usize) -> usize {
    let levels = Levels::new(asset, root);
    let triangles = levels.map(|level| slots_of(asset, &level).len());
    triangles.fold(0, usize::saturating_add)
}

impl Iterator for Levels<'_> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        let level = self.next.clone();
        if level.is_empty() || self.left == 0 {
            return None;
        }
        self.left -= 1;
        let [start, end] = [level.start, level.end].map(|node| first_child(self.asset, node));
        // In damaged files, too, children stand behind their nodes.
        self.next = start.max(level.end)..end;
        Some(level)
    }
}

fn first_child(asset: &Asset<'_>, node: usize) -> usize {
    let node = asset.nodes().get(node);
    node.map_or(asset.node_count(), |node| node.first_child as usize)
}

/// The triangles in the leaves of these nodes.
fn slots_of(asset: &Asset<'_>, nodes: &Range<usize>) -> Range<usize> {
    let all = asset.triangle_count();
    let first = |node: usize| {
        let node = asset.nodes().get(node);
        node.map_or(all, |node| all.min(node.first_slot as usize))
    };
    first(nodes.start)..first(nodes.end)
}

/// Refines the branch of a root. How many nodes and leaves it takes; `None` where there is too little room.
///
/// # Errors
/// A corrupt asset.
pub(super) fn refine(
    pose: &Pose<'_>,
    root: usize,
    room: Room<'_>,
) -> Result<Option<[usize; 2]>, QueryError> {
    let asset = pose.asset;
    let Room {
        nodes,
        first_node,
        leaves,
        first_leaf,
    } = room;
    let [mut node_count, mut leaf_count] = [0, 0];
    for level in Levels::new(asset, root) {
        let behind = node_count + level.len();
        // From their numbers in the asset to those here: children stand behind this level.
        let children = first_child(asset, level.start);
        let shift = first_node
            .wrapping_add(behind as u32)
            .wrapping_sub(children as u32);
        let records: &[NodeRecord] = asset.nodes().get(level.clone()).unwrap_or_default();
        // Else lanes would lead beside their nodes.
        let inner = records
            .iter()
            .map(|node| node.inner_mask.count_ones() as usize);
        let (inner, behind_children) = (inner.sum::<usize>(), first_child(asset, level.end));
        if behind_children.checked_sub(children) != Some(inner) || inner > 0 && children < level.end
        {
            return Err(asset.endless(asset.node_count() as u64).into());
        }
        let groups = |node: &NodeRecord| groups_in(&node.leaf_counts) as usize;
        let end = leaf_count + records.iter().map(groups).sum::<usize>();
        let (Some(nodes), Some(leaves)) = (
            nodes.get_mut(node_count..behind),
            leaves.get_mut(leaf_count..end),
        ) else {
            return Ok(None);
        };
        asset.kernel.run(Leaves {
            asset,
            vertices: pose,
            first_node: level.start as u32,
            nodes,
            first_leaf: first_leaf + leaf_count as u32,
            leaves,
            shift,
        })?;
        (node_count, leaf_count) = (behind, end);
    }
    asset.kernel.run(Inner {
        asset,
        nodes: nodes.get_mut(..node_count).unwrap_or_default(),
        first: first_node,
    })?;
    Ok(Some([node_count, leaf_count]))
}
