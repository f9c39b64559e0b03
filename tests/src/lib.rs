//! What the tests that cross crates share: mutated inputs for every reader, and the GPU that tests run on.

pub mod fuzz;
pub mod gpu;
