//! Puts the corners of leaves side by side and finds all boxes: those of leaves first, then all others from the last node to the
//! first, since children stand behind their nodes. Of all nodes, or of some that follow each other.

use bdtree_format::{LANES, TriangleRecord};

use super::record::groups_of;
use super::vertices::Deformed;
use super::{Boxes, RefinedLeaf, RefinedNode};
use crate::cache::CHUNK;
use crate::error::{FormatError, QueryError};
use crate::simd::{Four, Lanes, Work};
use crate::traverse::{Subtree, lane_subtree, used_lanes};
use crate::view::Asset;

/// Nodes whose leaves are to be put side by side, from one on.
#[derive(Debug)]
pub(super) struct Leaves<'p, D> {
    pub(super) asset: &'p Asset<'p>,
    pub(super) vertices: D,
    pub(super) first_node: u32,
    pub(super) nodes: &'p mut [RefinedNode],
    pub(super) first_leaf: u32,
    pub(super) leaves: &'p mut [RefinedLeaf],
    /// What is added to the numbers of nodes that lanes lead to (modulo 2^32).
    pub(super) shift: u32,
}

impl<D: Deformed> Work for Leaves<'_, D> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let asset = self.asset;
        let mut leaf_count = 0;
        for (index, slot) in (self.first_node..).zip(self.nodes) {
            let node = asset.node(index)?;
            let used = used_lanes(node);
            *slot = RefinedNode {
                boxes: Boxes::EMPTY,
                starts: [0; LANES],
                triangles: [0; LANES],
                used,
                inner_mask: used & !node.leaf_mask,
                unused: [0; 6],
            };
            let mut corners = [Corners::EMPTY; LANES];
            // Where the lane's leaf begins among the node's triangles, and among its groups.
            let (mut before, mut groups) = (0, leaf_count);
            for lane in 0..LANES {
                let count = node.leaf_counts[lane];
                let (start, first) = (node.first_slot.saturating_add(before), groups);
                before += u32::from(count);
                groups += groups_of(count);
                if used >> lane & 1 == 0 {
                    continue;
                }
                if node.leaf_mask >> lane & 1 == 0 {
                    slot.starts[lane] = lane_subtree(node, lane).start.wrapping_add(self.shift);
                    continue;
                }
                slot.starts[lane] = self.first_leaf + first;
                slot.triangles[lane] = count;
                let triangles = u32::from(count);
                let records = asset.leaf(Subtree { start, triangles })?;
                // As many as were counted.
                let room = self.leaves.get_mut(first as usize..groups as usize);
                let room = room.unwrap_or_default();
                leaf::<L>(asset, records, self.vertices, room, &mut corners[lane])?;
            }
            leaf_count = groups;
            slot.boxes = boxes::<L>(&corners);
        }
        Ok(())
    }
}

/// Finds the boxes of lanes that lead to nodes.
pub(super) struct Inner<'p> {
    pub(super) asset: &'p Asset<'p>,
    pub(super) nodes: &'p mut [RefinedNode],
    /// The number of the first of them.
    pub(super) first: u32,
}

impl Work for Inner<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            asset,
            nodes,
            first,
        } = self;
        for index in (0..nodes.len()).rev() {
            let (front, behind) = nodes.split_at_mut(index + 1);
            let slot = &mut front[index];
            let mut lanes = slot.inner_mask;
            if lanes == 0 {
                continue;
            }
            let mut corners = [Corners::EMPTY; LANES];
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize & (LANES - 1);
                lanes &= lanes - 1;
                let child = slot.starts[lane];
                let place = (child.wrapping_sub(first) as usize).wrapping_sub(index + 1);
                let Some(child) = behind.get(place) else {
                    asset.node(child)?; // says that it does not exist
                    continue;
                };
                corners[lane].of_boxes(&child.boxes);
            }
            slot.boxes.add::<L>(&boxes::<L>(&corners));
        }
        Ok(())
    }
}

