//! Two trees against each other, in the frame of the first.
//!
//! A visit takes one node of each tree and tests eight lanes against eight. Where both lanes are
//! inner, both trees descend; the leaf lanes of one node stay together while the other descends.

use bdtree_format::{LANES, NodeRecord, SectionKind, TriangleRecord};
use core::ops::ControlFlow;

use super::apart::{Apart, Found};
use super::{PairStackEntry, Subtree, Walk, bounded, lane_subtree};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::{CHUNK, LeafChunk, Posed};
use crate::contact::TriangleId;
use crate::deform::RecentVertices;
use crate::error::QueryError;
use crate::frame::PairFrame;
use crate::narrow::Triangle;
use crate::narrow::four_by_four::WorldFour;
use crate::simd::{Lanes, Work};
use crate::view::Asset;

/// Relative error of a squared distance and a sum of two radii in f32 (docs/guarantees.md).
const SKIP: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// Nodes that a traversal keeps for itself where the caller grants fewer.
const NODES: usize = 16;

/// Groups of four triangles in the world that a traversal keeps of each asset.
const FOURS: usize = 32;

/// Leaves that a traversal remembers having asked for.
const ANNOUNCED: usize = 64;

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
#[derive(Debug, Clone, Copy)]
pub struct FrontSlot {
    a: Subtree,
    b: Subtree,
}

impl FrontSlot {
    /// A slot to fill memory with.
    pub const EMPTY: Self = Self {
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

/// One side of the traversal.
struct Side<'s, 'a> {
    asset: &'s Asset<'a>,
    posed: Posed<'s>,
    recent: RecentVertices,
    /// Filled when they are first used: most pairs of bodies that are near each other do not get to
    /// their leaves.
    fours: [Option<KeptFour>; FOURS],
    /// First triangle slots of leaves whose vertices were asked for last.
    announced: [u32; ANNOUNCED],
    updated: u64,
}

/// Up to four triangles of a leaf in the world.
#[derive(Clone, Copy)]
struct KeptFour {
    /// First triangle slot.
    start: u32,
    /// How many there are; 0: nothing is kept.
    len: u32,
    ids: [u32; CHUNK],
    world: WorldFour,
}

impl KeptFour {
    const EMPTY: Self = Self {
        start: 0,
        len: 0,
        ids: [0; CHUNK],
        world: WorldFour::EMPTY,
    };
}

impl<'s, 'a> Side<'s, 'a> {
    fn new(asset: &'s Asset<'a>, posed: Posed<'s>) -> Self {
        Self {
            asset,
            posed,
            recent: RecentVertices::new(),
            fours: [const { None }; FOURS],
            announced: [u32::MAX; ANNOUNCED],
            updated: 0,
        }
    }

    /// A node; its spheres, in the asset's own frame, are put into `out`.
    #[inline(always)]
    fn node<L: Lanes>(
        &mut self,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<&'a NodeRecord, QueryError> {
        let node = self.asset.node(index)?;
        let evaluated = self.posed.spheres(self.asset, index, out)?;
        self.updated += u64::from(evaluated);
        Ok(node)
    }

    #[inline(always)]
    fn records(&self, leaf: Subtree) -> Result<&'a [TriangleRecord], QueryError> {
        let start = leaf.start as usize;
        let end = start.saturating_add(leaf.triangles as usize);
        match self.asset.triangles.get(start..end) {
            Some(records) => Ok(records),
            None => {
                let len = self.asset.triangles.len();
                Err(self
                    .asset
                    .out_of_range(SectionKind::TRIANGLES, end, len, 16)
                    .into())
            }
        }
    }

    /// Asks for what the children in `lanes` and the triangles of a node need.
    #[inline(always)]
    fn prefetch_children(&self, node: &NodeRecord, mut lanes: u8) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            let child = lane_subtree(node, lane).start;
            self.posed.prefetch_node(self.asset, child);
        }
    }

    /// The leaf lanes in `lanes`, whose vertices are asked for.
    #[inline(always)]
    fn announce(
        &mut self,
        node: &NodeRecord,
        mut lanes: u8,
    ) -> Result<[Subtree; LANES], QueryError> {
        let mut leaves = [Subtree::default(); LANES];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            leaves[lane] = lane_subtree(node, lane);
            self.announce_leaf(leaves[lane])?;
        }
        Ok(leaves)
    }

    /// Asks for the vertices of a leaf.
    #[inline(always)]
    fn announce_leaf(&mut self, leaf: Subtree) -> Result<(), QueryError> {
        let announced = &mut self.announced[leaf.start as usize / 4 % ANNOUNCED];
        if *announced == leaf.start {
            return Ok(());
        }
        *announced = leaf.start;
        let records = self.records(leaf)?;
        self.recent.prefetch(self.asset, records);
        Ok(())
    }

    /// The first four of `records`, the triangles from `start` on, in the world.
    #[inline(always)]
    fn four<L: Lanes>(
        &mut self,
        start: usize,
        records: &[TriangleRecord],
    ) -> Result<&KeptFour, QueryError> {
        let start = start as u32;
        let len = records.len().min(CHUNK) as u32;
        // Leaves that follow each other begin two to four slots apart: those of a node share no place.
        let kept = self.fours[start as usize / 2 % FOURS].get_or_insert(KeptFour::EMPTY);
        if kept.start != start || kept.len != len {
            kept.len = 0; // until it is whole
            let mut spare = LeafChunk::EMPTY;
            let (asset, recent) = (self.asset, &mut self.recent);
            let frame = &self.posed.pose.frame;
            let leaf = self.posed.leaf(asset, start, records, recent, &mut spare)?;
            kept.world.set::<L::Quad>([
                frame.world_four(&leaf.corners[0]),
                frame.world_four(&leaf.corners[1]),
                frame.world_four(&leaf.corners[2]),
            ]);
            kept.ids = leaf.ids;
            kept.start = start;
            kept.len = len;
        }
        Ok(kept)
    }
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

