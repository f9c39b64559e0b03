//! One side of a walk of two trees: its nodes, and its leaves' triangles in the world.

use bdtree_format::{LANES, NodeRecord, TriangleRecord};

use super::{Subtree, lane_subtree};
use crate::bound::WideSpheres;
use crate::cache::{CHUNK, LeafChunk, Posed};
use crate::error::QueryError;
use crate::narrow::four_by_four::WorldFour;
use crate::simd::Lanes;
use crate::view::Asset;

/// Groups of four triangles in the world that a traversal keeps of each asset.
const FOURS: usize = 32;

/// Leaves that a traversal remembers having asked for.
const ANNOUNCED: usize = 64;

/// One side of the traversal.
pub(super) struct Side<'s> {
    pub(super) asset: &'s Asset<'s>,
    pub(super) posed: Posed<'s>,
    /// Filled when they are first used: most pairs of bodies that are near each other do not get to
    /// their leaves. As one, since of an array of absent ones each would be written (23 KB, a microsecond for each walk).
    fours: Option<[KeptFour; FOURS]>,
    /// First triangle slots of leaves whose vertices were asked for last.
    announced: [u32; ANNOUNCED],
    pub(super) updated: u64,
}

/// Up to four triangles of a leaf in the world.
#[derive(Clone, Copy)]
pub(super) struct KeptFour {
    /// First triangle slot.
    start: u32,
    /// How many there are; 0: nothing is kept.
    pub(super) len: u32,
    pub(super) ids: [u32; CHUNK],
    pub(super) world: WorldFour,
}

impl KeptFour {
    const EMPTY: Self = Self {
        start: 0,
        len: 0,
        ids: [0; CHUNK],
        world: WorldFour::EMPTY,
    };
}

impl<'s> Side<'s> {
    pub(super) fn new(posed: Posed<'s>) -> Self {
        Self {
            asset: posed.pose.asset,
            posed,
            fours: None,
            announced: [u32::MAX; ANNOUNCED],
            updated: 0,
        }
    }

    /// A node; its spheres, in the asset's own frame, are put into `out`.
    #[inline(always)]
    pub(super) fn node<L: Lanes>(
        &mut self,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<&'s NodeRecord, QueryError> {
        let node = self.asset.node(index)?;
        let evaluated = self.posed.spheres(self.asset, index, out)?;
        self.updated += u64::from(evaluated);
        Ok(node)
    }

    /// Asks for what the children in `lanes` and the triangles of a node need.
    #[inline(always)]
    pub(super) fn prefetch_children(&self, node: &NodeRecord, mut lanes: u8) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            let child = lane_subtree(node, lane).start;
            self.posed.prefetch_node(self.asset, child);
        }
    }

    /// The leaf lanes in `lanes`, whose vertices are asked for.
    #[inline(always)]
    pub(super) fn announce(
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
    pub(super) fn announce_leaf(&mut self, leaf: Subtree) -> Result<(), QueryError> {
        let announced = &mut self.announced[leaf.start as usize / 4 % ANNOUNCED];
        if *announced == leaf.start {
            return Ok(());
        }
        *announced = leaf.start;
        self.asset.prefetch_vertices(self.asset.leaf(leaf)?);
        Ok(())
    }

    /// The first four of `records`, the triangles from `start` on, in the world.
    #[inline(always)]
    pub(super) fn four<L: Lanes>(
        &mut self,
        start: usize,
        records: &[TriangleRecord],
    ) -> Result<&KeptFour, QueryError> {
        let start = start as u32;
        let len = records.len().min(CHUNK) as u32;
        // Leaves that follow each other begin two to four slots apart: those of a node share no place.
        let fours = self.fours.get_or_insert([KeptFour::EMPTY; FOURS]);
        let kept = &mut fours[start as usize / 2 % FOURS];
        if kept.start != start || kept.len != len {
            kept.len = 0; // until it is whole
            let mut spare = LeafChunk::EMPTY;
            let asset = self.asset;
            let frame = &self.posed.pose.placement;
            let leaf = self.posed.leaf(asset, start, records, &mut spare)?;
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
