//! Whoever answers the questions of a workload, one adapter per contender and workload.

pub mod assets;
pub mod ours;
pub mod paper;
pub mod refitting;
pub mod spheres;
