//! Memory for what is kept: the slots, what they hold and which one is whose.

use bdtree_format::{LANES, Row, TriangleRecord};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::bound::Spheres;
use crate::error::FormatError;
use crate::pose::Pose;
use crate::refined::Refined;
use crate::simd::Lanes;
use crate::view::Asset;

/// Triangles of a leaf that are kept together.
pub(crate) const CHUNK: usize = 4;

/// Memory for one node's spheres.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct NodeSlot {
    /// Step and node; 0 for none.
    pub(super) tag: u64,
    pub(super) spheres: Spheres,
}

impl NodeSlot {
    /// A slot that holds nothing, to fill memory with.
    pub(crate) const EMPTY: Self = Self {
        tag: 0,
        spheres: Spheres {
            center: [[0.0; LANES]; 3],
            radius: [0.0; LANES],
        },
    };
}

/// Memory for up to four deformed triangles of a leaf.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct LeafSlot {
    /// Step and first triangle slot; 0 for none.
    pub(super) tag: u64,
    pub(crate) leaf: LeafChunk,
}

impl LeafSlot {
    /// A slot that holds nothing, to fill memory with.
    pub(crate) const EMPTY: Self = Self {
        tag: 0,
        leaf: LeafChunk::EMPTY,
    };
}

/// Up to four triangles that stand together in a leaf, deformed.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct LeafChunk {
    /// Stored units: of each corner, of each coordinate, that of the four. Places beyond `len` repeat
    /// the first triangle.
    pub(crate) corners: [[[f32; CHUNK]; 3]; 3],
    pub(crate) ids: [u32; CHUNK],
    /// How many there are.
    pub(crate) len: u32,
    /// Fills up to a multiple of eight bytes.
    unused: u32,
}

impl LeafChunk {
    pub(crate) const EMPTY: Self = Self {
        corners: [[[0.0; CHUNK]; 3]; 3],
        ids: [0; CHUNK],
        len: 0,
        unused: 0,
    };

    /// The corners of triangle `k`, below 4 (stored units).
    #[inline(always)]
    pub(crate) fn stored(&self, k: usize) -> [[f32; 3]; 3] {
        let mut corners = [[0.0; 3]; 3];
        for i in 0..3 {
            for axis in 0..3 {
                corners[i][axis] = self.corners[i][axis][k & (CHUNK - 1)];
            }
        }
        corners
    }

    /// Deforms `records`, of which the first four are taken; `refined` is the same pose.
    #[inline(always)]
    pub(crate) fn deform<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        pose: &Pose<'_>,
        refined: Option<&Refined<'_>>,
        records: &[TriangleRecord],
    ) -> Result<(), FormatError> {
        let Some(first) = records.first() else {
            self.len = 0;
            return Ok(());
        };
        // Beyond the end the first one again: a NaN there would be a lane that is never rejected.
        let four = [0, 1, 2, 3].map(|k| records.get(k).unwrap_or(first));
        match refined {
            Some(refined) => refined.corners(asset, four, &mut self.corners)?,
            None => asset.deform_four::<L>(pose, four, &mut self.corners)?,
        }
        self.ids = four.map(|record| record.id);
        self.len = records.len().min(CHUNK) as u32;
        Ok(())
    }
}

/// Where the count of steps begins anew.
pub(super) const STEP_END: u32 = 1 << 31;

/// Where key `key` is kept among `len` slots.
#[inline(always)]
pub(super) fn place(key: usize, len: usize) -> usize {
    if key < len || len == 0 {
        key
    } else {
        // The low bits, as many as there are slots for.
        key & (usize::MAX >> len.leading_zeros() >> 1)
    }
}

/// Where the triangles from `start` on are kept among `len` slots: leaves that follow each other
/// begin about four triangles apart.
#[inline(always)]
pub(super) fn leaf_place(start: u32, len: usize) -> usize {
    place(start as usize / 2, len)
}

/// What a slot's tag is when it holds `key` of `step`.
#[inline(always)]
pub(super) fn tag(step: u32, key: u32) -> u64 {
    u64::from(step) << 32 | u64::from(key)
}

/// What the documentation of [`CacheSize`](super::CacheSize) says.
const _: () = assert!(size_of::<NodeSlot>() == 8 + 4 * size_of::<Row>());
const _: () = assert!(size_of::<LeafSlot>() == 176);
