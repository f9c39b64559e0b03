//! The stack of a walk whose nodes put all lanes there at once.

use bdtree_format::{LANES, Row};
use zerocopy::{FromBytes, IntoBytes};

use super::{StackEntry, Subtree};

/// Entries, each kind of number by itself.
pub(super) struct WideStack<'s> {
    /// Lower bounds of what the query minimises.
    keys: &'s mut [f32],
    /// As [`Subtree`]'s.
    starts: &'s mut [u32],
    triangles: &'s mut [u32],
    len: usize,
}

impl<'s> WideStack<'s> {
    /// One that holds the root, in the memory of so many entries.
    #[inline(always)]
    pub(super) fn new(memory: &'s mut [StackEntry]) -> Self {
        let room = memory.len();
        let numbers = <[u32]>::mut_from_bytes(memory.as_mut_bytes()).unwrap_or_default();
        let (keys, rest) = numbers.split_at_mut_checked(room).unwrap_or_default();
        let (starts, triangles) = rest.split_at_mut_checked(room).unwrap_or_default();
        let mut stack = Self {
            keys: <[f32]>::mut_from_bytes(keys.as_mut_bytes()).unwrap_or_default(),
            starts,
            triangles,
            len: 0,
        };
        stack.restart();
        stack
    }

    /// Nothing but the root.
    #[inline(always)]
    pub(super) fn restart(&mut self) {
        self.len = self.keys.len().min(1);
        if let ([key, ..], [start, ..], [triangles, ..]) =
            (&mut *self.keys, &mut *self.starts, &mut *self.triangles)
        {
            (*key, *start, *triangles) = (f32::NEG_INFINITY, 0, 0);
        }
    }

    /// Takes entries from the top until one has a key that is wanted.
    #[inline(always)]
    pub(super) fn pop(&mut self, wanted: impl Fn(f32) -> bool) -> Option<Subtree> {
        loop {
            let key = *self.keys.get(self.len.wrapping_sub(1))?;
            self.len -= 1;
            if wanted(key) {
                return self.at(self.len);
            }
        }
    }

    /// The entry on top.
    #[inline(always)]
    pub(super) fn top(&self) -> Option<Subtree> {
        self.at(self.len.wrapping_sub(1))
    }

    #[inline(always)]
    fn at(&self, index: usize) -> Option<Subtree> {
        let (start, triangles) = (*self.starts.get(index)?, *self.triangles.get(index)?);
        Some(Subtree { start, triangles })
    }

    /// Puts the first `count` of eight entries on top. Whether there was room for all eight.
    #[inline(always)]
    #[must_use]
    pub(super) fn push(
        &mut self,
        keys: &Row,
        starts: &[u32; LANES],
        triangles: &[u32; LANES],
        count: usize,
    ) -> bool {
        let end = self.len + LANES;
        let (Some(to_keys), Some(to_starts), Some(to_triangles)) = (
            self.keys.get_mut(self.len..end),
            self.starts.get_mut(self.len..end),
            self.triangles.get_mut(self.len..end),
        ) else {
            return false;
        };
        to_keys.copy_from_slice(keys);
        to_starts.copy_from_slice(starts);
        to_triangles.copy_from_slice(triangles);
        self.len += count;
        true
    }
}
