//! The paper's experiments, the baselines to beat and what measuring them takes.

pub mod machine;
pub mod paper_tree;
pub mod stats;
