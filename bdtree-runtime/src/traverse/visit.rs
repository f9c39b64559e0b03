//! One visit of a walk of one tree.

use bdtree_format::{LANES, NodeRecord, Row};
use core::ops::ControlFlow;

use super::lane_subtree;
use super::leaves::Leaves;
use super::visitor::{Visitor, Walk};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::Posed;
use crate::contact::LaneId;
use crate::depth::DepthLimit;
use crate::error::QueryError;
use crate::simd::{Lanes, Work};
use crate::view::Asset;

/// Nodes that are evaluated one right after the other where the order of visits is free: the
/// second does not wait for the first one's numbers.
pub(super) const TOGETHER: usize = 2;

/// Stands where no second node is.
pub(super) const NO_NODE: NodeRecord = NodeRecord {
    first_child: 0,
    first_slot: 0,
    row_start: 0,
    mode_list_start: 0,
    mode_count: 0,
    inner_mask: 0,
    leaf_mask: 0,
    leaf_counts: [0; LANES],
    level: 0,
    scale_exponents: [0; 3],
};

/// Looks at node `index`: asks for its triangles, tests its lanes, and settles what ends there in a limited walk. The
/// node and the lanes that are left.
#[inline(always)]
pub(super) fn look<'s, L: Lanes, V: Visitor>(
    posed: &mut Posed<'s>,
    index: u32,
    keys: &mut Row,
    leaves: &mut Leaves,
    visitor: &mut V,
    limit: &mut Option<DepthLimit<'_>>,
    walk: &mut Walk,
) -> Result<ControlFlow<(), (&'s NodeRecord, u8)>, QueryError> {
    let asset = posed.pose.asset;
    let node = asset.node(index)?;
    if !posed.keeps_node(index) {
        asset.prefetch_triangles(node);
    }
    let mut spheres = WideSpheres::<L>::empty();
    let evaluated = posed.spheres(asset, index, &mut spheres)?;
    walk.nodes_updated += u64::from(evaluated);
    let mask = visitor.lanes(spheres, keys) & (node.inner_mask | node.leaf_mask);
    let Some(limit) = limit else {
        return Ok(ControlFlow::Continue((node, mask)));
    };
    core::hint::cold_path();
    let settled = L::apart(Settle {
        asset,
        posed,
        leaves,
        visitor,
        limit,
        index,
        node,
        spheres: spheres.store(),
        keys: *keys,
        mask,
    })?;
    Ok(match settled {
        ControlFlow::Continue(left) => ControlFlow::Continue((node, left)),
        ControlFlow::Break(()) => {
            walk.stopped = true;
            ControlFlow::Break(())
        }
    })
}

/// A node as a limited walk finds it. As work of its own, so that walks without a limit are not made larger by it.
struct Settle<'w, 's, 'l, V> {
    asset: &'s Asset<'s>,
    posed: &'w mut Posed<'s>,
    leaves: &'w mut Leaves,
    visitor: &'w mut V,
    limit: &'w mut DepthLimit<'l>,
    index: u32,
    node: &'w NodeRecord,
    spheres: Spheres,
    /// The visitor's keys of the lanes, and those that it wants.
    keys: Row,
    mask: u8,
}

impl<V: Visitor> Work for Settle<'_, '_, '_, V> {
    /// The lanes that are left.
    type Output = Result<ControlFlow<(), u8>, QueryError>;

    /// Looks at the wanted lanes that end here, leaves and those at the last level, the nearest first: at once, so that what
    /// they answer is known before anything below is visited, and no sphere is reported that it rules out.
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (asset, posed, node) = (self.asset, self.posed, self.node);
        let mut ending = self.mask;
        if !self.limit.ends(node) {
            ending &= node.leaf_mask;
        }
        let left = self.mask & !ending;
        while ending != 0 {
            let lane = nearest(&self.keys, ending);
            ending &= !(1 << lane);
            if V::ORDERED && !self.visitor.wanted(self.keys[lane]) {
                continue;
            }
            let flow = if node.leaf_mask & (1 << lane) != 0 && !self.limit.leaves_too {
                let leaf = lane_subtree(node, lane);
                self.leaves.take::<L, V>(asset, posed, leaf, self.visitor)?
            } else {
                let lane = LaneId {
                    node: self.index,
                    lane: lane as u8,
                };
                self.limit.report(posed.pose, &self.spheres, lane)
            };
            if flow.is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(left))
    }
}

/// The lane of the least key, of equal ones the lowest.
fn nearest(keys: &Row, mut lanes: u8) -> usize {
    let mut nearest = lanes.trailing_zeros() as usize & (LANES - 1);
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & (LANES - 1);
        lanes &= lanes - 1;
        if keys[lane] < keys[nearest] {
            nearest = lane;
        }
    }
    nearest
}
