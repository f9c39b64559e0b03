//! Tests that cross crates, in one program: linking one is quicker than linking each. What needs a process of its own
//! is beside it in Cargo.toml.

mod animations;
mod containment;
mod determinism;
mod elastic_queries;
mod messy_bakes;
mod nested;
mod python_reader;
