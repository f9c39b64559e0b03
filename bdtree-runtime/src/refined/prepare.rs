//! Deforms all vertices, puts the corners of leaves side by side, and finds all boxes: those of leaves first, then all others
//! from the last node to the first, since children stand behind their nodes.

use bdtree_format::{LANES, TriangleRecord};

use super::record::groups_before;
use super::{Boxes, RefinedLeaf, RefinedNode};
use crate::cache::CHUNK;
use crate::contact::VertexId;
use crate::error::{FormatError, QueryError};
use crate::pose::Pose;
use crate::simd::{Four, Lanes, Work};
use crate::traverse::{lane_subtree, used_lanes};
use crate::view::Asset;

/// Fills all three.
///
/// # Errors
/// A corrupt asset.
pub(super) fn prepare(
    pose: &Pose<'_>,
    nodes: &mut [RefinedNode],
    leaves: &mut [RefinedLeaf],
    vertices: &mut [[f32; 4]],
) -> Result<(), QueryError> {
    pose.asset.kernel.run(Prepare {
        pose,
        nodes,
        leaves,
        vertices,
    })
}

struct Prepare<'w> {
    pose: &'w Pose<'w>,
    nodes: &'w mut [RefinedNode],
    leaves: &'w mut [RefinedLeaf],
    /// The fourth number is not used.
    vertices: &'w mut [[f32; 4]],
}

impl Work for Prepare<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            pose,
            nodes,
            leaves,
            vertices,
        } = self;
        let asset = pose.asset;
        deform::<L>(pose, vertices)?;
        let mut leaf_count = 0;
        for (index, slot) in nodes.iter_mut().enumerate() {
            let node = asset.node(index as u32)?;
            let used = used_lanes(node);
            *slot = RefinedNode {
                boxes: Boxes::EMPTY,
                starts: [0; LANES],
                triangles: [0; LANES],
                inner_mask: used & !node.leaf_mask,
                leaf_mask: used & node.leaf_mask,
                unused: [0; 6],
            };
            let mut corners = [Corners::EMPTY; LANES];
            let mut lanes = used;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize & (LANES - 1);
                lanes &= lanes - 1;
                let subtree = lane_subtree(node, lane);
                if subtree.triangles == 0 {
                    slot.starts[lane] = subtree.start;
                    continue;
                }
                let first = leaf_count + groups_before(&node.leaf_counts, lane);
                (slot.starts[lane], slot.triangles[lane]) = (first, node.leaf_counts[lane]);
                let records = asset.leaf(subtree)?;
                // As many as were counted.
                let room = leaves.get_mut(first as usize..);
                let room = room.unwrap_or_default();
                leaf(asset, records, vertices, room, &mut corners[lane])?;
            }
            leaf_count += groups_before(&node.leaf_counts, LANES);
            slot.boxes = boxes::<L>(&corners);
        }
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

/// Puts all deformed vertices into `out`, to the bit as [`Pose::deformed_stored`] says.
#[inline(always)]
fn deform<L: Lanes>(pose: &Pose<'_>, out: &mut [[f32; 4]]) -> Result<(), FormatError> {
    const TOGETHER: usize = 12;
    let mut first = 0;
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
    records: &[TriangleRecord],
    vertices: &[[f32; 4]],
    out: &mut [RefinedLeaf],
    all: &mut Corners,
) -> Result<(), FormatError> {
    let infinite = [f32::INFINITY, f32::NEG_INFINITY].map(|x| [Four::splat(x); 3]);
    let [mut low, mut high] = infinite;
    for (records, out) in records.chunks(CHUNK).zip(out) {
        let Some(first) = records.first() else {
            continue;
        };
        let four = [0, 1, 2, 3].map(|k| records.get(k).unwrap_or(first));
        gather(asset, four, vertices, |i, axis, of| {
            out.corners[i][axis] = of.store();
            low[axis] = low[axis].min(of);
            high[axis] = high[axis].max(of);
        })?;
        for k in 0..4 {
            out.ids[k] = four[k].id;
        }
    }
    // Row by row where they are needed: as a result they were copied number by number.
    for axis in 0..3 {
        (all.low[axis], all.high[axis]) = (low[axis].store(), high[axis].store());
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
