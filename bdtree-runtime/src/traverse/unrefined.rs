//! What a walk visits where only branches of a pose are refined: the nodes and leaves of the others, on the same stack.
//!
//! An entry of the stack that has the bit [`UNREFINED`] leads to a node or a triangle slot of the asset. The low byte of its
//! `triangles` counts those of a leaf, and what is above is the branch, counted from 1: 0 above the branches, where the node may be
//! the root of one.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::leaves::{Near, test};
use super::visitor::{Visitor, Walk};
use super::wide_stack::WideStack;
use super::{Subtree, lane_subtree};
use crate::bound::WideSpheres;
use crate::cache::{CHUNK, LeafChunk, Posed};
use crate::error::QueryError;
use crate::refined::Branches;
use crate::simd::{Lanes, Order, Work};
use crate::view::Asset;

/// Marks what is not refined.
pub(crate) const UNREFINED: u32 = 1 << 31;

/// Where the branch's number is.
const BRANCH: u32 = 8;

/// # Errors
/// An entry that the asset does not have, and whose number may have the bit.
pub(crate) fn there_is(asset: &Asset<'_>, at: Subtree) -> Result<(), QueryError> {
    match at.triangles {
        0 => _ = asset.node(at.start)?,
        _ => _ = asset.leaf(at)?,
    }
    Ok(())
}

/// What walks need where not all is refined.
pub(crate) struct Unrefined<'u> {
    posed: Posed<'u>,
    branches: Branches<'u>,
    spare: LeafChunk,
}

impl<'u> Unrefined<'u> {
    /// Of a pose with what is kept of it, and its branches.
    pub(super) fn new(posed: Posed<'u>, branches: Branches<'u>) -> Self {
        Self {
            posed,
            branches,
            spare: LeafChunk::EMPTY,
        }
    }
}

/// What is not refined of a pose: [`Unrefined`], or [`Nothing`], so that walks of poses that are refined as a whole are compiled
/// without.
pub(super) trait Rest {
    /// Where an entry leads among what is refined; or visits it, and whether the walk goes on.
    fn come_to<L: Lanes, V: Visitor>(
        &mut self,
        at: Subtree,
        stack: &mut WideStack<'_>,
        near: &mut Near,
        visitor: &mut V,
        walk: &mut Walk,
    ) -> Result<ControlFlow<ControlFlow<()>, Subtree>, QueryError>;

    /// Where an entry leads among what is refined.
    fn refined(&self, at: Subtree) -> Option<Subtree>;
}

pub(super) struct Nothing;

impl Rest for Nothing {
    #[inline(always)]
    fn come_to<L: Lanes, V: Visitor>(
        &mut self,
        at: Subtree,
        _: &mut WideStack<'_>,
        _: &mut Near,
        _: &mut V,
        _: &mut Walk,
    ) -> Result<ControlFlow<ControlFlow<()>, Subtree>, QueryError> {
        Ok(ControlFlow::Continue(at))
    }

    #[inline(always)]
    fn refined(&self, at: Subtree) -> Option<Subtree> {
        Some(at)
    }
}

impl Rest for Unrefined<'_> {
    #[inline(always)]
    fn come_to<L: Lanes, V: Visitor>(
        &mut self,
        at: Subtree,
        stack: &mut WideStack<'_>,
        near: &mut Near,
        visitor: &mut V,
        walk: &mut Walk,
    ) -> Result<ControlFlow<ControlFlow<()>, Subtree>, QueryError> {
        if at.start & UNREFINED == 0 {
            return Ok(ControlFlow::Continue(at));
        }
        let start = at.start & !UNREFINED;
        let mut branch = at.triangles >> BRANCH;
        if at.triangles == 0 {
            let (number, refined) = self.branches.enter(start);
            if let Some(start) = refined {
                return Ok(ControlFlow::Continue(root(start)));
            }
            branch = number.map_or(0, |number| number + 1);
        }
        let visit = Visit {
            at: Subtree {
                start,
                triangles: at.triangles & !(u32::MAX << BRANCH),
            },
            branch,
            unrefined: self,
            stack,
            near,
            visitor,
            walk,
        };
        Ok(ControlFlow::Break(L::apart(visit)?))
    }

    #[inline(always)]
    fn refined(&self, at: Subtree) -> Option<Subtree> {
        match (at.start & UNREFINED, at.triangles) {
            (0, _) => Some(at),
            (_, 0) => self.branches.refined(at.start & !UNREFINED).map(root),
            _ => None,
        }
    }
}

