//! Tests of one program: linking one is quicker than linking each. What needs a process of its own is beside it in
//! Cargo.toml.

mod chairs;
mod experiments;
mod film;
mod fish;
mod logs;
mod paper_tree;
mod peers;
mod skins;
mod workloads;
