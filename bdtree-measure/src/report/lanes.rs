//! Which triangles and vertices hang on a lane, found when asked for: reports look at a few of many.

use std::ops::Range;

use bdtree_format::{LANES, NodeRecord};
use bdtree_runtime::Asset;

/// The lanes of a level that hold anything, as node and lane.
pub(super) fn of_level(asset: &Asset<'_>, level: usize) -> Vec<(usize, usize)> {
    let nodes = asset.nodes().iter().enumerate();
    nodes
        .filter(|(_, node)| usize::from(node.level) == level)
        .flat_map(|(i, node)| {
            let used = node.inner_mask | node.leaf_mask;
            let lanes = (0..LANES).filter(move |lane| used >> lane & 1 != 0);
            lanes.map(move |lane| (i, lane))
        })
        .collect()
}

/// The places in leaf order of the triangles below a lane.
pub(super) fn slots(asset: &Asset<'_>, node: usize, lane: usize) -> Vec<usize> {
    let mut found = Vec::new();
    let mut open = vec![(node, lane)];
    while let Some((node, lane)) = open.pop() {
        let Some(record) = asset.nodes().get(node) else {
            continue; // the checks before say so
        };
        if record.leaf_mask >> lane & 1 != 0 {
            found.extend(leaf_slots(record, lane));
        } else if let Some(child) = child(record, lane) {
            open.extend((0..LANES).map(|lane| (child, lane)));
        }
    }
    found
}

/// The vertices of the triangles below a lane, each once, ascending.
pub(super) fn vertices(asset: &Asset<'_>, node: usize, lane: usize) -> Vec<u32> {
    let triangles = asset.triangles();
    let slots = slots(asset, node, lane);
    let corners = slots.iter().filter_map(|slot| triangles.get(*slot));
    let mut all: Vec<u32> = corners.flat_map(|triangle| triangle.corners).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn leaf_slots(node: &NodeRecord, lane: usize) -> Range<usize> {
    let counts = node.leaf_counts.map(usize::from);
    let start = node.first_slot as usize + counts[..lane].iter().sum::<usize>();
    start..start + counts[lane]
}

/// The node that an inner lane leads to.
fn child(node: &NodeRecord, lane: usize) -> Option<usize> {
    let bit = 1_u8 << lane;
    let before = (node.inner_mask & (bit - 1)).count_ones();
    (node.inner_mask & bit != 0).then_some((node.first_child + before) as usize)
}