/// The root of a branch, at this node.
#[inline(always)]
fn root(start: u32) -> Subtree {
    Subtree {
        start,
        triangles: 0,
    }
}

/// A visit, as work of its own: walks of poses that are refined as a whole are not made larger by it.
struct Visit<'v, 'u, 's, V> {
    at: Subtree,
    /// Counted from 1; 0 for none.
    branch: u32,
    unrefined: &'v mut Unrefined<'u>,
    stack: &'v mut WideStack<'s>,
    near: &'v mut Near,
    visitor: &'v mut V,
    walk: &'v mut Walk,
}

impl<V: Visitor> Work for Visit<'_, '_, '_, V> {
    type Output = Result<ControlFlow<()>, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let gain = match self.at.triangles {
            0 => V::NODE_GAIN,
            triangles => triangles.into(),
        };
        if self.branch > 0 {
            self.unrefined.branches.count(self.branch - 1, gain);
        }
        match self.at.triangles {
            0 => self.node::<L>().map(ControlFlow::Continue),
            _ => self.leaf::<L>(),
        }
    }
}

impl<V: Visitor> Visit<'_, '_, '_, V> {
    #[inline(always)]
    fn node<L: Lanes>(self) -> Result<(), QueryError> {
        let Self {
            unrefined, branch, ..
        } = self;
        let start = self.at.start;
        let posed = &mut unrefined.posed;
        let asset = posed.pose.asset;
        self.walk.nodes_visited += 1;
        let visits_max = asset.node_count() as u64;
        if self.walk.nodes_visited > visits_max {
            return Err(asset.endless(visits_max).into());
        }
        let node = asset.node(start)?;
        if !posed.keeps_node(start) {
            asset.prefetch_triangles(node);
        }
        let mut spheres = WideSpheres::<L>::empty();
        let evaluated = posed.spheres(asset, start, &mut spheres)?;
        self.walk.nodes_updated += u64::from(evaluated);
        let mut keys: Row = [0.0; LANES];
        let met = self.visitor.lanes(spheres, &mut keys) & (node.inner_mask | node.leaf_mask);
        let (mut starts, mut triangles) = ([0; LANES], [0; LANES]);
        let (mut mask, mut left) = (0, met);
        while left != 0 {
            let lane = left.trailing_zeros() as usize & (LANES - 1);
            left &= left - 1;
            let at = lane_subtree(node, lane);
            if node.leaf_mask >> lane & 1 != 0 && at.triangles == 0 {
                continue; // a corrupt file's
            }
            there_is(asset, at)?;
            mask |= 1 << lane;
            starts[lane] = at.start | UNREFINED;
            triangles[lane] = at.triangles | branch << BRANCH;
            if at.triangles == 0 {
                posed.prefetch_node(asset, at.start);
            } else if !posed.keeps_leaf(at.start) {
                asset.prefetch_vertices(asset.leaf(at)?);
            }
        }
        let order = L::Order::new(&keys, mask);
        let room = self.stack.push(
            &order.keys(&keys),
            &order.numbers(&starts),
            &order.numbers(&triangles),
            mask.count_ones() as usize,
        );
        match room {
            true => Ok(()),
            false => Err(asset.too_deep().into()),
        }
    }

    #[inline(always)]
    fn leaf<L: Lanes>(self) -> Result<ControlFlow<()>, QueryError> {
        let Unrefined { posed, spare, .. } = self.unrefined;
        let pose = posed.pose;
        let asset = pose.asset;
        let mut start = self.at.start;
        self.walk.triangles += u64::from(self.at.triangles);
        asset.fewer(asset.triangle_count() as u64, self.walk.triangles)?;
        for records in asset.leaf(self.at)?.chunks(CHUNK) {
            let chunk = posed.leaf(asset, start, records, spare)?;
            start = start.saturating_add(CHUNK as u32);
            let misses = self.visitor.misses_four::<L::Quad>(&chunk.corners);
            let mut left = !misses & !(u8::MAX << chunk.len);
            while left != 0 {
                let k = (left.trailing_zeros() & 3) as usize;
                left &= left - 1;
                let (id, corners) = (chunk.ids[k], chunk.stored(k));
                let (near, frame) = (&mut *self.near, &pose.placement);
                if test::<L, V>(near, frame, id, &corners, self.visitor).is_break() {
                    self.walk.stopped = true;
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}
