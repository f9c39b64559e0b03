//! What the product is measured against, and what measuring takes: the paper's own BD-Tree and its layered
//! hierarchy ([`paper_tree`]), libraries that deform all vertices and refit a tree ([`peers`]), all on the
//! same numbers ([`Body`], [`deform`]), with contacts from the product's exact arithmetic ([`leaf`] says who
//! tests how many triangles at a time). [`standing`] tells who is ahead over how much is asked.

mod body;
pub mod clock;
pub mod deform;
pub mod leaf;
pub mod machine;
pub mod paper_tree;
pub mod peers;
pub mod place;
pub mod standing;
pub mod stats;

pub use body::Body;
pub use place::Place;
