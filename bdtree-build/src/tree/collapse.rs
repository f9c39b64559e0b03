//! Collapsing a binary tree into eight-wide nodes, as [`CollapseCosts`](super::collapse_costs::CollapseCosts) have it.

use bdtree_format::{DEPTH_MAX, LANES};

use super::binary::Binary;
use super::{Lane, LaneKind, Tree, TreeNode};

/// Eight-wide nodes, breadth first.
pub(super) fn collapse(root: &Binary, order: Vec<u32>) -> Tree {
    let mut subtrees = vec![(root, 0usize)];
    let mut nodes = Vec::new();
    let mut next_slot = 0u32;
    let mut depth = 1;
    let mut next = 0;
    while let Some(&(subtree, level)) = subtrees.get(next) {
        next += 1;
        depth = depth.max(level + 1);
        let mut node = TreeNode {
            lanes: [Lane::default(); LANES],
            first_child: subtrees.len() as u32,
            first_slot: next_slot,
            level: level as u8,
        };
        for (lane, below) in node.lanes.iter_mut().zip(lanes_of(subtree, level)) {
            lane.start = below.start as u32;
            lane.count = below.count as u32;
            if below.children.is_some() {
                lane.kind = LaneKind::Inner;
                subtrees.push((below, level + 1));
            } else if below.count > 0 {
                lane.kind = LaneKind::Leaf;
                next_slot += below.count as u32;
            }
        }
        nodes.push(node);
    }
    Tree {
        nodes,
        order,
        depth,
    }
}

/// At most eight subtrees that together are `subtree`, in its order.
fn lanes_of(subtree: &Binary, level: usize) -> Vec<&Binary> {
    let mut lanes = Vec::with_capacity(LANES);
    // Any collapse takes at least one level off a subtree, opening the tallest lanes takes three.
    // So subtrees here are at most two levels above this limit, and that many fit the last node.
    if subtree.height > 3 * (DEPTH_MAX - 1).saturating_sub(level) {
        lanes.push(subtree);
        open_tallest(&mut lanes);
        return lanes;
    }
    match &subtree.children {
        None => lanes.push(subtree),
        Some(children) => {
            let left_lanes = usize::from(subtree.costs.own_left_lanes);
            gather(&children[0], left_lanes, &mut lanes);
            gather(&children[1], LANES - left_lanes, &mut lanes);
        }
    }
    lanes
}

/// Adds the lanes that a subtree takes when it gets at most `count`.
fn gather<'a>(subtree: &'a Binary, count: usize, lanes: &mut Vec<&'a Binary>) {
    let left_lanes = usize::from(subtree.costs.left_lanes[count - 1]);
    match &subtree.children {
        Some(children) if left_lanes > 0 => {
            gather(&children[0], left_lanes, lanes);
            gather(&children[1], count - left_lanes, lanes);
        }
        _ => lanes.push(subtree),
    }
}

/// Opens the tallest lane until all are taken.
fn open_tallest(lanes: &mut Vec<&Binary>) {
    while lanes.len() < LANES {
        // The last of equally tall lanes, whichever that is: any choice keeps the promise.
        let tallest = (0..lanes.len()).max_by_key(|&i| lanes[i].height);
        let opened = tallest.and_then(|i| lanes[i].children.as_deref().map(|c| (i, c)));
        let Some((i, [left, right])) = opened else {
            break;
        };
        lanes.splice(i..=i, [left, right]);
    }
}
