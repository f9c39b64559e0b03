//! The memory that queries work in: one object, whatever is asked.

#[cfg(feature = "alloc")]
use alloc::vec::Vec;
use core::mem::size_of;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::contact::PairContact;
use crate::error::QueryError;
use crate::query::ManifoldSlot;
use crate::traverse::{PairStackEntry, SearchEntry, StackEntry, Walk};
use crate::view::Asset;

/// No slot needs more than the alignment of a u64.
const ALIGNMENT: usize = 8;

/// What queries keep in memory: plain numbers of any value.
pub(crate) trait Slot: FromBytes + IntoBytes + KnownLayout + Immutable {}

impl<T: FromBytes + IntoBytes + KnownLayout + Immutable> Slot for T {}

/// Slots of three kinds.
type Three<'s, A, B, C> = (&'s mut [A], &'s mut [B], &'s mut [C]);

/// Memory of the caller's, or memory that grows by itself.
#[derive(Debug)]
pub(crate) enum Memory<'m> {
    /// A fixed number of bytes.
    Bytes(&'m mut [u8]),
    /// As much as was ever needed.
    #[cfg(feature = "alloc")]
    Owned(Vec<u64>),
}

impl<'m> Memory<'m> {
    pub(crate) fn of_bytes(bytes: &'m mut [u8]) -> Self {
        let odd = bytes.as_ptr().align_offset(ALIGNMENT).min(bytes.len());
        Self::Bytes(&mut bytes[odd..])
    }

    /// Its bytes, at a multiple of [`ALIGNMENT`].
    #[inline]
    fn bytes(&mut self) -> &mut [u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            #[cfg(feature = "alloc")]
            Self::Owned(words) => words.as_mut_bytes(),
        }
    }

    /// Bytes from which `needed` may be taken, if they can be had; what they hold does not matter.
    #[inline]
    #[cfg_attr(not(feature = "alloc"), allow(unused_variables))] // only what grows asks
    fn at_least(&mut self, needed: usize) -> &mut [u8] {
        #[cfg(feature = "alloc")]
        if let Self::Owned(words) = self
            && size_of::<u64>() * words.len() < needed
        {
            // Made anew, not grown: nothing has to be copied, and zeroed pages are not touched.
            *words = alloc::vec![0; needed.div_ceil(size_of::<u64>())];
        }
        self.bytes()
    }

    /// `count` slots from its beginning.
    #[inline]
    pub(crate) fn slots<T: Slot>(&mut self, count: usize) -> Result<&mut [T], QueryError> {
        let needed = size_of::<T>().saturating_mul(count);
        let bytes = self.at_least(needed);
        let found = bytes.len();
        match <[T]>::mut_from_prefix_with_elems(bytes, count) {
            Ok((slots, _)) => Ok(slots),
            Err(_) => Err(QueryError::Memory { needed, found }),
        }
    }

    /// The slots that it has now.
    pub(crate) fn all_slots<T: Slot>(&mut self) -> &mut [T] {
        let bytes = self.bytes();
        let count = bytes.len() / size_of::<T>();
        match <[T]>::mut_from_prefix_with_elems(bytes, count) {
            Ok((slots, _)) => slots,
            Err(_) => &mut [],
        }
    }

    /// `count` slots, or as many as there are where it cannot grow.
    pub(crate) fn up_to<T: Slot>(&mut self, count: usize) -> &mut [T] {
        let found = self.at_least(size_of::<T>().saturating_mul(count)).len();
        let count = count.min(found / size_of::<T>());
        // The error cannot be: so many fit.
        self.slots(count).unwrap_or_default()
    }

    /// Slots of two kinds behind each other; the size of the first is a multiple of the second's alignment.
    #[inline]
    pub(crate) fn two_slots<A: Slot, B: Slot>(
        &mut self,
        [a, b]: [usize; 2],
    ) -> Result<(&mut [A], &mut [B]), QueryError> {
        let (a, b, _) = self.three_slots::<A, B, u8>([a, b, 0])?;
        Ok((a, b))
    }

    /// Slots of three kinds, likewise.
    #[inline]
    pub(crate) fn three_slots<A: Slot, B: Slot, C: Slot>(
        &mut self,
        [a, b, c]: [usize; 3],
    ) -> Result<Three<'_, A, B, C>, QueryError> {
        let needed = size_of::<A>()
            .saturating_mul(a)
            .saturating_add(size_of::<B>().saturating_mul(b))
            .saturating_add(size_of::<C>().saturating_mul(c));
        let bytes = self.at_least(needed);
        let found = bytes.len();
        if let Ok((a, rest)) = <[A]>::mut_from_prefix_with_elems(bytes, a)
            && let Ok((b, rest)) = <[B]>::mut_from_prefix_with_elems(rest, b)
            && let Ok((c, _)) = <[C]>::mut_from_prefix_with_elems(rest, c)
        {
            return Ok((a, b, c));
        }
        Err(QueryError::Memory { needed, found })
    }

    /// What [`Memory::three_slots`] has given, to read.
    pub(crate) fn three_to_read<A: Slot, B: Slot, C: Slot>(
        &self,
        [a, b, c]: [usize; 3],
    ) -> Option<(&[A], &[B], &[C])> {
        let bytes = match self {
            Self::Bytes(bytes) => &**bytes,
            #[cfg(feature = "alloc")]
            Self::Owned(words) => words.as_bytes(),
        };
        let (a, rest) = <[A]>::ref_from_prefix_with_elems(bytes, a).ok()?;
        let (b, rest) = <[B]>::ref_from_prefix_with_elems(rest, b).ok()?;
        let (c, _) = <[C]>::ref_from_prefix_with_elems(rest, c).ok()?;
        Some((a, b, c))
    }

    /// Its size now.
    pub(crate) fn len(&mut self) -> usize {
        self.bytes().len()
    }

    /// Whether it grows by itself.
    pub(crate) fn grows(&self) -> bool {
        match self {
            Self::Bytes(_) => false,
            #[cfg(feature = "alloc")]
            Self::Owned(_) => true,
        }
    }
}

