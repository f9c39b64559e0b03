//! One tree against a primitive.

use bdtree_format::{LANES, NodeRecord, Row, SectionKind, TriangleRecord, row_count};
use core::ops::ControlFlow;

use super::{StackEntry, lane_subtree};
use crate::bound::{WideSpheres, evaluate};
use crate::contact::TriangleId;
use crate::deform::RecentVertices;
use crate::error::QueryError;
use crate::frame::Frame;
use crate::narrow::Triangle;
use crate::pose::Pose;
use crate::simd::{Lanes, Quad, prefetch};
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

    /// Takes up to four triangles, as [`Visitor::triangle`] would one after the other.
    #[inline(always)]
    fn four<Q: Quad>(&mut self, frame: &Frame, four: &Four) -> ControlFlow<()> {
        for k in 0..four.len {
            self.triangle(TriangleId(four.ids[k]), &four.world(frame, k))?;
        }
        ControlFlow::Continue(())
    }

    /// Takes a triangle's world corners; `Break` ends the traversal.
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()>;
}

/// Triangles that wait for being tested together.
#[derive(Default)]
pub(crate) struct Four {
    pub(crate) ids: [u32; 4],
    /// Stored units: of each corner, of each coordinate, that of the four.
    pub(crate) corners: [[[f32; 4]; 3]; 3],
    /// How many there are.
    pub(crate) len: usize,
}

impl Four {
    /// Adds a triangle; there must be room.
    #[inline(always)]
    fn push(&mut self, id: u32, corners: &[[f32; 3]; 3]) {
        let k = self.len & 3;
        self.ids[k] = id;
        for i in 0..3 {
            for axis in 0..3 {
                self.corners[i][axis][k] = corners[i][axis];
            }
        }
        self.len = k + 1;
    }

    /// The corners of triangle `k` (stored units).
    #[inline(always)]
    fn stored(&self, k: usize) -> [[f32; 3]; 3] {
        let mut corners = [[0.0; 3]; 3];
        for i in 0..3 {
            for axis in 0..3 {
                corners[i][axis] = self.corners[i][axis][k];
            }
        }
        corners
    }

    /// The world corners of triangle `k`.
    #[inline(always)]
    pub(crate) fn world(&self, frame: &Frame, k: usize) -> Triangle {
        let [a, b, c] = self.stored(k);
        [frame.world(a), frame.world(b), frame.world(c)]
    }
}

/// Nodes that are evaluated one right after the other where the order of visits is free: the
/// second does not wait for the first one's numbers.
const TOGETHER: usize = 2;

/// Stands where no second node is.
const NO_NODE: NodeRecord = NodeRecord {
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
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    pub(crate) nodes_visited: u64,
    /// The visitor broke off.
    pub(crate) stopped: bool,
}

/// Visits what the visitor wants, nearest lanes first if it is ordered, else in lane order.
#[inline]
pub(crate) fn one<V: Visitor>(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    if asset.lists_modes() {
        asset.kernel.walk::<V, true>(asset, pose, stack, visitor)
    } else {
        asset.kernel.walk::<V, false>(asset, pose, stack, visitor)
    }
}

/// [`one`] for one instruction set and one layout of displacements (`LISTED`: the vertices list
/// their modes): inlined where the former is enabled, so that node bounds, the visitor's test of
/// them and the leaves are one piece of code.
#[inline(always)]
pub(crate) fn walk<L: Lanes, V: Visitor, const LISTED: bool>(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    if !pose.belongs_to(asset) {
        return Err(QueryError::PoseMismatch);
    }
    let needed = asset.stack_len();
    let found = stack.len();
    let Some(stack) = stack.get_mut(..needed) else {
        return Err(QueryError::Memory { needed, found });
    };
    let mut walk = Walk {
        nodes_visited: 0,
        stopped: false,
    };
    let visits_max = asset.node_count() as u64;
    let mut keys: Row = [0.0; LANES];
    let mut recent = RecentVertices::new();
    // Triangles not yet rejected, and those that were not.
    let (mut fresh, mut near) = (Four::default(), Four::default());
    stack[0] = StackEntry { node: 0, key: 0.0 };
    let mut len = 1;
    while len > 0 {
        let together = if V::ORDERED { 1 } else { len.min(TOGETHER) };
        len -= together;
        let entries = [stack[len], stack[len + together - 1]];
        if V::ORDERED && !visitor.wanted(entries[0].key) {
            continue;
        }
        walk.nodes_visited += together as u64;
        if walk.nodes_visited > visits_max {
            return Err(asset.endless(visits_max).into());
        }
        let mut found = [(&NO_NODE, 0); TOGETHER];
        for k in 0..together {
            let node = asset.node(entries[k].node)?;
            asset.prefetch_triangles(node);
            let (rows, modes) = (asset.node_rows(node)?, asset.node_modes(node)?);
            // Spelled out: behind a function that takes `evaluate` it would not be compiled with
            // the instruction set of the caller.
            let Some(spheres) = evaluate::<L>(&rows, modes, &pose.bound()) else {
                return Err(asset.unknown_mode(node.mode_list_start).into());
            };
            let mask = visitor.lanes(spheres, &mut keys) & (node.inner_mask | node.leaf_mask);
            found[k] = (node, mask);
        }
        for k in 0..together {
            let (node, mask) = found[k];
            let (order, count) = order(mask, &keys, V::ORDERED);
            let lanes = &order[..count];

            // Farthest first, so that the nearest is popped next.
            let mut rest = count;
            while rest > 0 {
                rest -= 1;
                let lane = lanes[rest];
                if node.leaf_mask & (1 << lane) != 0 {
                    continue;
                }
                let Some(slot) = stack.get_mut(len) else {
                    return Err(asset.too_deep().into());
                };
                let child = lane_subtree(node, lane).start;
                asset.prefetch_node(child);
                *slot = StackEntry {
                    node: child,
                    key: keys[lane],
                };
                len += 1;
            }
            if mask & node.leaf_mask == 0 {
                continue;
            }
            for &lane in lanes {
                if node.leaf_mask & (1 << lane) != 0 {
                    for record in asset.leaf(node, lane)? {
                        recent.prefetch::<LISTED>(asset, record);
                    }
                }
            }
            for &lane in lanes {
                if node.leaf_mask & (1 << lane) == 0 || (V::ORDERED && !visitor.wanted(keys[lane]))
                {
                    continue;
                }
                for record in asset.leaf(node, lane)? {
                    let stored = asset.stored_triangle::<LISTED>(pose, record, &mut recent)?;
                    if V::IN_FOURS {
                        fresh.push(record.id, &stored);
                        if fresh.len == 4
                            && hand_on::<L, V>(pose, &mut fresh, &mut near, visitor).is_break()
                        {
                            walk.stopped = true;
                            return Ok(walk);
                        }
                        continue;
                    }
                    if visitor.misses(&stored) {
                        continue;
                    }
                    let corners = [
                        pose.frame.world(stored[0]),
                        pose.frame.world(stored[1]),
                        pose.frame.world(stored[2]),
                    ];
                    if visitor.triangle(TriangleId(record.id), &corners).is_break() {
                        walk.stopped = true;
                        return Ok(walk);
                    }
                }
            }
        }
    }
    walk.stopped = V::IN_FOURS
        && (hand_on::<L, V>(pose, &mut fresh, &mut near, visitor).is_break()
            || visitor.four::<L::Quad>(&pose.frame, &near).is_break());
    Ok(walk)
}

