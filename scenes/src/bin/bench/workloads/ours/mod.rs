//! The product, one adapter per workload: a pose, then questions, in memory that is kept.

pub(crate) mod ball;
pub(crate) mod pair;
pub(crate) mod pile;
pub(crate) mod ray;

use bdtree_runtime::{LeafSlot, NodeSlot, StepCache};

/// What an instance keeps during a step.
pub(crate) type Cache = StepCache<Vec<NodeSlot>, Vec<LeafSlot>>;

pub(crate) fn cache(nodes: usize, leaves: usize) -> Cache {
    StepCache::new(vec![NodeSlot::EMPTY; nodes], vec![LeafSlot::EMPTY; leaves])
}
