//! Tests that cross crates, in one program: linking one is quicker than linking each. What needs a process of its own
//! is beside it in Cargo.toml.

mod animations;
mod containment;
mod determinism;
mod elastic_queries;
mod gpu_limits;
mod gpu_normals;
mod gpu_positions;
mod gpu_vertex_shader;
mod messy_bakes;
mod nested;
mod python_reader;
