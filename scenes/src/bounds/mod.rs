//! Which bounds a node wants: a study of balls, boxes, slabs and mixtures over the product's tree.
//!
//! Not the product: bounds are computed here in f64 from the vertices below each lane and counted
//! in plain traversals, so that they can be compared before one of them enters the format.

pub mod affine;
pub mod body;
pub mod bound;
pub mod contenders;
pub mod overlap;
pub mod pair;
pub mod posed;
pub mod scene;
pub mod shape;
pub mod single;
pub mod slabs;
pub mod sphere;