impl Boxes {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; LANES]; 3],
        high: [[f32::NEG_INFINITY; LANES]; 3],
    };

    /// Makes each box hold another one too.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, other: &Self) {
        for axis in 0..3 {
            let (low, high) = (&mut self.low[axis], &mut self.high[axis]);
            *low = L::load(low).min(L::load(&other.low[axis])).store();
            *high = L::load(high).max(L::load(&other.high[axis])).store();
        }
    }
}

/// The least and the greatest of what a lane holds, of each coordinate in four parts.
#[derive(Clone, Copy)]
pub(super) struct Corners {
    low: [[f32; 4]; 3],
    high: [[f32; 4]; 3],
}

impl Corners {
    pub(super) const EMPTY: Self = Self {
        low: [[f32::INFINITY; 4]; 3],
        high: [[f32::NEG_INFINITY; 4]; 3],
    };

    /// Becomes that of all boxes of a node.
    #[inline(always)]
    pub(super) fn of_boxes(&mut self, boxes: &Boxes) {
        for axis in 0..3 {
            let ([low, low_rest], _) = boxes.low[axis].as_chunks::<4>() else {
                continue; // a row is two fours
            };
            let ([high, high_rest], _) = boxes.high[axis].as_chunks::<4>() else {
                continue;
            };
            self.low[axis] = Four::load(low).min(Four::load(low_rest)).store();
            self.high[axis] = Four::load(high).max(Four::load(high_rest)).store();
        }
    }
}

/// Puts the corners of a leaf's triangles side by side, and the least and the greatest of them into `all`.
#[inline(always)]
fn leaf<L: Lanes>(
    asset: &Asset<'_>,
    mut records: &[TriangleRecord],
    vertices: impl Deformed,
    groups: &mut [RefinedLeaf],
    all: &mut Corners,
) -> Result<(), FormatError> {
    for (index, group) in groups.iter_mut().enumerate() {
        let Some(first) = records.first() else {
            break;
        };
        let four = [0, 1, 2, 3].map(|k| records.get(k).unwrap_or(first));
        let [mut low, mut high] = [[Four::splat(0.0); 3]; 2];
        vertices.corners::<L>(asset, four, |i, axis, of| {
            group.corners[i][axis] = of.store();
            (low[axis], high[axis]) = match i {
                0 => (of, of),
                _ => (low[axis].min(of), high[axis].max(of)),
            };
        })?;
        for k in 0..4 {
            group.ids[k] = four[k].id;
        }
        records = records.get(CHUNK..).unwrap_or_default();
        // Seldom more than one.
        if index > 0 {
            for axis in 0..3 {
                low[axis] = low[axis].min(Four::load(&all.low[axis]));
                high[axis] = high[axis].max(Four::load(&all.high[axis]));
            }
        }
        // Row by row where they are needed: as a result they were copied number by number.
        for axis in 0..3 {
            (all.low[axis], all.high[axis]) = (low[axis].store(), high[axis].store());
        }
    }
    Ok(())
}

/// Eight boxes from the parts of eight lanes.
#[inline(always)]
pub(super) fn boxes<L: Lanes>(of: &[Corners; LANES]) -> Boxes {
    let mut boxes = Boxes {
        low: [[0.0; LANES]; 3],
        high: [[0.0; LANES]; 3],
    };
    let [a, b, c, d, e, f, g, h] = of;
    for axis in 0..3 {
        let rows = [a, b, c, d, e, f, g, h].map(|of| &of.low[axis]);
        let [p, q, r, s] = L::columns(rows);
        boxes.low[axis] = p.min(q).min(r.min(s)).store();
        let rows = [a, b, c, d, e, f, g, h].map(|of| &of.high[axis]);
        let [p, q, r, s] = L::columns(rows);
        boxes.high[axis] = p.max(q).max(r.max(s)).store();
    }
    boxes
}
