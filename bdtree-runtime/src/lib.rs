//! Collision and proximity queries on reduced deformable meshes `p' = p + U q`, straight from
//! the reduced coordinates `q`, without ever deforming the mesh.
//!
//! The flow of a query, one module each:
//!
//! `open` bytes → [`Asset`] view → [`Pose`] (q and a placement, prepared once per step; a
//! [`StepCache`] keeps what its queries compute) →
//! [`bound`] (the eight-lane node kernel) → traversal in the caller's memory → exact narrow
//! phase on touched triangles only → [`contact`]s.
//!
//! The crate is `no_std` and never allocates. Features: `std` (default; instruction sets are
//! detected at run time), `alloc` ([`AlignedBytes`]), `mmap` ([`MappedFile`]), `wgpu`
//! (module `gpu`: skinning on a GPU).
//!
//! # Concepts
//!
//! *Mesh units* are the units of the source mesh. *Stored units* are mesh units times a power of
//! two, relative to the asset's origin; only the tree sees them. *World* is where a pose places
//! the mesh: `x = rotation · (scale · (origin + p')) + translation`. All public coordinates and
//! lengths are world.
//!
//! *The promise*: for every finite q inside the asset's limits a query returns exactly what
//! testing every deformed triangle with the same leaf arithmetic returns. `docs/guarantees.md`
//! derives the constants; they are named here as there.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod animation;
pub mod bound;
pub mod broad;
mod cache;
pub mod contact;
mod deform;
mod depth;
#[doc(hidden)]
pub mod embed;
mod epoch;
pub mod error;
mod force;
#[cfg(feature = "wgpu")]
pub mod gpu;
mod math;
#[cfg(feature = "alloc")]
mod memory;
#[cfg(feature = "mmap")]
mod mmap;
mod motion;
pub mod narrow;
mod open;
mod pair_frame;
mod placement;
mod pose;
mod proxy;
mod quantized_q;
pub mod query;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod retained_bounds;
mod rounding;
mod simd;
mod transform;
mod traverse;
mod verify;
mod view;

pub use animation::AnimationFrame;
pub use cache::{CachedPose, LeafSlot, NodeSlot, Posed, StepCache};
pub use contact::{
    ClosestPoint, Contact, PairContact, Proxy, RayHit, Sink, SliceSink, TriangleId, TrianglePair,
    VertexId,
};
pub use error::{Datum, FormatError, PoseError, QueryError};
pub use force::add_generalized_force;
#[cfg(feature = "alloc")]
pub use memory::AlignedBytes;
#[cfg(feature = "mmap")]
pub use mmap::MappedFile;
pub use motion::Motion;
pub use pose::Pose;
pub use simd::Kernel;
pub use transform::Transform;
pub use traverse::{FrontSlot, PairStackEntry, SearchEntry, StackEntry};
pub use view::{Asset, Displacements, Group, NodeRows};

/// The README's query, compiled with the tests.
#[cfg(all(doctest, feature = "mmap"))]
#[doc = include_str!("../../README.md")]
struct Readme;
