//! What the tests of the workspace share: the corpus, oracles, poses, damaged files and the
//! generators of fixtures.

pub mod ask;
pub mod bake;
pub mod body;
pub mod budgets;
pub mod collisions;
pub mod compare;
pub mod compare_cached;
pub mod compare_shapes;
pub mod corpus;
pub mod fixtures;
pub mod flush;
pub mod fuzz;
pub mod gltf_twin;
pub mod golden;
pub mod hard;
pub mod hostile;
pub mod judge;
pub mod lanes;
pub mod mutate;
pub mod near;
pub mod oracle;
pub mod pair_caches;
pub mod poses;
pub mod processes;
pub mod resident;
pub mod sections;
