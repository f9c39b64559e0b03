//! Two trees against each other, in the frame of the first.
//!
//! A visit takes one node of each tree and tests eight lanes against eight. Where both lanes are
//! inner, both trees descend; the leaf lanes of one node stay together while the other descends.

use bdtree_format::LANES;
use core::ops::ControlFlow;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::apart::{Apart, Found};
use super::byte_masks::{BYTES, any_row, columns, gather, lowest, rows};
use super::pair_leaves::run_leaves;
use super::pair_side::Side;
use super::{PairStackEntry, Subtree, Walk, bounded, lane_subtree};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::Posed;
use crate::contact::TriangleId;
use crate::error::QueryError;
use crate::frame::PairFrame;
use crate::narrow::Triangle;
use crate::simd::{Lanes, Work};
use crate::view::Asset;

/// Relative error of a squared distance and a sum of two radii in f32 (docs/guarantees.md).
const SKIP: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// Nodes that a traversal keeps for itself where the caller grants fewer.
const NODES: usize = 16;

/// Most pairs of leaf lanes that are collected, two visits' worth, so that their triangles are on the way from memory
/// before the first is looked at.
const QUEUE: usize = 2 * LANES * LANES;

/// A question about pairs of triangles of two deformed meshes.
pub(crate) trait PairVisitor {
    /// Farther apart, triangles are no answer (world units).
    fn tolerance(&self) -> f64;

    /// Told of the pairs of leaves whose spheres meet.
    fn meet(&mut self, _leaves: &[FrontSlot]) {}

    /// Takes the world corners of two triangles that may be an answer; `Break` ends the traversal.
    fn triangles(
        &mut self,
        a: TriangleId,
        corners_a: &Triangle,
        b: TriangleId,
        corners_b: &Triangle,
    ) -> ControlFlow<()>;
}

/// What a pair traversal walks.
pub(crate) struct Two<'s, 'a> {
    pub(crate) assets: [&'s Asset<'a>; 2],
    pub(crate) posed: [Posed<'s>; 2],
    pub(crate) frame: &'s PairFrame,
    /// Only these pairs of leaves are looked at, if there are any given, and no nodes.
    pub(crate) leaves: Option<&'s [FrontSlot]>,
}

/// Memory for a pair of leaves.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct FrontSlot {
    pub(super) a: Subtree,
    pub(super) b: Subtree,
}

impl FrontSlot {
    /// A slot to fill memory with.
    pub(crate) const EMPTY: Self = Self {
        a: Subtree {
            start: 0,
            triangles: 0,
        },
        b: Subtree {
            start: 0,
            triangles: 0,
        },
    };
}

impl Two<'_, '_> {
    /// Visits all pairs of leaf triangles whose lanes' spheres meet, with the first asset's kernel.
    pub(crate) fn walk(
        self,
        stack: &mut [PairStackEntry],
        visitor: &mut dyn PairVisitor,
    ) -> Result<Walk, QueryError> {
        let [asset_a, asset_b] = self.assets;
        let needed = asset_a.pair_stack_len(asset_b);
        let found = stack.len();
        let Some(stack) = stack.get_mut(..needed) else {
            return Err(QueryError::Memory { needed, found });
        };
        let [posed_a, posed_b] = self.posed;
        if posed_a.is_bounded() || posed_b.is_bounded() {
            let (a, b) = ((asset_a, posed_a), (asset_b, posed_b));
            return bounded::two(a, b, self.frame, stack, visitor);
        }
        let (mut nodes_a, mut nodes_b) = (None, None);
        let mut posed_a = posed_a.at_least::<NODES>(asset_a, &mut nodes_a);
        let mut posed_b = posed_b.at_least::<NODES>(asset_b, &mut nodes_b);
        let mut before = Found::default();
        if self.leaves.is_none() {
            before = asset_a.kernel.run(Apart {
                assets: self.assets,
                posed: [&mut posed_a, &mut posed_b],
                frame: self.frame,
                stack,
            })?;
        }
        let mut walk = Walk::default();
        if !before.apart {
            let two = Two {
                assets: self.assets,
                posed: [posed_a, posed_b],
                frame: self.frame,
                leaves: self.leaves,
            };
            walk = asset_a.kernel.run(TwoWalk {
                two,
                stack,
                visitor,
            })?;
        }
        walk.nodes_visited += before.nodes_visited;
        walk.nodes_updated += before.nodes_updated;
        Ok(walk)
    }
}

