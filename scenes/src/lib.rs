//! The paper's experiments, the baselines to beat and what measuring them takes.

pub mod bounds;
pub mod clock;
pub mod deform;
pub mod leaf;
pub mod machine;
pub mod paper_tree;
pub mod peers;
pub mod stats;
pub mod workloads;
