//! The cache over slots: steps, epochs, and the pose that they serve.

use super::slots::{LeafSlot, NodeSlot, STEP_END, place, tag};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::view::Asset;
use crate::workspace::Memory;

/// How much a [`StepCache`] keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CacheSize {
    /// Nodes whose spheres are kept, 136 bytes each; [`Asset::node_count`] keep all.
    pub nodes: usize,
    /// Groups of up to four triangles of a leaf that are kept deformed, 176 bytes each; half of
    /// [`Asset::triangle_count`] keep all.
    pub leaves: usize,
}

impl CacheSize {
    /// Nothing is kept.
    pub const NONE: Self = Self {
        nodes: 0,
        leaves: 0,
    };

    /// Everything that a step can ask for.
    pub fn all(asset: &Asset<'_>) -> Self {
        Self {
            nodes: asset.node_count(),
            leaves: asset.triangle_count().div_ceil(2),
        }
    }

    /// All nodes that queries visit which end at a level ([`Query::max_level`](crate::Query::max_level)), whatever
    /// the mesh's size.
    pub fn to_level(asset: &Asset<'_>, level: usize) -> Self {
        Self {
            nodes: asset.node_count_to(level),
            leaves: 0,
        }
    }

    /// Bytes that a cache of this size needs.
    pub const fn bytes(self) -> usize {
        size_of::<NodeSlot>()
            .saturating_mul(self.nodes)
            .saturating_add(size_of::<LeafSlot>().saturating_mul(self.leaves))
            .saturating_add(align_of::<NodeSlot>())
    }
}

/// What one instance keeps during a step: spheres of nodes and deformed leaves, each in the slot of its number, so
/// that a cache of any size serves; what finds its slot taken by another is computed again.
///
/// Queries take it by [`Query::cached`](crate::Query::cached), after [`StepCache::start`] with the pose that is asked.
#[derive(Debug)]
pub struct StepCache<'m> {
    memory: Memory<'m>,
    size: CacheSize,
    /// The step that leaves were deformed in, above 0 and below [`STEP_END`].
    step: u32,
    /// The step that nodes were evaluated in, and what identifies its pose.
    epoch: u32,
    reference: Option<u64>,
}

#[cfg(feature = "alloc")]
impl StepCache<'static> {
    /// A cache of this size.
    pub fn new(size: CacheSize) -> Self {
        // Zeros are slots that hold nothing.
        let words = alloc::vec![0; size.bytes().div_ceil(size_of::<u64>())];
        Self::over(Memory::Owned(words), size)
    }
}

impl<'m> StepCache<'m> {
    /// A cache in these bytes, at any address.
    ///
    /// # Errors
    /// [`QueryError::Memory`] where they are fewer than [`CacheSize::bytes`].
    pub fn in_bytes(memory: &'m mut [u8], size: CacheSize) -> Result<Self, QueryError> {
        let mut cache = Self::over(Memory::of_bytes(memory), size);
        let (nodes, leaves) = cache
            .memory
            .two_slots::<NodeSlot, LeafSlot>([size.nodes, size.leaves])?;
        clear(nodes, leaves);
        Ok(cache)
    }

    fn over(memory: Memory<'m>, size: CacheSize) -> Self {
        Self {
            memory,
            size,
            step: 0,
            epoch: 0,
            reference: None,
        }
    }

    /// Forgets everything, in constant time, and serves this pose from now on, wherever it is placed.
    pub fn start(&mut self, pose: &Pose<'_>) {
        self.next_step();
        self.epoch = self.step;
        self.reference = Some(pose.fingerprint());
    }

    /// Whether the spheres of node `index` are kept. In a cache of [`CacheSize::all`] none makes room for
    /// another: then it says whether a query has visited the node since [`StepCache::start`].
    pub fn keeps(&mut self, index: u32) -> bool {
        let epoch = self.epoch;
        let kept = self.slots();
        let slot = kept.nodes.get(place(index as usize, kept.nodes.len()));
        slot.is_some_and(|slot| slot.tag == tag(epoch, index))
    }

    /// Whether the last start was with this pose.
    #[inline]
    pub(crate) fn serves(&self, pose: &Pose<'_>) -> bool {
        self.reference == Some(pose.fingerprint())
    }

    /// Counts on with the nodes of the epoch, while leaves are forgotten; `false` at the end of the count,
    /// where everything is.
    pub(crate) fn follow(&mut self) -> bool {
        let epoch = self.epoch;
        self.next_step();
        self.epoch == epoch
    }

    /// What it keeps, for a query.
    #[inline]
    pub(crate) fn slots(&mut self) -> Kept<'_> {
        let counts = [self.size.nodes, self.size.leaves];
        // There is room for them since the cache was made.
        let (nodes, leaves) = self.memory.two_slots(counts).unwrap_or_default();
        Kept {
            nodes,
            leaves,
            step: self.step,
            epoch: self.epoch,
        }
    }

    /// Counts on; at the end of the count everything is forgotten.
    fn next_step(&mut self) {
        self.step += 1;
        if self.step == STEP_END {
            let kept = self.slots();
            clear(kept.nodes, kept.leaves);
            (self.step, self.epoch, self.reference) = (1, 0, None);
        }
    }
}

/// The slots of a cache, for one query or several.
#[derive(Debug)]
pub(crate) struct Kept<'c> {
    pub(crate) nodes: &'c mut [NodeSlot],
    pub(crate) leaves: &'c mut [LeafSlot],
    pub(crate) step: u32,
    pub(crate) epoch: u32,
}

impl Kept<'_> {
    /// Nothing is kept.
    pub(crate) const fn nothing() -> Self {
        Self {
            nodes: &mut [],
            leaves: &mut [],
            step: 1,
            epoch: 1,
        }
    }

    /// The same for a shorter time.
    #[inline]
    pub(crate) fn again(&mut self) -> Kept<'_> {
        Kept {
            nodes: self.nodes,
            leaves: self.leaves,
            step: self.step,
            epoch: self.epoch,
        }
    }
}

fn clear(nodes: &mut [NodeSlot], leaves: &mut [LeafSlot]) {
    for slot in nodes {
        slot.tag = 0;
    }
    for slot in leaves {
        slot.tag = 0;
    }
}
