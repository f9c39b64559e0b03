//! Bakes a mesh and its deformation basis into a `.bdt` file.

pub mod advise;
pub mod basis;
pub mod elastic;
pub mod encode;
pub mod error;
pub mod input;
mod parallel;
pub mod pipeline;
pub mod progress;
pub mod report;
pub mod tree;
pub mod wrap;