/// Moves those of `fresh` that may be answers to `near`, which the visitor takes whenever it is
/// full.
#[inline(always)]
fn hand_on<L: Lanes, V: Visitor>(
    pose: &Pose<'_>,
    fresh: &mut Four,
    near: &mut Four,
    visitor: &mut V,
) -> ControlFlow<()> {
    let misses = visitor.misses_four::<L::Quad>(&fresh.corners);
    let mut left = !misses & !(u8::MAX << fresh.len);
    fresh.len = 0;
    while left != 0 {
        let k = (left.trailing_zeros() & 3) as usize;
        left &= left - 1;
        near.push(fresh.ids[k], &fresh.stored(k));
        if near.len == 4 {
            visitor.four::<L::Quad>(&pose.frame, near)?;
            near.len = 0;
        }
    }
    ControlFlow::Continue(())
}

impl<'a> Asset<'a> {
    /// The triangles of a leaf lane.
    #[inline(always)]
    fn leaf(&self, node: &NodeRecord, lane: usize) -> Result<&'a [TriangleRecord], QueryError> {
        let leaf = lane_subtree(node, lane);
        let start = leaf.start as usize;
        let end = start.saturating_add(leaf.triangles as usize);
        match self.triangles.get(start..end) {
            Some(records) => Ok(records),
            None => {
                let len = self.triangles.len();
                Err(self
                    .out_of_range(SectionKind::TRIANGLES, end, len, 16)
                    .into())
            }
        }
    }

    /// Asks for a node's record and the beginning of its rows; reading on is the processor's own
    /// habit. Where the rows are follows from the index if all modes act on all nodes, which is
    /// the usual case; otherwise the record would have to be waited for.
    #[inline(always)]
    fn prefetch_node(&self, index: u32) {
        /// Of 64 bytes: two rows each, or four of 16 bits.
        const LINES: usize = 8;
        let index = index as usize;
        let Some(node) = self.nodes.get(index) else {
            return; // the visit says so
        };
        prefetch(node);
        let stride = row_count(self.modes.len());
        if self.nodes.len().checked_mul(stride) == Some(self.rows.len()) {
            let start = index * stride;
            if let Some(rows) = self.rows.get(start..start + 2 * LINES) {
                let (lines, _) = rows.as_chunks::<2>();
                for line in lines {
                    prefetch(line);
                }
            }
        }
    }

    /// Asks for the triangles of a node's leaf lanes, before its spheres are known.
    #[inline(always)]
    fn prefetch_triangles(&self, node: &NodeRecord) {
        /// Records in a cache line.
        const PER_LINE: usize = 4;
        /// Of most eight lanes of four triangles.
        const RECORDS: usize = 32;
        if node.leaf_mask != 0 {
            let start = (node.first_slot as usize).min(self.triangles.len());
            let end = (start + RECORDS).min(self.triangles.len());
            for line in self.triangles[start..end].chunks(PER_LINE) {
                prefetch(&line[0]);
            }
        }
    }
}

/// The set lanes, by key (stable) if `ordered`, else ascending; and how many there are.
#[inline(always)]
fn order(mask: u8, keys: &Row, ordered: bool) -> ([usize; LANES], usize) {
    let mut lanes = [0; LANES];
    let mut count = 0;
    let mut left = mask;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let mut at = count;
        if ordered {
            while at > 0 && keys[lanes[at - 1]] > keys[lane] {
                lanes[at] = lanes[at - 1];
                at -= 1;
            }
        }
        lanes[at] = lane;
        count += 1;
    }
    (lanes, count)
}