/// What the last query of a workspace did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stats {
    /// Nodes whose spheres were tested. For distances of two meshes: pairs of a node and a part of the other.
    pub nodes_visited: u64,
    /// Of them, those whose spheres were evaluated: all but what a [`StepCache`](crate::StepCache) kept.
    pub nodes_updated: u64,
    /// Pairs of spheres that the broad phase compared.
    pub sphere_tests: u64,
}

impl Stats {
    #[inline]
    pub(crate) fn of(walk: &Walk) -> Self {
        Self {
            nodes_visited: walk.nodes_visited,
            nodes_updated: walk.nodes_updated,
            sphere_tests: 0,
        }
    }
}

/// The memory that queries work in. One serves any number of assets, poses and kinds of query, one query at
/// a time: keep one per thread.
///
/// With the feature `alloc` it starts empty and grows to what the largest query so far has needed. Without,
/// it is carved from bytes of the caller's.
#[derive(Debug)]
pub struct Workspace<'m> {
    pub(crate) memory: Memory<'m>,
    pub(crate) stats: Stats,
}

#[cfg(feature = "alloc")]
impl Workspace<'static> {
    /// A workspace that grows by itself.
    pub const fn new() -> Self {
        Self {
            memory: Memory::Owned(Vec::new()),
            stats: Stats {
                nodes_visited: 0,
                nodes_updated: 0,
                sphere_tests: 0,
            },
        }
    }
}

#[cfg(feature = "alloc")]
impl Default for Workspace<'static> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'m> Workspace<'m> {
    /// Bytes that a budgeted query takes for a node that it has still to visit.
    pub const QUEUE_ENTRY_BYTES: usize = size_of::<SearchEntry>();

    /// A workspace in these bytes, at any address; what they hold does not matter.
    /// [`Workspace::bytes_for`] tells how many.
    pub fn in_bytes(memory: &'m mut [u8]) -> Self {
        Self {
            memory: Memory::of_bytes(memory),
            stats: Stats::default(),
        }
    }

    /// Bytes that suffice for every query on any of these assets and between any two of them, except contact
    /// manifolds: they need [`Workspace::bytes_for_manifolds`], which includes this number. Queries with a budget use
    /// whatever there is.
    pub fn bytes_for(assets: &[&Asset<'_>]) -> usize {
        let mut bytes = 0;
        for (i, asset) in assets.iter().enumerate() {
            bytes = bytes.max(size_of::<StackEntry>() * asset.stack_len());
            // An asset may meet another instance of itself.
            for other in &assets[i..] {
                bytes = bytes
                    .max(size_of::<PairStackEntry>() * asset.pair_stack_len(other))
                    .max(size_of::<SearchEntry>() * asset.distance_stack_len(other));
            }
        }
        bytes + ALIGNMENT
    }

    /// Bytes that suffice for the contact manifolds between any two of these assets where at most `pairs`
    /// pairs of triangles touch.
    pub fn bytes_for_manifolds(assets: &[&Asset<'_>], pairs: usize) -> usize {
        let of_pairs =
            size_of::<PairContact>() + size_of::<ManifoldSlot>() * ManifoldSlot::count(1);
        Self::bytes_for(assets).saturating_add(of_pairs.saturating_mul(pairs))
    }

    /// What the last query did.
    pub fn stats(&self) -> Stats {
        self.stats
    }
}
