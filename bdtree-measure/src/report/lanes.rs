//! Which triangles and vertices hang on a lane, found when asked for: measurements look at a few of many.

use bdtree_format::LANES;
use bdtree_runtime::Asset;

/// The lanes of a level that hold anything, as node and lane.
pub fn of_level(asset: &Asset<'_>, level: usize) -> Vec<(usize, usize)> {
    let nodes = asset.nodes().iter().enumerate();
    nodes
        .filter(|(_, node)| usize::from(node.level) == level)
        .flat_map(|(i, node)| node.lanes().map(move |lane| (i, lane)))
        .collect()
}

/// The places in leaf order of the triangles below a lane.
pub fn slots(asset: &Asset<'_>, node: usize, lane: usize) -> Vec<usize> {
    let mut found = Vec::new();
    let mut open = vec![(node, lane)];
    while let Some((node, lane)) = open.pop() {
        let Some(record) = asset.nodes().get(node) else {
            continue; // the checks before say so
        };
        if record.leaf_mask >> lane & 1 != 0 {
            found.extend(record.slots(lane));
        } else if let Some(child) = record.child(lane) {
            open.extend((0..LANES).map(|lane| (child as usize, lane)));
        }
    }
    found
}

/// The vertices of the triangles below a lane, each once, ascending.
pub fn vertices(asset: &Asset<'_>, node: usize, lane: usize) -> Vec<u32> {
    let triangles = asset.triangles();
    let slots = slots(asset, node, lane);
    let corners = slots.iter().filter_map(|slot| triangles.get(*slot));
    let mut all: Vec<u32> = corners.flat_map(|triangle| triangle.corners).collect();
    all.sort_unstable();
    all.dedup();
    all
}
