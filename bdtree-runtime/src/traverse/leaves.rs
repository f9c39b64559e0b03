//! The triangles of leaves: deformed or kept, cheaply rejected four at a time, handed to the
//! visitor.

use bdtree_format::{NodeRecord, SectionKind, TriangleRecord};
use core::ops::ControlFlow;

use super::Subtree;
use super::visitor::{Four, Visitor, world};
use crate::cache::{CHUNK, LeafChunk, Posed, deform};
use crate::contact::TriangleId;
use crate::error::{Datum, FormatError, QueryError};
use crate::placement::Placement;
use crate::simd::{Lanes, Work, prefetch};
use crate::view::Asset;

/// What a traversal holds for its leaves.
pub(super) struct Leaves {
    /// Where a leaf is deformed that is not kept.
    spare: LeafChunk,
    /// Triangles not yet looked at, where leaves are not kept.
    fresh: Fresh,
    /// Those that were not rejected.
    near: Near,
    /// Triangles that the leaves to come may hold: in a sound tree no two share any.
    left: u64,
}

impl Leaves {
    /// For one walk of an asset.
    #[inline(always)]
    pub(super) fn new(asset: &Asset<'_>) -> Self {
        Self {
            left: asset.triangle_count() as u64,
            spare: LeafChunk::EMPTY,
            fresh: Fresh::EMPTY,
            near: Near::default(),
        }
    }

