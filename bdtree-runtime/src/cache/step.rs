//! The cache over slots: steps, epochs, and the pose that they serve.

use super::slots::{LeafSlot, NodeSlot, STEP_END, place, tag};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::refined::{Refine, RefinedPose, Refining, refining_cost};
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
    /// What refining that pose costs.
    cost: u64,
    refining: Option<Refining<'m>>,
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
            cost: u64::MAX,
            refining: None,
        }
    }

    /// Lets the cache refine poses by itself, in this memory, where it pays: the whole pose, as [`RefinedPose::prepare`] does, or of
    /// meshes from 5600 triangles on the parts where queries come often, in as much memory as there is, if that is enough for two. At once in a step that
    /// follows one in which it would have paid, or when the first of many rays together tell that it will, else when the step has
    /// visited as much as pays, or twice as much if the step before did not. Answers stay the same.
    ///
    /// Steps among their like then cost as much as the better of both ways, within some percent, or less where they ask about a small
    /// part. One that asks unexpectedly much costs about four times as much, at most. Rays, balls and nearest points
    /// of one mesh use parts; other queries of one mesh and those of two use the whole pose, if it is there.
    /// All but distances of two meshes count towards it.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # use bdtree_runtime::{Asset, CacheSize, Ray, RefinedPose, StepCache, Transform, Workspace, include_bdt};
    /// # let asset = Asset::open(include_bdt!("../../../fixtures/golden/sphere.bdt"))?;
    /// # let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
    /// # let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
    /// let mut cache = StepCache::new(CacheSize::NONE).refining(RefinedPose::new());
    /// cache.start(&pose); // in each step
    /// let rays = vec![Ray::new([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]); 10_000];
    /// let mut hits = vec![None; rays.len()];
    /// let mut workspace = Workspace::new();
    /// pose.query(&mut workspace).cached(&mut cache).cast_rays(&rays, &mut hits)?;
    /// assert!(cache.is_refined());
    /// # Ok(())
    /// # }
    /// ```
    pub fn refining(mut self, memory: RefinedPose<'m>) -> Self {
        self.set_refining(Some(memory));
        self
    }

    /// The same, or no more of it.
    pub(crate) fn set_refining(&mut self, memory: Option<RefinedPose<'m>>) {
        self.refining = memory.map(|memory| Refining::new(memory, self.cost));
    }

    /// Whether the whole pose is refined now.
    pub fn is_refined(&self) -> bool {
        self.refining.as_ref().is_some_and(Refining::is_ready)
    }

    /// Triangles of the parts that are refined now: all, or those of the parts where queries have come often.
    pub fn refined_triangles(&self) -> usize {
        self.refining.as_ref().map_or(0, Refining::triangles)
    }

    /// Forgets everything, in constant time, and serves this pose from now on, wherever it is placed.
    pub fn start(&mut self, pose: &Pose<'_>) {
        self.cost = refining_cost(pose.asset);
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
        self.parts().0
    }

    /// The same, and what refines by itself.
    #[inline]
    pub(crate) fn parts(&mut self) -> (Kept<'_>, Option<&mut dyn Refine>) {
        let counts = [self.size.nodes, self.size.leaves];
        // There is room for them since the cache was made.
        let (nodes, leaves) = self.memory.two_slots(counts).unwrap_or_default();
        let kept = Kept {
            nodes,
            leaves,
            step: self.step,
            epoch: self.epoch,
        };
        let refining = self.refining.as_mut();
        (kept, refining.map(|refining| refining as &mut dyn Refine))
    }

    /// Counts on; at the end of the count everything is forgotten.
    fn next_step(&mut self) {
        self.step += 1;
        if let Some(refining) = &mut self.refining {
            refining.next_step(self.cost);
        }
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
