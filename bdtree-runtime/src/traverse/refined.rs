//! A walk of one tree whose pose is refined: boxes instead of spheres, and leaves that are deformed already.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::leaves::{Near, take_near, test};
use super::shared::Shared;
use super::unrefined::{Rest, Unrefined};
use super::visitor::{Visitor, Walk};
use super::wide_stack::WideStack;
use super::{StackEntry, Subtree};
use crate::cache::{CHUNK, Posed};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::refined::{Bounds, Refined};
use crate::simd::{Lanes, Order, Work, prefetch_lines};

/// What is walked: the same pose twice.
#[derive(Clone, Copy)]
pub(super) struct RefinedTree<'w> {
    pub(super) pose: &'w Pose<'w>,
    pub(super) refined: Refined<'w>,
}

/// The same, with what is not refined of it: nothing, if `None`.
pub(crate) struct Mixed<'w> {
    pub(super) tree: RefinedTree<'w>,
    pub(super) rest: Option<Unrefined<'w>>,
}

impl<'w> Mixed<'w> {
    pub(crate) fn pose(&self) -> &'w Pose<'w> {
        self.tree.pose
    }

    /// A pose, if some of it is refined and walks use that.
    #[inline]
    pub(crate) fn of<'p: 'w>(posed: &'w mut Posed<'p>) -> Option<Self> {
        if posed.limit.is_some() {
            return None;
        }
        let pose = posed.pose;
        match core::mem::replace(&mut posed.refined, Bounds::Unrefined) {
            Bounds::Unrefined => None,
            Bounds::Whole(refined) => {
                let tree = RefinedTree { pose, refined };
                Some(Self { tree, rest: None })
            }
            Bounds::Some(refined, branches) => {
                core::hint::cold_path();
                let tree = RefinedTree { pose, refined };
                let rest = Some(Unrefined::new(posed.again(), branches));
                Some(Self { tree, rest })
            }
        }
    }
}

/// A walk and who it is for.
pub(super) struct RefinedWalk<'w, V, R> {
    pub(super) tree: RefinedTree<'w>,
    pub(super) rest: &'w mut R,
    pub(super) stack: &'w mut [StackEntry],
    pub(super) visitor: &'w mut V,
}

impl<V: Visitor, R: Rest> RefinedWalk<'_, V, R> {
    #[inline(always)]
    fn shared<L: Lanes, const ORDERED: bool>(self) -> Result<Walk, QueryError> {
        L::apart(RefinedWalk {
            tree: self.tree,
            rest: self.rest,
            stack: self.stack,
            visitor: &mut Shared::<ORDERED>(self.visitor),
        })
    }
}

impl<V: Visitor, R: Rest> Work for RefinedWalk<'_, V, R> {
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
            tree,
            rest,
            stack,
            visitor,
        } = self;
        let mut walk = Walk::default();
        let mut near = Near::default();
        let mut stack = WideStack::new(stack);
        while let Some(at) = stack.pop(|key| !V::ORDERED || visitor.wanted(key)) {
            let (stack, near, walk) = (&mut stack, &mut near, &mut walk);
            if visit::<L, V, R>(tree, rest, at, stack, near, visitor, walk)?.is_break() {
                return Ok(*walk);
            }
        }
        if V::IN_FOURS {
            let frame = &tree.pose.placement;
            walk.stopped = take_near::<L, V>(&mut near, frame, visitor).is_break();
        }
        Ok(walk)
    }
}

/// One visit: of a leaf, or of a node, whose lanes are put onto the stack, the nearest on top.
#[inline(always)]
pub(super) fn visit<L: Lanes, V: Visitor, R: Rest>(
    tree: RefinedTree<'_>,
    rest: &mut R,
    at: Subtree,
    stack: &mut WideStack<'_>,
    near: &mut Near,
    visitor: &mut V,
    walk: &mut Walk,
) -> Result<ControlFlow<()>, QueryError> {
    let RefinedTree { pose, refined } = tree;
    let asset = pose.asset;
    let at = match rest.come_to::<L, V>(at, stack, near, visitor, walk)? {
        ControlFlow::Continue(refined) => refined,
        ControlFlow::Break(flow) => return Ok(flow),
    };
    if at.triangles > 0 {
        walk.triangles += u64::from(at.triangles);
        // Nodes of a corrupt file may share leaves, which preparing does not see.
        asset.fewer(asset.triangle_count() as u64, walk.triangles)?;
        // What is on top now lay below the leaf when it was put there: nobody has asked for it yet.
        ask_for_top(refined, rest, stack);
        let flow = leaf::<L, V>(tree, at, near, visitor);
        walk.stopped = flow.is_break();
        return Ok(flow);
    }
    walk.nodes_visited += 1;
    let visits_max = asset.node_count() as u64;
    let node = refined.nodes.get(at.start as usize);
    let (Some(node), true) = (node, walk.nodes_visited <= visits_max) else {
        return Err(asset.endless(visits_max).into());
    };
    let mut keys: Row = [0.0; LANES];
    let mask = visitor.boxes::<L>(&node.boxes, &mut keys) & node.used;
    let order = L::Order::new(&keys, mask);
    let room = stack.push(
        &order.keys(&keys),
        &order.numbers(&node.starts),
        &order.bytes(&node.triangles),
        mask.count_ones() as usize,
    );
    if !room {
        return Err(asset.too_deep().into());
    }
    ask_for_top(refined, rest, stack);
    Ok(ControlFlow::Continue(()))
}

/// Asks for all of what is visited next, wherever that begins in a line.
#[inline(always)]
fn ask_for_top(refined: Refined<'_>, rest: &impl Rest, stack: &WideStack<'_>) {
    let Some(at) = stack.top().and_then(|at| rest.refined(at)) else {
        return;
    };
    let start = at.start as usize;
    let leaf: *const u8 = refined.leaves.as_ptr().wrapping_add(start).cast();
    let node: *const u8 = refined.nodes.as_ptr().wrapping_add(start).cast();
    // Without a branch: which it is cannot be foreseen.
    let at = core::hint::select_unpredictable(at.triangles > 0, leaf, node);
    prefetch_lines::<4, _>(at);
}

/// Hands the triangles of a leaf to the visitor, or, in fours, keeps some of them back.
#[inline(always)]
fn leaf<L: Lanes, V: Visitor>(
    tree: RefinedTree<'_>,
    at: Subtree,
    near: &mut Near,
    visitor: &mut V,
) -> ControlFlow<()> {
    let start = at.start as usize;
    let end = start + (at.triangles as usize).div_ceil(CHUNK);
    let mut count = at.triangles;
    for leaf in tree.refined.leaves.get(start..end).unwrap_or_default() {
        let misses = visitor.misses_four::<L::Quad>(&leaf.corners);
        let mut left = !misses & !(u8::MAX << count.min(CHUNK as u32));
        count = count.saturating_sub(CHUNK as u32);
        while left != 0 {
            let k = (left.trailing_zeros() & 3) as usize;
            left &= left - 1;
            // One number at a time: rows need not be copied.
            let corner = |i: usize| [0, 1, 2].map(|axis| leaf.corners[i][axis][k]);
            let corners = [corner(0), corner(1), corner(2)];
            test::<L, V>(near, &tree.pose.placement, leaf.ids[k], &corners, visitor)?;
        }
    }
    ControlFlow::Continue(())
}
