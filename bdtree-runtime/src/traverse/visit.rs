//! One visit of a walk of one tree.

use bdtree_format::{LANES, NodeRecord, Row};
use core::ops::ControlFlow;

use super::lane_subtree;
use super::leaves::Leaves;
use super::visitor::{Visitor, Walk};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::Posed;
use crate::depth::Depth;
use crate::error::QueryError;
use crate::simd::Lanes;
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
pub(super) fn look<'s, L: Lanes, V: Visitor, D: Depth>(
    posed: &mut Posed<'s>,
    index: u32,
    keys: &mut Row,
    leaves: &mut Leaves,
    visitor: &mut V,
    depth: &mut D,
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
    if !D::LIMITED {
        return Ok(ControlFlow::Continue((node, mask)));
    }
    let visit = Visit {
        node,
        spheres: spheres.store(),
        keys: *keys,
        mask,
    };
    Ok(
        match visit.settle::<L, V, D>(asset, posed, leaves, visitor, depth)? {
            ControlFlow::Continue(left) => ControlFlow::Continue((node, left)),
            ControlFlow::Break(()) => {
                walk.stopped = true;
                ControlFlow::Break(())
            }
        },
    )
}

/// A node as a limited walk finds it.
struct Visit<'a> {
    node: &'a NodeRecord,
    spheres: Spheres,
    /// The visitor's keys of the lanes, and those that it wants.
    keys: Row,
    mask: u8,
}

impl Visit<'_> {
    /// Looks at the wanted lanes that end here, leaves and those at the last level, the nearest first: at once, so that what
    /// they answer is known before anything below is visited, and no sphere is reported that it rules out. The lanes
    /// that are left.
    #[inline(always)]
    fn settle<L: Lanes, V: Visitor, D: Depth>(
        self,
        asset: &Asset<'_>,
        posed: &mut Posed<'_>,
        leaves: &mut Leaves,
        visitor: &mut V,
        depth: &mut D,
    ) -> Result<ControlFlow<(), u8>, QueryError> {
        let node = self.node;
        let mut ending = self.mask;
        if !depth.ends(node) {
            ending &= node.leaf_mask;
        }
        let left = self.mask & !ending;
        while ending != 0 {
            let lane = self.nearest(ending);
            ending &= !(1 << lane);
            if V::ORDERED && !visitor.wanted(self.keys[lane]) {
                continue;
            }
            let flow = if node.leaf_mask & (1 << lane) != 0 {
                leaves.take::<L, V>(asset, posed, lane_subtree(node, lane), visitor)?
            } else {
                depth.report(posed.pose, &self.spheres, lane)
            };
            if flow.is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(left))
    }

    /// The lane of the least key, of equal ones the lowest.
    fn nearest(&self, mut lanes: u8) -> usize {
        let mut nearest = lanes.trailing_zeros() as usize & (LANES - 1);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            if self.keys[lane] < self.keys[nearest] {
                nearest = lane;
            }
        }
        nearest
    }
}
