//! The product on the workloads that ask more than one body: a pose of each, then queries, in memory that is kept.
//! Single bodies are [`bdtree_measure::ours`].

pub mod pair;
pub mod pile;
