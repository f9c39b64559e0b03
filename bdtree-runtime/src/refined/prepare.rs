//! Deforms all vertices, puts the corners of leaves side by side, and finds all boxes: those of leaves first, then all others
//! from the last node to the first, since children stand behind their nodes.
//!
//! The first two are done in parts, which may run at the same time.

use bdtree_format::{LANES, TriangleRecord};

use super::record::{groups_in, groups_of};
use super::{Boxes, RefinedLeaf, RefinedNode};
use crate::cache::CHUNK;
use crate::contact::VertexId;
use crate::error::{FormatError, QueryError};
use crate::pose::Pose;
use crate::simd::{Four, Lanes, Work};
use crate::traverse::{Subtree, lane_subtree, used_lanes};
use crate::view::Asset;

/// Most parts that preparing is split into: nodes without leaves may be one more.
const PARTS_MAX: usize = 32 + 1;

/// Vertices that are deformed together: the corners of four triangles.
const TOGETHER: usize = 12;

/// A part of preparing a pose, which any thread may run; [`RefinedPose::prepare_in_parts`](super::RefinedPose::prepare_in_parts)
/// hands them out.
#[derive(Debug, Default)]
pub struct PreparePart<'p> {
    work: PartWork<'p>,
    outcome: Option<Result<(), QueryError>>,
}

impl PreparePart<'_> {
    /// Does this part.
    pub fn run(&mut self) {
        // A kernel's work is moved into it.
        self.outcome = match core::mem::take(&mut self.work) {
            PartWork::Vertices(part) => Some(part.pose.asset.kernel.run(part)),
            PartWork::Leaves(part) => Some(part.pose.asset.kernel.run(part)),
            PartWork::Done => self.outcome.take(),
        };
    }
}

#[derive(Debug, Default)]
enum PartWork<'p> {
    Vertices(Vertices<'p>),
    Leaves(Leaves<'p>),
    #[default]
    Done,
}

/// Vertices to deform, from one on; the fourth number is not used.
#[derive(Debug)]
struct Vertices<'p> {
    pose: &'p Pose<'p>,
    first: u32,
    out: &'p mut [[f32; 4]],
}

/// Nodes whose leaves are to be put side by side, from one on.
#[derive(Debug)]
struct Leaves<'p> {
    pose: &'p Pose<'p>,
    vertices: &'p [[f32; 4]],
    first_node: u32,
    nodes: &'p mut [RefinedNode],
    first_leaf: u32,
    leaves: &'p mut [RefinedLeaf],
}

/// What is to be filled.
pub(super) struct Slots<'p> {
    pub(super) nodes: &'p mut [RefinedNode],
    pub(super) leaves: &'p mut [RefinedLeaf],
    pub(super) vertices: &'p mut [[f32; 4]],
}

/// Fills all slots, in so many parts or fewer.
///
/// # Errors
/// A corrupt asset, a part that was not run.
pub(super) fn prepare(
    pose: &Pose<'_>,
    slots: Slots<'_>,
    parts: usize,
    run: &mut dyn FnMut(&mut [PreparePart<'_>]),
) -> Result<(), QueryError> {
    let Slots {
        nodes,
        leaves,
        vertices,
    } = slots;
    let parts = parts.clamp(1, PARTS_MAX - 1);
    {
        let each = vertices.len().div_ceil(parts).next_multiple_of(TOGETHER);
        let starts = (0..).step_by(each.max(1));
        let of = vertices.chunks_mut(each.max(1)).zip(starts);
        run_all(
            of.map(|(out, first)| PartWork::Vertices(Vertices { pose, first, out })),
            run,
        )?;
    }
    let vertices = &*vertices;
    let split = Split {
        pose,
        vertices,
        each: leaves.len().div_ceil(parts) as u32,
        nodes: &mut *nodes,
        leaves,
        first_node: 0,
        first_leaf: 0,
    };
    run_all(split, run)?;
    pose.asset.kernel.run(Inner {
        asset: pose.asset,
        nodes,
    })
}

/// Has all run.
fn run_all<'p>(
    works: impl Iterator<Item = PartWork<'p>>,
    run: &mut dyn FnMut(&mut [PreparePart<'_>]),
) -> Result<(), QueryError> {
    let mut parts: [PreparePart<'_>; PARTS_MAX] = core::array::from_fn(|_| PreparePart::default());
    let mut count = 0;
    for (part, work) in parts.iter_mut().zip(works) {
        part.work = work;
        count += 1;
    }
    let parts = parts.get_mut(..count).unwrap_or_default();
    run(parts);
    for part in parts {
        let not_run = Err(QueryError::Argument("run: a part was not run"));
        part.outcome.take().unwrap_or(not_run)?;
    }
    Ok(())
}

/// Cuts nodes into parts of about as many leaves.
struct Split<'p> {
    pose: &'p Pose<'p>,
    vertices: &'p [[f32; 4]],
    /// Leaves of a part, from which on it ends.
    each: u32,
    nodes: &'p mut [RefinedNode],
    leaves: &'p mut [RefinedLeaf],
    first_node: u32,
    first_leaf: u32,
}

impl<'p> Iterator for Split<'p> {
    type Item = PartWork<'p>;

    fn next(&mut self) -> Option<PartWork<'p>> {
        if self.nodes.is_empty() {
            return None;
        }
        let from = self.pose.asset.nodes().get(self.first_node as usize..)?;
        let (mut node_count, mut leaf_count) = (0, 0);
        for node in from {
            node_count += 1;
            leaf_count += groups_in(&node.leaf_counts);
            if leaf_count >= self.each.max(1) {
                break;
            }
        }
        let nodes = core::mem::take(&mut self.nodes);
        let (nodes, rest) = nodes.split_at_mut(node_count.min(nodes.len()));
        self.nodes = rest;
        let leaves = core::mem::take(&mut self.leaves);
        let (leaves, rest) = leaves.split_at_mut((leaf_count as usize).min(leaves.len()));
        self.leaves = rest;
        let part = Leaves {
            pose: self.pose,
            vertices: self.vertices,
            first_node: self.first_node,
            nodes,
            first_leaf: self.first_leaf,
            leaves,
        };
        self.first_node += node_count as u32;
        self.first_leaf += leaf_count;
        Some(PartWork::Leaves(part))
    }
}

impl Work for Leaves<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let asset = self.pose.asset;
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
                    slot.starts[lane] = lane_subtree(node, lane).start;
                    continue;
                }
                slot.starts[lane] = self.first_leaf + first;
                slot.triangles[lane] = count;
                let triangles = u32::from(count);
                let records = asset.leaf(Subtree { start, triangles })?;
                // As many as were counted.
                let room = self.leaves.get_mut(first as usize..groups as usize);
                let room = room.unwrap_or_default();
                leaf(asset, records, self.vertices, room, &mut corners[lane])?;
            }
            leaf_count = groups;
            slot.boxes = boxes::<L>(&corners);
        }
        Ok(())
    }
}