    /// Hands a leaf's triangles to the visitor, or, in fours, keeps some of them back.
    #[inline(always)]
    pub(super) fn take<L: Lanes, V: Visitor>(
        &mut self,
        asset: &Asset<'_>,
        posed: &mut Posed<'_>,
        leaf: Subtree,
        visitor: &mut V,
    ) -> Result<ControlFlow<()>, QueryError> {
        let pose = posed.pose;
        self.left = asset.fewer_triangles(self.left, leaf)?;
        let records = asset.leaf(leaf)?;
        if V::IN_FOURS && !posed.keeps_leaves() {
            for record in records {
                if self.fresh.push(record) && self.sieve::<L, V>(posed, visitor)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            return Ok(ControlFlow::Continue(()));
        }
        let mut start = leaf.start;
        for records in records.chunks(CHUNK) {
            let chunk = posed.leaf(asset, start, records, &mut self.spare)?;
            start = start.saturating_add(CHUNK as u32);
            let misses = visitor.misses_four::<L::Quad>(&chunk.corners);
            let mut left = !misses & !(u8::MAX << chunk.len);
            while left != 0 {
                let k = (left.trailing_zeros() & 3) as usize;
                left &= left - 1;
                let (id, corners) = (chunk.ids[k], chunk.stored(k));
                let near = &mut self.near;
                if test::<L, V>(near, &pose.placement, id, &corners, visitor).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Triangles of the leaves so far.
    #[inline(always)]
    pub(super) fn taken(&self, asset: &Asset<'_>) -> u64 {
        asset.triangle_count() as u64 - self.left
    }

    /// Hands over what was kept back.
    #[inline(always)]
    pub(super) fn finish<L: Lanes, V: Visitor>(
        &mut self,
        posed: &Posed<'_>,
        visitor: &mut V,
    ) -> Result<ControlFlow<()>, QueryError> {
        if V::IN_FOURS {
            if self.fresh.len > 0 && self.sieve::<L, V>(posed, visitor)?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
            return Ok(take_near::<L, V>(
                &mut self.near,
                &posed.pose.placement,
                visitor,
            ));
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Moves those of `fresh` that may be answers to `near`.
    #[inline(always)]
    fn sieve<L: Lanes, V: Visitor>(
        &mut self,
        posed: &Posed<'_>,
        visitor: &mut V,
    ) -> Result<ControlFlow<()>, QueryError> {
        let chunk = &mut self.spare;
        let records = &self.fresh.records[..self.fresh.len];
        deform(
            posed.pose.asset,
            posed.pose,
            posed.refined.whole(),
            records,
            chunk,
        )?;
        self.fresh.len = 0;
        let misses = visitor.misses_four::<L::Quad>(&chunk.corners);
        let mut left = !misses & !(u8::MAX << chunk.len);
        while left != 0 {
            let k = (left.trailing_zeros() & 3) as usize;
            left &= left - 1;
            self.near.push(chunk.ids[k], &chunk.stored(k));
            if self.near.is_full()
                && take_near::<L, V>(&mut self.near, &posed.pose.placement, visitor).is_break()
            {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}

/// Triangles that wait for being deformed together, those of several leaves.
struct Fresh {
    records: [TriangleRecord; CHUNK],
    len: usize,
}

impl Fresh {
    const EMPTY: Self = Self {
        records: [TriangleRecord {
            corners: [0; 3],
            id: 0,
        }; CHUNK],
        len: 0,
    };

    /// Adds a triangle; there must be room. Whether there is none left.
    #[inline(always)]
    fn push(&mut self, record: &TriangleRecord) -> bool {
        self.records[self.len & (CHUNK - 1)] = *record;
        self.len += 1;
        self.len == CHUNK
    }
}

/// Triangles that wait for the exact test: eight, so that the four numbers of one half are computed while
/// those of the other are waited for.
#[derive(Default)]
pub(super) struct Near {
    fours: [Four; 2],
    len: usize,
}

impl Near {
    #[inline(always)]
    fn push(&mut self, id: u32, corners: &[[f32; 3]; 3]) {
        self.fours[self.len >> 2 & 1].push(id, corners);
        self.len += 1;
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.len == 8
    }
}

/// Hands a triangle that was not rejected with its neighbors to the visitor, or, in fours, keeps it back.
#[inline(always)]
pub(super) fn test<L: Lanes, V: Visitor>(
    near: &mut Near,
    frame: &Placement,
    id: u32,
    corners: &[[f32; 3]; 3],
    visitor: &mut V,
) -> ControlFlow<()> {
    if V::IN_FOURS {
        near.push(id, corners);
        return match near.is_full() {
            true => take_near::<L, V>(near, frame, visitor),
            false => ControlFlow::Continue(()),
        };
    }
    if visitor.misses(corners) {
        return ControlFlow::Continue(());
    }
    L::apart(Exact {
        id: TriangleId(id),
        corners,
        frame,
        visitor,
    })
}

/// [`Visitor::triangle`] as work of its own.
struct Exact<'t, V> {
    id: TriangleId,
    corners: &'t [[f32; 3]; 3],
    frame: &'t Placement,
    visitor: &'t mut V,
}

impl<V: Visitor> Work for Exact<'_, V> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> ControlFlow<()> {
        let corners = world(self.frame, self.corners);
        self.visitor.triangle(self.id, &corners)
    }
}

/// [`Visitor::fours`] as work of its own.
struct TakeNear<'n, V> {
    near: &'n mut Near,
    frame: &'n Placement,
    visitor: &'n mut V,
}

impl<V: Visitor> Work for TakeNear<'_, V> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> ControlFlow<()> {
        self.visitor
            .fours::<L::Quad>(self.frame, &self.near.fours)?;
        self.near.fours[0].len = 0;
        self.near.fours[1].len = 0;
        self.near.len = 0;
        ControlFlow::Continue(())
    }
}

/// The exact test of what was not rejected.
#[inline(always)]
pub(super) fn take_near<L: Lanes, V: Visitor>(
    near: &mut Near,
    frame: &Placement,
    visitor: &mut V,
) -> ControlFlow<()> {
    L::apart(TakeNear {
        near,
        frame,
        visitor,
    })
}

impl<'a> Asset<'a> {
    /// The triangles of a leaf.
    #[inline(always)]
    pub(crate) fn leaf(&self, leaf: Subtree) -> Result<&'a [TriangleRecord], QueryError> {
        let start = leaf.start as usize;
        let end = start.saturating_add(leaf.triangles as usize);
        match self.triangles.get(start..end) {
            Some(records) => Ok(records),
            None => {
                let len = self.triangles.len();
                Err(self
                    .ends_outside(SectionKind::TRIANGLES, end, len, 16)
                    .into())
            }
        }
    }

    /// What is left of `left` triangles behind a leaf.
    ///
    /// # Errors
    /// More than there are: leaves share triangles.
    #[inline(always)]
    pub(super) fn fewer_triangles(&self, left: u64, leaf: Subtree) -> Result<u64, FormatError> {
        self.fewer(left, u64::from(leaf.triangles))
    }

    /// What is left of `left` triangles behind so many.
    ///
    /// # Errors
    /// As above.
    #[inline(always)]
    pub(crate) fn fewer(&self, left: u64, triangles: u64) -> Result<u64, FormatError> {
        match left.checked_sub(triangles) {
            Some(left) => Ok(left),
            None => Err(self.shared_triangles()),
        }
    }

    /// The error for a traversal that meets more triangles than there are.
    #[cold]
    fn shared_triangles(&self) -> FormatError {
        FormatError {
            section: SectionKind::NODES,
            byte: self.section_offset(SectionKind::NODES),
            rule: "SPEC 6.8: every triangle is in one leaf lane",
            expected: Datum::at_most(self.triangle_count()),
            found: Datum::Text("more triangles: leaves share them"),
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
            let rest = self.triangles.get(node.first_slot as usize..);
            // The last few of a file go without, so that nothing is asked in between.
            if let Some(records) = rest.and_then(|rest| rest.first_chunk::<RECORDS>()) {
                let (lines, _) = records.as_chunks::<PER_LINE>();
                for line in lines {
                    prefetch(line);
                }
            }
        }
    }
}
