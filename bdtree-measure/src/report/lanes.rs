//! Which triangles and vertices hang on a lane, and how tight its sphere is, found when asked for: measurements look
//! at a few of many.

use bdtree_build::wrap::ball::smallest_ball;
use bdtree_format::LANES;
use bdtree_runtime::{Asset, FormatError, Pose};

/// A sphere whose deformed vertices fit into this part of the whole is a point: its ratio is rounding.
const POINT_REL: f64 = 1e-6;

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

/// R'/R_opt of a lane, and R_opt: the radius of the smallest ball around the deformed vertices below it. `deformed` are
/// these vertices or some of them (stored units), `size` is the whole's (mesh units). `None` where the sphere is a
/// point.
///
/// # Errors
/// A corrupt asset.
pub fn tightness(
    pose: &Pose<'_>,
    node: usize,
    lane: usize,
    deformed: &[[f64; 3]],
    size: f64,
) -> Result<Option<[f64; 2]>, FormatError> {
    let best = smallest_ball(deformed).radius;
    if best * pose.asset().unit() <= POINT_REL * size {
        return Ok(None);
    }
    let radius = pose.node_spheres(node as u32)?.radius[lane];
    Ok(Some([f64::from(radius) / best, best]))
}
