//! Measuring: the machine ([`machine`]), times on it ([`clock`], [`stats`], [`turns`]), tables and plots ([`table`],
//! [`plot`]), and the [`report`] on an asset.
//!
//! And what the product is measured against: the paper's own BD-Tree and its layered hierarchy ([`paper_tree`]),
//! libraries that deform all vertices and refit a tree ([`peers`]), all on the same numbers ([`Body`], [`deform`]) as the
//! product ([`ours`]), with
//! contacts from the product's exact arithmetic ([`leaf`] says who tests how many triangles at a time). [`sample`] poses an asset and asks about it. [`comparison`]
//! tells who is ahead over how much is asked.

mod body;
pub mod clock;
pub mod comparison;
pub mod deform;
mod error;
pub mod leaf;
pub mod machine;
pub mod ours;
pub mod paper_tree;
pub mod peers;
pub mod place;
pub mod plot;
pub mod report;
pub mod sample;
mod skin;
pub mod stats;
pub mod table;
pub mod turns;
mod vector;

/// Told how far a report is.
pub use bdtree_build::progress::Progress;
pub use body::Body;
pub use error::MeasureError;
pub use place::Place;
pub use skin::BodySkin;
