//! One tree against a primitive.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::leaves::Leaves;
use super::nearest::nearest_first;
use super::refined::{Mixed, RefinedWalk};
use super::shared::Shared;
use super::unrefined::Nothing;
use super::visit::{NO_NODE, TOGETHER, look};
use super::visitor::{Visitor, Walk};
use super::{StackEntry, lane_subtree};
use crate::cache::Posed;
use crate::depth::DepthLimit;
use crate::error::QueryError;
use crate::simd::{Lanes, Work};

/// Visits what the visitor wants, nearest lanes first if it is ordered, else in lane order.
#[inline]
pub(crate) fn one<V: Visitor>(
    mut posed: Posed<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    let asset = posed.pose.asset;
    let needed = asset.stack_len();
    let found = stack.len();
    if found < needed {
        return Err(QueryError::Memory { needed, found });
    }
    let limit = posed.take_limit(asset);
    if V::HAS_BOXES
        && limit.is_none()
        && let Some(Mixed { tree, rest }) = Mixed::of(&mut posed)
    {
        let walk = match rest {
            None => asset.kernel.run(RefinedWalk {
                tree,
                rest: &mut Nothing,
                stack,
                visitor,
            }),
            Some(mut rest) => asset.kernel.run(RefinedWalk {
                tree,
                rest: &mut rest,
                stack,
                visitor,
            }),
        };
        return walk.map(Walk::of_boxes::<V>);
    }
    let walk = asset.kernel.run(OneWalk {
        posed: &mut posed,
        stack,
        visitor,
        limit,
    });
    walk.map(Walk::of::<V>)
}

/// A walk and who it is for: node bounds and the visitor's test of them are one piece of code,
/// leaves another.
struct OneWalk<'w, 's, 'l, V> {
    posed: &'w mut Posed<'s>,
    stack: &'w mut [StackEntry],
    visitor: &'w mut V,
    limit: Option<DepthLimit<'l>>,
}

impl<V: Visitor> OneWalk<'_, '_, '_, V> {
    /// The walk that all visitors of an order share.
    #[inline(always)]
    fn shared<L: Lanes, const ORDERED: bool>(self) -> Result<Walk, QueryError> {
        L::apart(OneWalk {
            posed: self.posed,
            stack: self.stack,
            visitor: &mut Shared::<ORDERED>(self.visitor),
            limit: self.limit,
        })
    }
}

impl<V: Visitor> Work for OneWalk<'_, '_, '_, V> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        if L::IS_COMPACT && !V::IS_SHARED {
            return if V::ORDERED {
                self.shared::<L, true>()
            } else {
                self.shared::<L, false>()
            };
        }
        let Self {
            posed,
            stack,
            visitor,
            mut limit,
        } = self;
        if V::ORDERED {
            nearest_first::<L, V>(posed, stack, visitor, &mut limit)
        } else {
            in_lane_order::<L, V>(posed, stack, visitor, &mut limit)
        }
    }
}

/// Visits everything that the visitor wants.
#[inline(always)]
fn in_lane_order<L: Lanes, V: Visitor>(
    posed: &mut Posed<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
    limit: &mut Option<DepthLimit<'_>>,
) -> Result<Walk, QueryError> {
    let pose = posed.pose;
    let asset = pose.asset;
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
            let met = look::<L, V>(
                posed,
                entries[k].at.start,
                &mut keys,
                &mut leaves,
                visitor,
                limit,
                &mut walk,
            )?;
            match met {
                ControlFlow::Continue(met) => found[k] = met,
                ControlFlow::Break(()) => return Ok(walk),
            }
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
    walk.triangles = leaves.taken(asset);
    walk.stopped = leaves.finish::<L, V>(posed, visitor)?.is_break();
    Ok(walk)
}