/// The lowest bit of each byte.
const BYTES: u64 = 0x0101_0101_0101_0101;

/// All bits of the bytes that `lanes` names.
#[inline(always)]
fn rows(lanes: u8) -> u64 {
    // A copy for each byte, of which it keeps its own bit.
    lowest((u64::from(lanes) * BYTES) & 0x8040_2010_0804_0201) * 0xff
}

/// The bits of `lanes` in each byte.
#[inline(always)]
fn columns(lanes: u8) -> u64 {
    u64::from(lanes) * BYTES
}

/// The lowest bit of each byte that is not 0.
#[inline(always)]
fn lowest(bytes: u64) -> u64 {
    let low = bytes & (0x7f * BYTES);
    (((low + 0x7f * BYTES) | bytes) >> 7) & BYTES
}

/// A bit for each byte: its lowest.
#[inline(always)]
fn gather(bytes: u64) -> u8 {
    // The sum puts the lowest bit of byte k at bit 56 + k; no two meet.
    ((bytes & BYTES).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}

/// The bits that any byte has.
#[inline(always)]
fn any_row(bytes: u64) -> u8 {
    let half = bytes | bytes >> 32;
    let quarter = half | half >> 16;
    (quarter | quarter >> 8) as u8
}

/// A sphere that everything meets.
pub(super) const EVERYWHERE: [f32; 4] = [0.0, 0.0, 0.0, f32::INFINITY];

/// One lane's centre and radius.
#[inline(always)]
fn lane_sphere(spheres: &Spheres, lane: usize) -> [f32; 4] {
    let [x, y, z] = &spheres.centre;
    [x[lane], y[lane], z[lane], spheres.radius[lane]]
}

/// [`leaves`] as work of its own.
struct LeavesWork<'l, 's, 'a> {
    a: &'l mut Side<'s, 'a>,
    b: &'l mut Side<'s, 'a>,
    pairs: &'l [FrontSlot],
    tests_left: &'l mut u64,
    visitor: &'l mut (dyn PairVisitor + 'l),
}

impl Work for LeavesWork<'_, '_, '_> {
    type Output = Result<ControlFlow<()>, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        leaves::<L>(self.a, self.b, self.pairs, self.tests_left, self.visitor)
    }
}

