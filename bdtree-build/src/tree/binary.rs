//! The binary tree that the eight-wide one is collapsed from.

use bdtree_format::LANES;

use super::collapse_costs::CollapseCosts;
use super::split::{Bounds, Item, Splitter, bounds_of};

/// Below this depth sets are halved, so that the height stays below 48 + 32 for any input.
const BALANCED_BELOW: usize = 48;

/// Sets smaller than this are not worth a thread.
const THREAD_ITEMS_MIN: usize = 4096;

/// A node of the binary tree: a run of items.
#[derive(Debug)]
pub(super) struct Binary {
    pub(super) start: usize,
    pub(super) count: usize,
    /// Levels below this one; 0 for a leaf.
    pub(super) height: usize,
    /// How it goes into wide nodes.
    pub(super) costs: CollapseCosts,
    pub(super) children: Option<Box<[Binary; 2]>>,
}

/// Orders `items` and builds the tree over them.
pub(super) fn build(items: &mut [Item], splitter: &Splitter, threads: usize) -> Binary {
    build_range(items, 0, 0, None, splitter, threads)
}

fn build_range(
    items: &mut [Item],
    start: usize,
    depth: usize,
    lanes: Option<usize>,
    splitter: &Splitter,
    threads: usize,
) -> Binary {
    let count = items.len();
    let bounds: Bounds = bounds_of(items);
    let mut node = Binary {
        start,
        count,
        height: 0,
        costs: CollapseCosts::default(),
        children: None,
    };
    if count <= splitter.leaf_size {
        return node;
    }
    // A set that fits one node starts with all of its lanes.
    let lanes = lanes.or_else(|| splitter.fits_node(count).then_some(LANES));
    let left_count = splitter.divide(items, &bounds, lanes, depth >= BALANCED_BELOW);
    let shares = splitter.share_lanes(left_count, count - left_count, lanes);
    let (left, right) = items.split_at_mut(left_count);
    let depth = depth + 1;
    let middle = start + left_count;
    let children = if threads > 1 && count >= THREAD_ITEMS_MIN {
        let half = threads / 2;
        std::thread::scope(|scope| {
            let task = scope.spawn(|| build_range(left, start, depth, shares[0], splitter, half));
            let right = build_range(right, middle, depth, shares[1], splitter, threads - half);
            match task.join() {
                Ok(left) => [left, right],
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    } else {
        [
            build_range(left, start, depth, shares[0], splitter, 1),
            build_range(right, middle, depth, shares[1], splitter, 1),
        ]
    };
    node.height = 1 + children[0].height.max(children[1].height);
    let [left, right] = &children;
    node.costs = CollapseCosts::of_inner(splitter.visits(&bounds), &left.costs, &right.costs);
    node.children = Some(Box::new(children));
    node
}
