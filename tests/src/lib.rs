//! What the tests of the workspace share: the corpus, oracles, poses, damaged files and the
//! generators of fixtures.

pub mod bake;
pub mod collisions;
pub mod compare;
pub mod corpus;
pub mod fixtures;
pub mod gltf_twin;
pub mod golden;
pub mod mutate;
pub mod oracle;
pub mod poses;
pub mod resident;
pub mod sections;