/// Finds the boxes of lanes that lead to nodes.
struct Inner<'p> {
    asset: &'p Asset<'p>,
    nodes: &'p mut [RefinedNode],
}

impl Work for Inner<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { asset, nodes } = self;
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
                let Some(child) = behind.get(child as usize - index - 1) else {
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

/// To the bit as [`Pose::deformed_stored`] says.
impl Work for Vertices<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            pose,
            mut first,
            out,
        } = self;
        let (twelves, rest) = out.as_chunks_mut::<TOGETHER>();
        for twelve in twelves {
            // Twelve corners of four triangles.
            let record = |k: u32| TriangleRecord {
                corners: [first + k, first + 4 + k, first + 8 + k],
                id: 0,
            };
            let records = [record(0), record(1), record(2), record(3)];
            let [a, b, c, d] = &records;
            let mut corners = [[[0.0; 4]; 3]; 3];
            pose.asset
                .deform_four::<L>(pose, [a, b, c, d], &mut corners)?;
            let (fours, _) = twelve.as_chunks_mut::<4>();
            for (four, [x, y, z]) in fours.iter_mut().zip(&corners) {
                let columns = [
                    Four::load(x),
                    Four::load(y),
                    Four::load(z),
                    Four::splat(0.0),
                ];
                let rows = Four::transposed(columns);
                for k in 0..4 {
                    four[k] = rows[k].store();
                }
            }
            first += TOGETHER as u32;
        }
        for vertex in rest {
            let [x, y, z] = pose.deformed_stored(VertexId(first))?;
            *vertex = [x, y, z, 0.0];
            first += 1;
        }
        Ok(())
    }
}

/// The least and the greatest of what a lane holds, of each coordinate in four parts.
#[derive(Clone, Copy)]
struct Corners {
    low: [[f32; 4]; 3],
    high: [[f32; 4]; 3],
}

impl Corners {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; 4]; 3],
        high: [[f32::NEG_INFINITY; 4]; 3],
    };

    /// Becomes that of all boxes of a node.
    #[inline(always)]
    fn of_boxes(&mut self, boxes: &Boxes) {
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

/// Hands over each coordinate of each corner of four triangles: corner, axis and the four numbers.
///
/// # Errors
/// A vertex that the asset does not have.
#[inline(always)]
pub(super) fn gather(
    asset: &Asset<'_>,
    four: [&TriangleRecord; 4],
    vertices: &[[f32; 4]],
    mut take: impl FnMut(usize, usize, Four),
) -> Result<(), FormatError> {
    for i in 0..3 {
        let mut rows = [Four::splat(0.0); 4];
        for k in 0..4 {
            let vertex = four[k].corners[i];
            let Some(at) = vertices.get(vertex as usize) else {
                return Err(asset.unknown_vertex(VertexId(vertex)));
            };
            rows[k] = Four::load(at);
        }
        let columns = Four::transposed(rows);
        for axis in 0..3 {
            take(i, axis, columns[axis]);
        }
    }
    Ok(())
}

/// Puts the corners of a leaf's triangles side by side, and the least and the greatest of them into `all`.
#[inline(always)]
fn leaf(
    asset: &Asset<'_>,
    mut records: &[TriangleRecord],
    vertices: &[[f32; 4]],
    groups: &mut [RefinedLeaf],
    all: &mut Corners,
) -> Result<(), FormatError> {
    for (index, group) in groups.iter_mut().enumerate() {
        let Some(first) = records.first() else {
            break;
        };
        let four = [0, 1, 2, 3].map(|k| records.get(k).unwrap_or(first));
        let [mut low, mut high] = [[Four::splat(0.0); 3]; 2];
        gather(asset, four, vertices, |i, axis, of| {
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
fn boxes<L: Lanes>(of: &[Corners; LANES]) -> Boxes {
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
