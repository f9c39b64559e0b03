//! What a walk of two trees has still to do: pairs of nodes in the caller's memory, and pairs of leaves.

use bdtree_format::LANES;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::byte_masks::lane_pair;
use super::{PairStackEntry, Subtree};
use crate::error::QueryError;
use crate::view::Asset;

/// Most pairs of leaf lanes that are collected, two visits' worth, so that their triangles are on the way from memory
/// before the first is looked at.
pub(super) const QUEUE: usize = 2 * LANES * LANES;

/// Memory for a pair of leaves.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct FrontSlot {
    pub(super) a: Subtree,
    pub(super) b: Subtree,
}

impl FrontSlot {
    /// A slot to fill memory with.
    pub(crate) const EMPTY: Self = Self {
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

/// Pairs of nodes to visit, in the caller's memory.
pub(super) struct PairStack<'w, 'a> {
    entries: &'w mut [PairStackEntry],
    len: usize,
    asset: &'w Asset<'a>,
}

impl<'w, 'a> PairStack<'w, 'a> {
    /// With the first pair to visit.
    #[inline(always)]
    pub(super) fn new(
        entries: &'w mut [PairStackEntry],
        asset: &'w Asset<'a>,
        first: PairStackEntry,
    ) -> Result<Self, QueryError> {
        let mut stack = Self {
            entries,
            len: 0,
            asset,
        };
        stack.push(first)?;
        Ok(stack)
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[inline(always)]
    pub(super) fn push(&mut self, entry: PairStackEntry) -> Result<(), QueryError> {
        let Some(slot) = self.entries.get_mut(self.len) else {
            return Err(self.asset.too_deep().into());
        };
        *slot = entry;
        self.len += 1;
        Ok(())
    }

    /// There must be one.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> PairStackEntry {
        self.len -= 1;
        self.entries[self.len]
    }
}

/// Pairs of leaves whose triangles wait for being tested.
pub(super) struct LeafQueue {
    pairs: [FrontSlot; QUEUE],
    len: usize,
}

impl LeafQueue {
    pub(super) const EMPTY: Self = Self {
        pairs: [FrontSlot::EMPTY; QUEUE],
        len: 0,
    };

    /// Whether all that a visit may find finds room.
    #[inline(always)]
    pub(super) fn has_room(&self) -> bool {
        self.len <= QUEUE - LANES * LANES
    }

    #[inline(always)]
    pub(super) fn add(&mut self, mut found: u64, a: &[Subtree; LANES], b: &[Subtree; LANES]) {
        while found != 0 {
            let (lane_a, lane_b) = lane_pair(found);
            found &= found - 1;
            let Some(slot) = self.pairs.get_mut(self.len) else {
                break; // there is room for all of a visit
            };
            *slot = FrontSlot {
                a: a[lane_a],
                b: b[lane_b],
            };
            self.len += 1;
        }
    }

    /// All of them; none are left.
    #[inline(always)]
    pub(super) fn take(&mut self) -> &[FrontSlot] {
        let len = core::mem::take(&mut self.len);
        self.pairs.get(..len).unwrap_or_default()
    }
}
