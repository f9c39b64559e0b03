//! One tree against a primitive.

use bdtree_format::{LANES, NodeRecord, Row};
use core::ops::ControlFlow;

use super::leaves::{Four, Leaves};
use super::nearest::nearest_first;
use super::{StackEntry, lane_subtree};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::Posed;
use crate::contact::TriangleId;
use crate::depth::{Depth, Unlimited};
use crate::error::QueryError;
use crate::frame::Frame;
use crate::narrow::Triangle;
use crate::simd::{Lanes, Quad, Work};
use crate::view::Asset;

/// A question about one deformed mesh.
pub(crate) trait Visitor {
    /// Whether nearer lanes are to be visited first (by `keys`).
    const ORDERED: bool;

    /// The lanes that may hold an answer, and, when ordered, a lower bound for each of what the
    /// question minimises. Anything not proved useless is kept, NaN included.
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8;

    /// Whether a subtree with this lower bound may still hold an answer.
    fn wanted(&self, key: f32) -> bool;

    /// Whether a triangle with these corners (stored units) certainly is no answer: a cheap test
    /// that spares the exact one.
    #[inline(always)]
    fn misses(&self, _corners: &[[f32; 3]; 3]) -> bool {
        false
    }

    /// Whether triangles are taken four at a time, by [`Visitor::four`].
    const IN_FOURS: bool = false;

    /// [`Visitor::misses`] for four (of each corner, of each coordinate, that of the four).
    #[inline(always)]
    fn misses_four<Q: Quad>(&self, _corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        0
    }

    /// Takes up to eight triangles, as [`Visitor::triangle`] would one after the other.
    #[inline(always)]
    fn fours<Q: Quad>(&mut self, frame: &Frame, fours: &[Four; 2]) -> ControlFlow<()> {
        for four in fours {
            for k in 0..four.len {
                self.triangle(TriangleId(four.ids[k]), &four.world(frame, k))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Takes a triangle's world corners; `Break` ends the traversal.
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()>;
}

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

/// What a traversal did.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Walk {
    pub(crate) nodes_visited: u64,
    /// Of them, those whose spheres were evaluated.
    pub(crate) nodes_updated: u64,
    /// The visitor broke off.
    pub(crate) stopped: bool,
}

/// Visits what the visitor wants, nearest lanes first if it is ordered, else in lane order.
#[inline]
pub(crate) fn one<V: Visitor>(
    asset: &Asset<'_>,
    mut posed: Posed<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    if !posed.pose.belongs_to(asset) {
        return Err(QueryError::PoseMismatch);
    }
    let needed = asset.stack_len();
    let found = stack.len();
    if found < needed {
        return Err(QueryError::Memory { needed, found });
    }
    match posed.take_limit(asset) {
        None => asset.kernel.run(OneWalk {
            asset,
            posed,
            stack,
            visitor,
            depth: Unlimited,
        }),
        Some(depth) => asset.kernel.run(OneWalk {
            asset,
            posed,
            stack,
            visitor,
            depth,
        }),
    }
}

/// A walk and who it is for: node bounds and the visitor's test of them are one piece of code,
/// leaves another.
struct OneWalk<'w, 's, 'a, V, D> {
    asset: &'w Asset<'a>,
    posed: Posed<'s>,
    stack: &'w mut [StackEntry],
    visitor: &'w mut V,
    depth: D,
}

impl<V: Visitor, D: Depth> Work for OneWalk<'_, '_, '_, V, D> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            asset,
            mut posed,
            stack,
            visitor,
            mut depth,
        } = self;
        if V::ORDERED {
            nearest_first::<L, V, D>(asset, &mut posed, stack, visitor, &mut depth)
        } else {
            in_lane_order::<L, V, D>(asset, &mut posed, stack, visitor, &mut depth)
        }
    }
}

/// Visits everything that the visitor wants.
#[inline(always)]
fn in_lane_order<L: Lanes, V: Visitor, D: Depth>(
    asset: &Asset<'_>,
    posed: &mut Posed<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
    depth: &mut D,
) -> Result<Walk, QueryError> {
    let pose = posed.pose;
    let mut walk = Walk::default();
    let visits_max = asset.node_count() as u64;
    let mut keys: Row = [0.0; LANES];
    let mut leaves = Leaves::new(asset);
    stack[0] = StackEntry::default();
    let mut len = 1;
    while len > 0 {
        let together = len.min(TOGETHER);
        len -= together;
        let entries = [stack[len], stack[len + together - 1]];
        walk.nodes_visited += together as u64;
        if walk.nodes_visited > visits_max {
            return Err(asset.endless(visits_max).into());
        }
        let mut found = [(&NO_NODE, 0); TOGETHER];
        for k in 0..together {
            let index = entries[k].at.start;
            let node = asset.node(index)?;
            if !posed.keeps_node(index) {
                asset.prefetch_triangles(node);
            }
            let mut spheres = WideSpheres::<L>::empty();
            let evaluated = posed.spheres(asset, index, &mut spheres)?;
            walk.nodes_updated += u64::from(evaluated);
            let mut mask = visitor.lanes(spheres, &mut keys) & (node.inner_mask | node.leaf_mask);
            if D::LIMITED {
                let at = Visit {
                    node,
                    spheres: spheres.store(),
                    keys,
                    mask,
                };
                match at.settle::<L, V, D>(asset, posed, &mut leaves, visitor, depth)? {
                    ControlFlow::Continue(left) => mask = left,
                    ControlFlow::Break(()) => {
                        walk.stopped = true;
                        return Ok(walk);
                    }
                }
            }
            found[k] = (node, mask);
        }
        for k in 0..together {
            let (node, mask) = found[k];
            // Last first, so that the first is popped next.
            let mut inner = mask & !node.leaf_mask;
            while inner != 0 {
                let lane = (7 - inner.leading_zeros()) as usize;
                inner &= !(1 << lane);
                let Some(slot) = stack.get_mut(len) else {
                    return Err(asset.too_deep().into());
                };
                let at = lane_subtree(node, lane);
                posed.prefetch_node(asset, at.start);
                *slot = StackEntry { at, key: 0.0 };
                len += 1;
            }
            let mut left = mask & node.leaf_mask;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let leaf = lane_subtree(node, lane);
                if !posed.keeps_leaf(leaf.start) {
                    asset.prefetch_vertices(asset.leaf(leaf)?);
                }
            }
            let mut left = mask & node.leaf_mask;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let leaf = lane_subtree(node, lane);
                let flow = leaves.take::<L, V>(asset, posed, leaf, visitor)?;
                if flow.is_break() {
                    walk.stopped = true;
                    return Ok(walk);
                }
            }
        }
    }
    walk.stopped = leaves.finish::<L, V>(asset, pose, visitor)?.is_break();
    Ok(walk)
}

/// A node as a limited walk finds it.
pub(super) struct Visit<'a> {
    pub(super) node: &'a NodeRecord,
    pub(super) spheres: Spheres,
    /// The visitor's keys of the lanes, and those that it wants.
    pub(super) keys: Row,
    pub(super) mask: u8,
}

impl Visit<'_> {
    /// Looks at the wanted lanes that end here, leaves and those at the last level, the nearest first: at once, so that what
    /// they answer is known before anything below is visited, and no sphere is reported that it rules out. The lanes
    /// that are left.
    #[inline(always)]
    pub(super) fn settle<L: Lanes, V: Visitor, D: Depth>(
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
