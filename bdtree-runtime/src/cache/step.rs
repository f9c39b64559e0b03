//! The cache over slots: steps, epochs, and the pose that they serve.

use super::slots::{LeafSlot, NodeSlot, STEP_END, place, tag};
use crate::epoch::Drift;
use crate::error::{FormatError, PoseError};
use crate::pose::Pose;
use crate::view::Asset;

/// What one instance keeps during a step, in memory of the caller's: slices, arrays or vectors of
/// [`NodeSlot`]s (136 bytes) and [`LeafSlot`]s (176 bytes), of any length. [`Asset::node_count`] node
/// slots keep every node, half as many leaf slots as [`Asset::triangle_count`] every leaf.
///
/// ```
/// # use bdtree_runtime::{StepCache, NodeSlot, LeafSlot};
/// let cache = StepCache::new([NodeSlot::EMPTY; 64], [LeafSlot::EMPTY; 64]);
/// ```
#[derive(Debug, Clone)]
pub struct StepCache<N, L> {
    pub(super) nodes: N,
    pub(super) leaves: L,
    /// The step that leaves were deformed in, above 0 and below [`STEP_END`].
    pub(super) step: u32,
    /// The step that nodes were evaluated in, and what identifies its pose.
    pub(super) epoch: u32,
    pub(super) reference: Option<u64>,
}

impl<N: AsMut<[NodeSlot]>, L: AsMut<[LeafSlot]>> StepCache<N, L> {
    /// A cache over this memory, emptied.
    pub fn new(mut nodes: N, mut leaves: L) -> Self {
        clear(nodes.as_mut(), leaves.as_mut());
        Self {
            nodes,
            leaves,
            step: 0,
            epoch: 0,
            reference: None,
        }
    }

    /// Forgets everything, in constant time, and serves `pose` from now on.
    pub fn start<'s>(&'s mut self, pose: &'s Pose<'s>) -> CachedPose<'s> {
        self.next_step();
        self.epoch = self.step;
        self.reference = Some(pose.fingerprint());
        self.serve(pose, None)
    }

    /// Serves `pose` with the node spheres of the last [`StepCache::start`], whose pose was `reference`:
    /// they grow by δR ‖q − q₀‖, one multiply-add per sphere instead of a node update (paper, eq. 8);
    /// nodes first visited now are evaluated at `reference` too, so that errors do not add up over
    /// steps. Leaves are deformed anew. Spheres are looser than evaluated ones: start again
    /// when [`CachedPose::growth`] is no longer small beside the radius of a leaf.
    ///
    /// # Errors
    /// [`PoseError::Reference`] if `reference` is not the pose of the last start, or `pose` one of
    /// another asset.
    pub fn follow<'s>(
        &'s mut self,
        asset: &Asset<'_>,
        reference: &'s Pose<'s>,
        pose: &'s Pose<'s>,
    ) -> Result<CachedPose<'s>, PoseError> {
        if self.reference != Some(reference.fingerprint()) {
            return Err(PoseError::Reference);
        }
        let drift = Drift::new(asset, reference, pose).ok_or(PoseError::Reference)?;
        let epoch = self.epoch;
        self.next_step();
        if self.epoch != epoch {
            return Ok(self.start(pose)); // the count began anew and everything is forgotten
        }
        Ok(self.serve(pose, Some((reference, drift))))
    }

    /// Counts on; at the end of the count everything is forgotten.
    fn next_step(&mut self) {
        self.step += 1;
        if self.step == STEP_END {
            clear(self.nodes.as_mut(), self.leaves.as_mut());
            (self.step, self.epoch, self.reference) = (1, 0, None);
        }
    }

    fn serve<'s>(
        &'s mut self,
        pose: &'s Pose<'s>,
        drift: Option<(&'s Pose<'s>, Drift)>,
    ) -> CachedPose<'s> {
        CachedPose {
            pose,
            drift,
            nodes: self.nodes.as_mut(),
            leaves: self.leaves.as_mut(),
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

/// A pose together with what queries on it have computed so far; made by [`StepCache::start`] or
/// [`StepCache::follow`]. Queries take `&mut` of it in place of `&Pose`.
#[derive(Debug)]
pub struct CachedPose<'s> {
    pub(super) pose: &'s Pose<'s>,
    /// Where nodes are evaluated, if not at `pose`.
    pub(super) drift: Option<(&'s Pose<'s>, Drift)>,
    pub(super) nodes: &'s mut [NodeSlot],
    pub(super) leaves: &'s mut [LeafSlot],
    pub(super) step: u32,
    pub(super) epoch: u32,
}

impl<'s> CachedPose<'s> {
    /// The pose.
    pub fn pose(&self) -> &'s Pose<'s> {
        self.pose
    }

    /// Whether the spheres of node `index` are kept. Where there are as many slots as nodes none makes
    /// room for another: then it says whether a query has visited the node since
    /// [`StepCache::start`].
    pub fn keeps(&self, index: u32) -> bool {
        let slot = self.nodes.get(place(index as usize, self.nodes.len()));
        slot.is_some_and(|slot| slot.tag == tag(self.epoch, index))
    }

    /// What following a reference has added to the radii of the root's lanes, at most (world units):
    /// about as much as to all others, since δR hardly shrinks with depth.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn growth(&self, asset: &Asset<'_>) -> Result<f64, FormatError> {
        let Some((_, drift)) = &self.drift else {
            return Ok(0.0);
        };
        let added = drift.added(asset.node_rows(asset.node(0)?)?.steps);
        let largest = added.into_iter().fold(0.0_f32, f32::max);
        Ok(f64::from(largest) * self.pose.placement.world_per_stored())
    }
}
