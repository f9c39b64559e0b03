//! The product, one adapter per workload: a pose, then questions, in memory that is kept.

pub mod ball;
pub mod pair;
pub mod pile;
pub mod ray;

use bdtree_runtime::{LeafSlot, NodeSlot, StepCache};

/// What an instance keeps during a step.
pub type Cache = StepCache<Vec<NodeSlot>, Vec<LeafSlot>>;

/// Room for so many nodes and leaves.
pub fn cache(nodes: usize, leaves: usize) -> Cache {
    StepCache::new(vec![NodeSlot::EMPTY; nodes], vec![LeafSlot::EMPTY; leaves])
}
