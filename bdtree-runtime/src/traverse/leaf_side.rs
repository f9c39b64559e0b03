//! One side of a search for pairs of triangles: its leaves in the world.

use bdtree_format::TriangleRecord;

use crate::cache::{CHUNK, LeafChunk, Posed};
use crate::error::FormatError;
use crate::narrow::Triangle;
use crate::view::Asset;

/// One asset of a search for pairs of triangles, with the leaf that it met last.
pub(super) struct LeafSide<'n> {
    pub(super) asset: &'n Asset<'n>,
    pub(super) posed: Posed<'n>,
    spare: LeafChunk,
    /// First triangle slot of `corners`, and how many they are.
    holds: Option<(u32, usize)>,
    pub(super) ids: [u32; CHUNK],
    pub(super) corners: [Triangle; CHUNK],
    /// Their boxes.
    pub(super) low: [[f64; 3]; CHUNK],
    pub(super) high: [[f64; 3]; CHUNK],
}

impl<'n> LeafSide<'n> {
    pub(super) fn new(posed: Posed<'n>) -> Self {
        Self {
            asset: posed.pose.asset,
            posed,
            spare: LeafChunk::EMPTY,
            holds: None,
            ids: [0; CHUNK],
            corners: [[[0.0; 3]; 3]; CHUNK],
            low: [[0.0; 3]; CHUNK],
            high: [[0.0; 3]; CHUNK],
        }
    }

    /// Deforms the first four of the triangles from slot `start` on.
    pub(super) fn fill(
        &mut self,
        start: u32,
        records: &[TriangleRecord],
    ) -> Result<(), FormatError> {
        let holds = Some((start, records.len()));
        if self.holds == holds {
            return Ok(());
        }
        self.holds = None; // until it is whole
        let frame = &self.posed.pose.placement;
        let (asset, spare) = (self.asset, &mut self.spare);
        let leaf = self.posed.leaf(asset, start, records, spare)?;
        self.ids = leaf.ids;
        for k in 0..CHUNK {
            let [a, b, c] = leaf.stored(k);
            self.corners[k] = [a, b, c].map(|x| frame.world(x));
            let [a, b, c] = self.corners[k];
            for axis in 0..3 {
                self.low[k][axis] = a[axis].min(b[axis]).min(c[axis]);
                self.high[k][axis] = a[axis].max(b[axis]).max(c[axis]);
            }
        }
        self.holds = holds;
        Ok(())
    }
}