#[inline(always)]
fn run_leaves<'s, 'a>(
    a: &mut Side<'s, 'a>,
    b: &mut Side<'s, 'a>,
    pairs: &[FrontSlot],
    tests_left: &mut u64,
    visitor: &mut dyn PairVisitor,
) -> Result<ControlFlow<()>, QueryError> {
    let kernel = a.asset.kernel;
    kernel.run(LeavesWork {
        a,
        b,
        pairs,
        tests_left,
        visitor,
    })
}

/// Tests the triangles of pairs of leaf lanes, as long as `tests_left` lasts.
#[inline(always)]
fn leaves<L: Lanes>(
    a: &mut Side<'_, '_>,
    b: &mut Side<'_, '_>,
    pairs: &[FrontSlot],
    tests_left: &mut u64,
    visitor: &mut dyn PairVisitor,
) -> Result<ControlFlow<()>, QueryError> {
    let tolerance = visitor.tolerance();
    for FrontSlot {
        a: leaf_a,
        b: leaf_b,
    } in pairs
    {
        let tests = u64::from(leaf_a.triangles) * u64::from(leaf_b.triangles);
        let Some(fewer) = tests_left.checked_sub(tests) else {
            return Err(a.asset.endless(*tests_left).into());
        };
        *tests_left = fewer;
        let mut rest_a = a.records(*leaf_a)?;
        let mut start_a = leaf_a.start as usize;
        while !rest_a.is_empty() {
            let four_a = a.four::<L>(start_a, rest_a)?;
            let mut rest_b = b.records(*leaf_b)?;
            let mut start_b = leaf_b.start as usize;
            while !rest_b.is_empty() {
                let four_b = b.four::<L>(start_b, rest_b)?;
                if test_fours::<L>(four_a, four_b, tolerance, visitor).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
                start_b += CHUNK;
                rest_b = rest_b.get(CHUNK..).unwrap_or_default();
            }
            start_a += CHUNK;
            rest_a = rest_a.get(CHUNK..).unwrap_or_default();
        }
    }
    Ok(ControlFlow::Continue(()))
}

/// Hands on those of four times four pairs that may be an answer.
#[inline(always)]
fn test_fours<L: Lanes>(
    a: &KeptFour,
    b: &KeptFour,
    tolerance: f64,
    visitor: &mut dyn PairVisitor,
) -> ControlFlow<()> {
    let (mut rows, mut used_b) = (!(u8::MAX << a.len), !(u8::MAX << b.len));
    if tolerance == 0.0 {
        used_b &= b.world.meeting::<L::Quad>(&a.world);
        if used_b == 0 {
            return ControlFlow::Continue(());
        }
        rows &= a.world.meeting::<L::Quad>(&b.world);
    }
    while rows != 0 {
        let i = rows.trailing_zeros() as usize & (CHUNK - 1);
        rows &= rows - 1;
        let mut left = used_b
            & if tolerance > 0.0 {
                a.world.near::<L::Quad>(i, &b.world, tolerance)
            } else {
                a.world.touching::<L::Quad>(i, &b.world)
            };
        if left == 0 {
            continue;
        }
        let corners_a = a.world.triangle(i);
        while left != 0 {
            let j = left.trailing_zeros() as usize & (CHUNK - 1);
            left &= left - 1;
            let (id_a, id_b) = (TriangleId(a.ids[i]), TriangleId(b.ids[j]));
            visitor.triangles(id_a, &corners_a, id_b, &b.world.triangle(j))?;
        }
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use super::{any_row, columns, gather, lowest, rows};

    #[test]
    fn byte_masks_are_what_their_bits_say() {
        for lanes in 0..=u8::MAX {
            let bit = |k: usize| lanes & (1 << k) != 0;
            for (i, byte) in rows(lanes).to_le_bytes().into_iter().enumerate() {
                assert_eq!(byte, if bit(i) { 0xff } else { 0 });
            }
            assert_eq!(columns(lanes).to_le_bytes(), [lanes; 8]);
            assert_eq!(gather(lowest(rows(lanes))), lanes);
            let bytes = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| if bit(k) { 1_u8 << (k ^ 3) } else { 0 });
            let packed = u64::from_le_bytes(bytes);
            assert_eq!(gather(lowest(packed)), lanes);
            assert_eq!(
                any_row(packed),
                bytes.iter().fold(0, |all, byte| all | byte)
            );
        }
    }
}