/// A walk and who it is for.
struct TwoWalk<'w, 's, 'a> {
    two: Two<'s, 'a>,
    stack: &'w mut [PairStackEntry],
    visitor: &'w mut (dyn PairVisitor + 'w),
}

impl Work for TwoWalk<'_, '_, '_> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        walk_two::<L>(self.two, self.stack, self.visitor)
    }
}

#[inline(always)]
fn walk_two<L: Lanes>(
    two: Two<'_, '_>,
    stack: &mut [PairStackEntry],
    visitor: &mut dyn PairVisitor,
) -> Result<Walk, QueryError> {
    let [asset_a, asset_b] = two.assets;
    let [posed_a, posed_b] = two.posed;
    let frame = two.frame;
    // In a sound pair of trees two nodes meet at most once with all lanes, and never again with
    // the leaf lanes of one if they did.
    let nodes = |asset: &Asset<'_>| asset.node_count() as u64;
    let visits_max = nodes(asset_a)
        .saturating_mul(nodes(asset_b))
        .saturating_mul(3);
    let mut visits = 0;
    let mut nodes_visited = 0;
    // It meets each pair of triangles once.
    let mut tests_left = asset_a.triangle_count() as u64 * asset_b.triangle_count() as u64;

    let mut a = Side::new(asset_a, posed_a);
    let mut b = Side::new(asset_b, posed_b);
    if let Some(kept) = two.leaves {
        let mut stopped = false;
        for pairs in kept.chunks(QUEUE) {
            for pair in pairs {
                a.announce_leaf(pair.a)?;
                b.announce_leaf(pair.b)?;
            }
            stopped = run_leaves(&mut a, &mut b, pairs, &mut tests_left, visitor)?.is_break();
            if stopped {
                break;
            }
        }
        return Ok(Walk {
            stopped,
            ..Walk::default()
        });
    }
    let mut queue = [FrontSlot::EMPTY; QUEUE];
    let mut queued = 0;
    let Some(first) = stack.first_mut() else {
        return Err(asset_a.too_deep().into());
    };
    *first = PairStackEntry {
        a: 0,
        b: 0,
        sphere: EVERYWHERE,
        lanes_a: u8::MAX,
        lanes_b: u8::MAX,
        unused: [0; 2],
    };
    let mut len = 1;
    loop {
        if len == 0 || queued > QUEUE - LANES * LANES {
            let pairs = queue.get(..queued).unwrap_or_default();
            visitor.meet(pairs);
            let stopped = run_leaves(&mut a, &mut b, pairs, &mut tests_left, visitor)?.is_break();
            queued = 0;
            if stopped || len == 0 {
                return Ok(Walk {
                    nodes_visited,
                    nodes_updated: a.updated + b.updated,
                    stopped,
                });
            }
        }
        len -= 1;
        let entry = stack[len];
        visits += 1;
        if visits > visits_max {
            return Err(asset_a.endless(visits_max).into());
        }
        nodes_visited += 1;
        let mut spheres_a = WideSpheres::<L>::empty();
        let node_a = a.node(entry.a, &mut spheres_a)?;
        let [x, y, z, radius] = entry.sphere;
        let lanes_a = entry.lanes_a & spheres_a.within([x, y, z], radius, SKIP);
        if lanes_a & (node_a.inner_mask | node_a.leaf_mask) == 0 {
            continue;
        }
        nodes_visited += 1;
        let mut spheres_b = WideSpheres::<L>::empty();
        let node_b = b.node(entry.b, &mut spheres_b)?;
        if node_a.leaf_mask & lanes_a != 0 && node_b.leaf_mask & entry.lanes_b != 0 {
            asset_a.prefetch_triangles(node_a);
            asset_b.prefetch_triangles(node_b);
        }
        let spheres_a = spheres_a.store();
        let spheres_b = frame.carry(spheres_b);
        let stored_b = spheres_b.store();
        let leaf_a = node_a.leaf_mask & lanes_a;
        let leaf_b = node_b.leaf_mask & entry.lanes_b;
        let inner_a = node_a.inner_mask & !node_a.leaf_mask & lanes_a;
        let inner_b = node_b.inner_mask & !node_b.leaf_mask & entry.lanes_b;

        // Byte i, bit j: lane i of a meets lane j of b.
        let mut meets = 0_u64;
        let mut left = leaf_a | inner_a;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & (LANES - 1);
            left &= left - 1;
            let [x, y, z, radius] = lane_sphere(&spheres_a, lane);
            let mask = spheres_b.within([x, y, z], radius, SKIP);
            meets |= u64::from(mask) << (8 * lane);
        }
        let (rows_leaf, rows_inner) = (rows(leaf_a), rows(inner_a));
        let (columns_leaf, columns_inner) = (columns(leaf_b), columns(inner_b));

        // Inner lanes of a against all leaf lanes of b together.
        let mut found = lowest(meets & rows_inner & columns_leaf);
        while found != 0 {
            let lane = (found.trailing_zeros() as usize / 8) & (LANES - 1);
            found &= found - 1;
            let entry = PairStackEntry {
                a: lane_subtree(node_a, lane).start,
                b: entry.b,
                sphere: EVERYWHERE,
                lanes_a: u8::MAX,
                lanes_b: (meets >> (8 * lane)) as u8 & leaf_b,
                unused: [0; 2],
            };
            push(stack, &mut len, entry, asset_a)?;
        }
        // All leaf lanes of a together against inner lanes of b.
        let mut found = meets & rows_leaf & columns_inner;
        while found != 0 {
            let lane = found.trailing_zeros() as usize & (LANES - 1);
            let column = BYTES << lane;
            let lanes_a = gather((found & column) >> lane);
            found &= !column;
            let entry = PairStackEntry {
                a: entry.a,
                b: lane_subtree(node_b, lane).start,
                sphere: EVERYWHERE, // these lanes have been found to meet it
                lanes_a,
                lanes_b: u8::MAX,
                unused: [0; 2],
            };
            push(stack, &mut len, entry, asset_a)?;
        }
        let both = meets & rows_inner & columns_inner;
        a.prefetch_children(node_a, gather(lowest(both)));
        b.prefetch_children(node_b, any_row(both));
        let mut found = both;
        while found != 0 {
            let bit = found.trailing_zeros() as usize;
            let (lane_a, lane_b) = ((bit / 8) & (LANES - 1), bit & (LANES - 1));
            found &= found - 1;
            let entry = PairStackEntry {
                a: lane_subtree(node_a, lane_a).start,
                b: lane_subtree(node_b, lane_b).start,
                sphere: lane_sphere(&stored_b, lane_b),
                lanes_a: u8::MAX,
                lanes_b: u8::MAX,
                unused: [0; 2],
            };
            push(stack, &mut len, entry, asset_a)?;
        }

        let mut found = meets & rows_leaf & columns_leaf;
        if found == 0 {
            continue;
        }
        let leaves_a = a.announce(node_a, gather(lowest(found)))?;
        let leaves_b = b.announce(node_b, any_row(found))?;
        while found != 0 {
            let bit = found.trailing_zeros() as usize;
            found &= found - 1;
            let Some(slot) = queue.get_mut(queued) else {
                break; // there is room for all of a visit
            };
            *slot = FrontSlot {
                a: leaves_a[(bit / 8) & (LANES - 1)],
                b: leaves_b[bit & (LANES - 1)],
            };
            queued += 1;
        }
    }
}

/// Puts an entry on the stack.
#[inline(always)]
fn push(
    stack: &mut [PairStackEntry],
    len: &mut usize,
    entry: PairStackEntry,
    asset: &Asset<'_>,
) -> Result<(), QueryError> {
    let Some(slot) = stack.get_mut(*len) else {
        return Err(asset.too_deep().into());
    };
    *slot = entry;
    *len += 1;
    Ok(())
}

/// A sphere that everything meets.
pub(super) const EVERYWHERE: [f32; 4] = [0.0, 0.0, 0.0, f32::INFINITY];

/// One lane's centre and radius.
#[inline(always)]
fn lane_sphere(spheres: &Spheres, lane: usize) -> [f32; 4] {
    let [x, y, z] = &spheres.centre;
    [x[lane], y[lane], z[lane], spheres.radius[lane]]
}
