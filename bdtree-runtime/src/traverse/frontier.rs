//! What a search has still to visit, each with a lower bound.

use bdtree_format::LANES;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::Subtree;
use crate::error::QueryError;

/// One entry of the memory of a nearest-pair search or of a budgeted query: what is to be visited.
#[derive(Debug, Clone, Copy, Default, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct SearchEntry {
    /// Lower bound of what is looked for, below the entry; never NaN.
    pub(super) key: f32,
    pub(super) a: Subtree,
    /// Means nothing where one tree is searched, as what follows.
    pub(super) b: Subtree,
    /// Center and radius in the frame of the first.
    pub(super) sphere_a: [f32; 4],
    pub(super) sphere_b: [f32; 4],
}

impl SearchEntry {
    /// A node of the one tree that is searched.
    pub(super) fn node(node: u32, key: f32) -> Self {
        Self {
            key,
            a: Subtree {
                start: node,
                triangles: 0,
            },
            ..Self::default()
        }
    }

    /// The same with a part's key: what holds for the whole holds for its parts, and NaN says nothing.
    #[inline(always)]
    pub(super) fn below(&self, key: f32) -> Self {
        Self {
            key: if key > self.key { key } else { self.key },
            ..*self
        }
    }
}

/// Sorts an entry in by its key, behind equal ones.
#[inline(always)]
pub(super) fn insert(found: &mut [SearchEntry; LANES], count: &mut usize, entry: SearchEntry) {
    let mut at = *count & (LANES - 1);
    while at > 0 && found[at - 1].key > entry.key {
        found[at] = found[at - 1];
        at -= 1;
    }
    found[at] = entry;
    *count += 1;
}

/// What is still to be visited, in the caller's memory.
pub(crate) trait Frontier {
    /// The next entry whose key is not above `bound`.
    fn next(&mut self, bound: f32) -> Option<SearchEntry>;

    /// Takes what a visit found, nearest first. `false`: more than a sound pair of trees can need.
    fn put(&mut self, found: &[SearchEntry]) -> bool;
}

/// Depth first, nearest first.
pub(crate) struct Stack<'s> {
    entries: &'s mut [SearchEntry],
    len: usize,
}

impl<'s> Stack<'s> {
    /// An empty one of `needed` entries.
    ///
    /// # Errors
    /// Fewer entries than that.
    pub(crate) fn new(entries: &'s mut [SearchEntry], needed: usize) -> Result<Self, QueryError> {
        let found = entries.len();
        match entries.get_mut(..needed) {
            Some(entries) => Ok(Self { entries, len: 0 }),
            None => Err(QueryError::Memory { needed, found }),
        }
    }
}

impl Frontier for Stack<'_> {
    #[inline(always)]
    fn next(&mut self, bound: f32) -> Option<SearchEntry> {
        while self.len > 0 {
            self.len -= 1;
            let entry = self.entries[self.len];
            if entry.key <= bound {
                return Some(entry);
            }
        }
        None
    }

    #[inline(always)]
    fn put(&mut self, found: &[SearchEntry]) -> bool {
        for entry in found.iter().rev() {
            let Some(slot) = self.entries.get_mut(self.len) else {
                return false;
            };
            *slot = *entry;
            self.len += 1;
        }
        true
    }
}
