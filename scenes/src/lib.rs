//! The paper's experiments: workloads, and a study of bounds.

pub mod bounds;
pub mod workloads;
