//! The triangles of leaves: deformed or kept, cheaply rejected four at a time, handed to the
//! visitor.

use bdtree_format::{NodeRecord, SectionKind, TriangleRecord};
use core::ops::ControlFlow;

use super::Subtree;
use super::one::Visitor;
use crate::cache::{CHUNK, LeafChunk, Posed};
use crate::contact::TriangleId;
use crate::deform::RecentVertices;
use crate::error::QueryError;
use crate::frame::Frame;
use crate::narrow::Triangle;
use crate::simd::{Lanes, prefetch};
use crate::view::Asset;

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

    /// The world corners of triangle `k`.
    #[inline(always)]
    pub(crate) fn world(&self, frame: &Frame, k: usize) -> Triangle {
        world(frame, &stored(&self.corners, k))
    }
}

/// The corners of the k-th of four triangles.
#[inline(always)]
fn stored(four: &[[[f32; 4]; 3]; 3], k: usize) -> [[f32; 3]; 3] {
    let mut corners = [[0.0; 3]; 3];
    for i in 0..3 {
        for axis in 0..3 {
            corners[i][axis] = four[i][axis][k & 3];
        }
    }
    corners
}

#[inline(always)]
fn world(frame: &Frame, [a, b, c]: &[[f32; 3]; 3]) -> Triangle {
    [frame.world(*a), frame.world(*b), frame.world(*c)]
}

/// What a traversal holds for its leaves.
pub(super) struct Leaves {
    recent: RecentVertices,
    /// Where a leaf is deformed that is not kept.
    spare: LeafChunk,
    /// Triangles not yet rejected, where leaves are not kept.
    fresh: Four,
    /// Those that were not rejected.
    near: Four,
}

impl Leaves {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            recent: RecentVertices::new(),
            spare: LeafChunk::EMPTY,
            fresh: Four::default(),
            near: Four::default(),
        }
    }

    /// Asks for the vertices of a leaf's triangles, unless these are kept.
    #[inline(always)]
    pub(super) fn ask<const LISTED: bool>(
        &mut self,
        asset: &Asset<'_>,
        posed: &Posed<'_>,
        leaf: Subtree,
    ) -> Result<(), QueryError> {
        if posed.keeps_leaf(leaf.start) {
            return Ok(());
        }
        for record in asset.leaf(leaf)? {
            self.recent.prefetch::<LISTED>(asset, record);
        }
        Ok(())
    }

    /// Hands a leaf's triangles to the visitor, or, in fours, keeps some of them back.
    #[inline(always)]
    pub(super) fn take<L: Lanes, V: Visitor, const LISTED: bool>(
        &mut self,
        asset: &Asset<'_>,
        posed: &mut Posed<'_>,
        leaf: Subtree,
        visitor: &mut V,
    ) -> Result<ControlFlow<()>, QueryError> {
        let pose = posed.pose;
        let records = asset.leaf(leaf)?;
        if V::IN_FOURS && !posed.keeps_leaves() {
            for record in records {
                let corners = asset.stored_triangle::<LISTED>(pose, record, &mut self.recent)?;
                self.fresh.push(record.id, &corners);
                if self.fresh.len == 4 && self.sieve::<L, V>(&pose.frame, visitor).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            return Ok(ControlFlow::Continue(()));
        }
        let mut start = leaf.start;
        for records in records.chunks(CHUNK) {
            let chunk =
                posed.leaf::<LISTED>(asset, start, records, &mut self.recent, &mut self.spare)?;
            start = start.saturating_add(CHUNK as u32);
            let misses = visitor.misses_four::<L::Quad>(&chunk.corners);
            let mut left = !misses & !(u8::MAX << chunk.len);
            while left != 0 {
                let k = (left.trailing_zeros() & 3) as usize;
                left &= left - 1;
                let corners = chunk.stored(k);
                let flow = if V::IN_FOURS {
                    keep_back::<L, V>(&mut self.near, &pose.frame, chunk.ids[k], &corners, visitor)
                } else if visitor.misses(&corners) {
                    ControlFlow::Continue(())
                } else {
                    visitor.triangle(TriangleId(chunk.ids[k]), &world(&pose.frame, &corners))
                };
                if flow.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Hands over what was kept back.
    #[inline(always)]
    pub(super) fn finish<L: Lanes, V: Visitor>(
        &mut self,
        frame: &Frame,
        visitor: &mut V,
    ) -> ControlFlow<()> {
        if V::IN_FOURS {
            self.sieve::<L, V>(frame, visitor)?;
            visitor.four::<L::Quad>(frame, &self.near)?;
        }
        ControlFlow::Continue(())
    }

    /// Moves those of `fresh` that may be answers to `near`.
    #[inline(always)]
    fn sieve<L: Lanes, V: Visitor>(&mut self, frame: &Frame, visitor: &mut V) -> ControlFlow<()> {
        let misses = visitor.misses_four::<L::Quad>(&self.fresh.corners);
        let mut left = !misses & !(u8::MAX << self.fresh.len);
        self.fresh.len = 0;
        while left != 0 {
            let k = (left.trailing_zeros() & 3) as usize;
            left &= left - 1;
            let corners = stored(&self.fresh.corners, k);
            keep_back::<L, V>(&mut self.near, frame, self.fresh.ids[k], &corners, visitor)?;
        }
        ControlFlow::Continue(())
    }
}

/// Adds a triangle to `near`, which the visitor takes whenever it is full.
#[inline(always)]
fn keep_back<L: Lanes, V: Visitor>(
    near: &mut Four,
    frame: &Frame,
    id: u32,
    corners: &[[f32; 3]; 3],
    visitor: &mut V,
) -> ControlFlow<()> {
    near.push(id, corners);
    if near.len == 4 {
        visitor.four::<L::Quad>(frame, near)?;
        near.len = 0;
    }
    ControlFlow::Continue(())
}

impl<'a> Asset<'a> {
    /// The triangles of a leaf.
    #[inline(always)]
    pub(super) fn leaf(&self, leaf: Subtree) -> Result<&'a [TriangleRecord], QueryError> {
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

    /// Asks for the triangles of a node's leaf lanes, before its spheres are known.
    #[inline(always)]
    pub(super) fn prefetch_triangles(&self, node: &NodeRecord) {
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
