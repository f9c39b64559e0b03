//! Whoever answers the questions of a workload, one adapter per contender and workload, and the contest that
//! lets them take turns.

pub mod assets;
pub mod contest;
pub mod ours;
pub mod paper;
pub mod refitting;
pub mod spheres;
