//! Which pairs belong together.
//!
//! Two pairs are neighbours if they have a triangle of one asset in common and their triangles of the
//! other have a corner in common: so a contour is followed from triangle to triangle, and the feet of a
//! chair on one large triangle stay apart.

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::contact::{PairContact, VertexId};
use crate::error::QueryError;
use crate::view::Asset;

/// Memory for grouping pairs.
#[derive(
    Debug,
    Clone,
    Copy,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    FromBytes,
    IntoBytes,
    KnownLayout,
    Immutable,
)]
#[repr(C)]
pub(crate) struct ManifoldSlot {
    key: u64,
    pair: u32,
    /// Fills up to a multiple of eight bytes.
    unused: u32,
}

impl ManifoldSlot {
    /// Slots that so many pairs need.
    pub(crate) const fn count(pairs: usize) -> usize {
        pairs.saturating_mul(4)
    }

    /// Which region the pair belongs to.
    pub(super) fn region(&self) -> u64 {
        self.key
    }

    /// The pair's index.
    pub(super) fn pair(&self) -> usize {
        self.pair as usize
    }
}

/// The pairs by their ids, each of them once.
///
/// # Errors
/// Too little memory.
pub(super) fn sorted_once<'p>(
    pairs: &'p mut [PairContact],
    memory: &mut [ManifoldSlot],
) -> Result<&'p mut [PairContact], QueryError> {
    let found = memory.len();
    let Some(order) = memory.get_mut(..pairs.len()) else {
        let needed = ManifoldSlot::count(pairs.len());
        return Err(QueryError::Memory { needed, found });
    };
    // Slots are a thirteenth of a pair: pairs are moved once, when their order is known.
    for (i, (slot, pair)) in order.iter_mut().zip(&*pairs).enumerate() {
        slot.key = u64::from(pair.triangle1.0) << 32 | u64::from(pair.triangle2.0);
        slot.pair = i as u32;
    }
    order.sort_unstable();
    for i in 0..pairs.len() {
        // What was before i went to where that came from.
        let mut from = order[i].pair as usize;
        while from < i {
            from = order[from].pair as usize;
        }
        // Where what was here is now: chains stay short.
        order[i].pair = from as u32;
        pairs.swap(i, from);
    }
    let mut kept = 0;
    for i in 0..pairs.len() {
        if i == 0 || order[i].key != order[i - 1].key {
            pairs.swap(kept, i);
            kept += 1;
        }
    }
    Ok(&mut pairs[..kept])
}

/// A slot for each pair, by region and index; regions are named by their first pair.
pub(super) fn regions<'m>(
    asset1: &Asset<'_>,
    asset2: &Asset<'_>,
    pairs: &[PairContact],
    memory: &'m mut [ManifoldSlot],
) -> Result<&'m [ManifoldSlot], QueryError> {
    let (needed, found) = (ManifoldSlot::count(pairs.len()), memory.len());
    let Some((parents, keys)) = memory
        .get_mut(..needed)
        .and_then(|memory| memory.split_at_mut_checked(pairs.len()))
    else {
        return Err(QueryError::Memory { needed, found });
    };
    for (i, slot) in parents.iter_mut().enumerate() {
        *slot = ManifoldSlot {
            pair: i as u32,
            ..ManifoldSlot::default()
        };
    }
    keys.fill(ManifoldSlot::default());
    for first in [true, false] {
        let (slots, _) = keys.as_chunks_mut::<3>();
        for (i, (pair, slots)) in pairs.iter().zip(slots).enumerate() {
            let (shared, other) = if first {
                (pair.triangle1, asset2.triangle(pair.triangle2)?)
            } else {
                (pair.triangle2, asset1.triangle(pair.triangle1)?)
            };
            for (slot, VertexId(vertex)) in slots.iter_mut().zip(other) {
                slot.key = u64::from(shared.0) << 32 | u64::from(vertex);
                slot.pair = i as u32;
            }
        }
        keys.sort_unstable();
        for window in keys.windows(2) {
            if let [x, y] = window
                && x.key == y.key
            {
                join(parents, x.pair, y.pair);
            }
        }
    }
    for i in 0..parents.len() {
        parents[i].key = u64::from(root(parents, i as u32));
    }
    for (i, slot) in parents.iter_mut().enumerate() {
        slot.pair = i as u32;
    }
    parents.sort_unstable();
    Ok(parents)
}

/// The first pair of the set that `i` belongs to; paths are halved on the way.
fn root(parents: &mut [ManifoldSlot], mut i: u32) -> u32 {
    while parents[i as usize].pair != i {
        let next = parents[parents[i as usize].pair as usize].pair;
        parents[i as usize].pair = next;
        i = next;
    }
    i
}

fn join(parents: &mut [ManifoldSlot], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize].pair = a.min(b);
}
