//! Walking one tree or two in the caller's memory.
//!
//! A traversal never trusts the file: every index is checked, children stand behind their node,
//! and it stops with `Corrupt` after as many visits, or pairs of triangles, as sound trees can
//! take, so shared or chained children cannot make it long.

mod budget;
mod byte_masks;
mod frontier;
mod gap;
mod leaf_pairs;
mod leaf_side;
mod leaves;
mod nearest;
mod nearest_two;
mod one;
mod pair_leaves;
mod pair_side;
mod pair_stack;
mod refined;
mod separating_plane;
mod shared;
mod sphere_triangles;
mod stream;
mod supports;
mod two;
mod unrefined;
mod visit;
mod visitor;
mod wide_stack;

pub(crate) use frontier::SearchEntry;
pub(crate) use pair_stack::FrontSlot;

pub(crate) use budget::{BudgetedOne, Queue};
pub(crate) use frontier::Stack;
pub(crate) use gap::Gap;
pub(crate) use leaf_pairs::LeafPairs;
pub(crate) use nearest_two::NearestTwo;
pub(crate) use one::one;
pub(crate) use refined::Mixed;
pub(crate) use stream::{Questions, STREAM, stream};
pub(crate) use two::Two;
pub(crate) use unrefined::{UNREFINED, there_is};
pub(crate) use visitor::{Four, PairVisitor, Visitor, Walk};

use bdtree_format::{NodeRecord, SectionKind};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::bound::{Spheres, evaluate};
use crate::error::{Datum, FormatError};
use crate::pose::Pose;
use crate::simd::{Lanes, Work, mask_of};
use crate::view::Asset;

/// One entry of a single-asset traversal's stack: a node or a leaf to visit.
#[derive(Debug, Clone, Copy, Default, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct StackEntry {
    at: Subtree,
    /// Lower bound of what the query minimises, below the node.
    key: f32,
}

/// One entry of a pair traversal's stack: two nodes, and which of their lanes are to meet.
#[derive(Debug, Clone, Copy, Default, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct PairStackEntry {
    a: u32,
    b: u32,
    /// Where lanes of `a` must reach, to be looked at again: the sphere (center, radius) of `b` in
    /// the frame of `a`.
    sphere: [f32; 4],
    lanes_a: u8,
    lanes_b: u8,
    /// Fills up to a multiple of four bytes.
    unused: [u8; 2],
}

/// A node, or the triangles of one leaf lane.
#[derive(Debug, Clone, Copy, Default, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct Subtree {
    /// Node index, or first triangle slot.
    pub(crate) start: u32,
    /// 0 for a node, else the number of triangles.
    pub(crate) triangles: u32,
}

/// The lanes that lead somewhere: a leaf lane without triangles (a corrupt one) does not.
pub(crate) fn used_lanes(node: &NodeRecord) -> u8 {
    (node.inner_mask & !node.leaf_mask) | (node.leaf_mask & mask_of(|k| node.leaf_counts[k] > 0))
}

/// What a lane leads to.
#[inline(always)]
pub(crate) fn lane_subtree(node: &NodeRecord, lane: usize) -> Subtree {
    let bit = 1_u8 << lane;
    if node.leaf_mask & bit != 0 {
        // The bytes below the lane's, added as four numbers of sixteen bits at once.
        const EVEN: u64 = 0x00ff_00ff_00ff_00ff;
        let below = u64::from_le_bytes(node.leaf_counts) & !(u64::MAX << (8 * lane));
        let pairs = (below & EVEN) + ((below >> 8) & EVEN);
        let before = (pairs.wrapping_mul(0x0001_0001_0001_0001) >> 48) as u32;
        Subtree {
            start: node.first_slot.saturating_add(before),
            triangles: u32::from(node.leaf_counts[lane]),
        }
    } else {
        let before = (node.inner_mask & (bit - 1)).count_ones();
        Subtree {
            start: node.first_child.saturating_add(before),
            triangles: 0,
        }
    }
}

impl<'a> Asset<'a> {
    /// A node by index; its children stand behind it.
    #[inline(always)]
    pub(crate) fn node(&self, index: u32) -> Result<&'a NodeRecord, FormatError> {
        let Some(node) = self.nodes.get(index as usize) else {
            let count = self.nodes.len();
            return Err(self.out_of_range(SectionKind::NODES, index as usize, count, 32));
        };
        // Not `&&`: whether a node has children cannot be foreseen, that they stand right can.
        if (node.inner_mask != 0) & (node.first_child <= index) {
            return Err(self.backward(index, node.first_child));
        }
        Ok(node)
    }

    /// The error for children that do not stand behind their node.
    #[cold]
    fn backward(&self, index: u32, first_child: u32) -> FormatError {
        FormatError {
            section: SectionKind::NODES,
            byte: self.section_offset(SectionKind::NODES) + 32 * u64::from(index),
            rule: "SPEC 6.8: a node's children stand behind it",
            expected: Datum::at_least(index + 1),
            found: Datum::Integer(u64::from(first_child)),
        }
    }

    /// The error for a mode list that names a mode the asset lacks.
    #[cold]
    pub(crate) fn unknown_mode(&self, mode_list_start: u32) -> FormatError {
        let at = mode_list_start as usize;
        FormatError {
            rule: "SPEC 6.7: mode lists hold indices below the mode count",
            found: Datum::Text("another index"),
            ..self.out_of_range(SectionKind::MODE_LISTS, at, self.mode_count(), 2)
        }
    }

    /// The error for a traversal that takes more visits than a tree allows.
    #[cold]
    pub(crate) fn endless(&self, limit: u64) -> FormatError {
        FormatError {
            section: SectionKind::NODES,
            byte: self.section_offset(SectionKind::NODES),
            rule: "SPEC 6.8: every node but the root is the child of exactly one node",
            expected: Datum::at_most(limit),
            found: Datum::Text("more visits: children are shared"),
        }
    }

    /// The error for a tree that is deeper than the header says.
    #[cold]
    fn too_deep(&self) -> FormatError {
        FormatError {
            section: SectionKind::NODES,
            byte: self.section_offset(SectionKind::NODES),
            rule: "SPEC 6.4: the header's depth is the number of node levels",
            expected: Datum::Integer(self.depth() as u64),
            found: Datum::Text("a deeper tree"),
        }
    }
}

impl Pose<'_> {
    /// The spheres of a node's eight lanes (stored units); those of empty lanes mean nothing. Cost: 10 flops
    /// per mode and lane, whatever the mesh.
    ///
    /// # Errors
    /// When the node, its rows or its mode list lie outside their sections.
    pub fn node_spheres(&self, index: u32) -> Result<Spheres, FormatError> {
        self.asset.kernel.run(NodeSpheres {
            asset: self.asset,
            pose: self,
            index,
        })
    }
}

/// [`Pose::node_spheres`].
struct NodeSpheres<'w, 'a> {
    asset: &'w Asset<'a>,
    pose: &'w Pose<'w>,
    index: u32,
}

impl Work for NodeSpheres<'_, '_> {
    type Output = Result<Spheres, FormatError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (asset, pose) = (self.asset, self.pose);
        let node = asset.node(self.index)?;
        let (rows, modes) = (asset.node_rows(node)?, asset.node_modes(node)?);
        let Some(spheres) = evaluate::<L>(&rows, modes, &pose.bound()) else {
            return Err(asset.unknown_mode(node.mode_list_start));
        };
        let mut spheres = spheres.store();
        if let Some(bones) = pose.bones() {
            asset.carry(self.index, bones, &mut spheres)?;
        }
        Ok(spheres)
    }
}
