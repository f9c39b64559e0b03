//! What the tests that cross crates share: mutated inputs for every reader.

pub mod fuzz;
