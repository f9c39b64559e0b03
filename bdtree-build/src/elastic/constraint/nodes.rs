//! Which nodes of a volume mesh `--fix` holds.

use crate::elastic::constraint::fix::{Fix, FixRegion};
use crate::elastic::constraint::node_list::read_list;
use crate::error::{BakeError, Place};
use crate::input::volume::RawVolume;

/// Boxes reach this share of an element farther, for the rounding of coordinates.
const SLACK: f64 = 1e-6;

/// Whether x, y, z of each node are held. `used` tells which nodes an element has; `unit` is the
/// size of an element.
///
/// # Errors
/// All of them: fixes that hold nothing, unknown node sets, bad lists; and nothing left to move.
pub(crate) fn constrain_nodes(
    volume: &RawVolume,
    used: &[bool],
    unit: f64,
    fixes: &[Fix],
) -> Result<Vec<[bool; 3]>, BakeError> {
    let mut held = vec![[false; 3]; volume.nodes.len()];
    let mut sound = Ok(());
    for fix in fixes {
        let nodes = match region_nodes(volume, unit, &fix.region) {
            Ok(nodes) => nodes,
            Err(error) => {
                sound = Err(error.after(sound));
                continue;
            }
        };
        let mut any = false;
        for node in nodes.into_iter().map(|n| n as usize) {
            if used.get(node).is_some_and(|&u| u) {
                any = true;
                for (own, axis) in held[node].iter_mut().zip(fix.axes) {
                    *own |= axis;
                }
            }
        }
        if !any {
            let error = BakeError::one("basis", fix.region.place(), "it holds no part of the body");
            sound = Err(error.after(sound));
        }
    }
    sound?;
    let mut body = held.iter().zip(used).filter(|(_, u)| **u);
    if body.all(|(axes, _)| *axes == [true; 3]) {
        let message = "everything is held, so nothing can vibrate";
        return Err(BakeError::one("basis", Place::option("--fix"), message));
    }
    Ok(held)
}

fn region_nodes(volume: &RawVolume, unit: f64, region: &FixRegion) -> Result<Vec<u32>, BakeError> {
    match region {
        FixRegion::Box { min, max } => {
            let slack = SLACK * unit;
            let inside =
                |p: &[f64; 3]| (0..3).all(|a| min[a] - slack <= p[a] && p[a] <= max[a] + slack);
            let all = volume.nodes.iter().zip(0..);
            Ok(all.filter(|(p, _)| inside(p)).map(|(_, n)| n).collect())
        }
        FixRegion::Group(name) => {
            let sets = volume.node_sets.iter().filter(|s| s.name == *name);
            let nodes: Vec<u32> = sets.clone().flat_map(|s| s.nodes.iter().copied()).collect();
            if sets.count() == 0 {
                let message = "the volume mesh has no node set of this name";
                return Err(BakeError::one("basis", region.place(), message));
            }
            Ok(nodes)
        }
        FixRegion::List(path) => read_list(path, volume.nodes.len(), "node"),
    }
}
