//! Collision and proximity queries on reduced deformable meshes `p' = p + U q`, straight from
//! the reduced coordinates `q`, without ever deforming the mesh.
//!
//! ```
#![doc = include_str!("../examples/first_query.rs")]
//! ```
//!
//! A [`Model`] owns a `.bdt` file; an [`Instance`] is one deforming body with all the memory that it needs; a
//! [`Workspace`] is the memory that queries work in. [`Query`] and [`PairQuery`] list everything that can be
//! asked. `bdtree-runtime/examples` has the uses: many instances, picking, animations, forces, static memory.
//!
//! # Features
//!
//! | feature | gives |
//! |---|---|
//! | (none) | `no_std`, no allocation: [`Asset`] over bytes of the caller's, [`Asset::pose`], [`Workspace::in_bytes`] and every query |
//! | `alloc` | what owns its memory: [`Model`], [`Instance`], [`SkeletonPose`], [`Workspace::new`], [`StepCache::new`], [`PairFront::new`] |
//! | `std` (default) | `alloc`; instruction sets are detected at run time; `Model::read`, `LoadError` |
//! | `mmap` | `std`; `Model::load` maps a file, whose pages are read when queries touch them |
//! | `mint` | points, vectors, quaternions and matrices of every library that speaks mint (glam, nalgebra, …) as arguments and back |
//!
//! Deforming whole meshes for drawing is `bdtree-gpu`'s.
//!
//! # The flow of a query
//!
//! `open` bytes → [`Asset`] view → [`Pose`] (q and a placement, prepared once per step; a
//! [`StepCache`] keeps what its queries compute) → [`bound`] (the eight-lane node kernel) → traversal in the
//! workspace → exact narrow phase on touched triangles only → [`Contact`]s.
//!
//! # Concepts
//!
//! *Mesh units* are the units of the source mesh. *Stored units* are mesh units times a power of
//! two, relative to the asset's origin; only the tree sees them. *World* is where a pose places
//! the mesh: `x = rotation · (scale · (origin + p')) + translation`. All public coordinates and
//! lengths are world.
//!
//! *The promise*: for every finite q inside the asset's limits a query returns exactly what
//! testing every deformed triangle with the same leaf arithmetic returns. `docs/design/guarantees.md`
//! derives the constants; they are named here as there.
//!
//! *What the compiler checks, and what it cannot*: a pose carries its asset, so the two are never of different
//! files. A cache that was not started with the pose that is asked, and a motion that does not stand at it, are
//! errors of the query.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod animation;
pub mod bound;
pub mod broad;
mod cache;
mod contact;
mod deform;
mod depth;
mod drawing;
#[doc(hidden)]
pub mod embed;
mod epoch;
mod error;
mod force;
#[cfg(feature = "alloc")]
mod instance;
pub mod joint;
#[doc(hidden)]
pub mod math;
mod matrix;
#[cfg(feature = "alloc")]
mod memory;
mod metadata;
#[cfg(feature = "mmap")]
mod mmap;
#[cfg(feature = "alloc")]
mod model;
mod motion;
pub mod narrow;
mod open;
mod pair_frame;
mod placement;
mod pose;
mod proxy;
mod quantized_q;
mod query;
#[cfg(test)]
mod reference;
mod rounding;
mod shape;
mod simd;
pub mod skeleton;
pub mod studies;
mod transform;
mod traverse;
mod vector;
mod verify;
mod view;
mod workspace;

pub use animation::{AnimationFrame, SampleError};
pub use cache::{CacheSize, StepCache};
pub use contact::{
    Contact, Coverage, PairContact, PointProjection, Proxy, RayIntersection, Sink, SliceSink,
    TriangleId, TrianglePair, VertexId,
};
pub use drawing::{AssetId, StoredToWorld};
pub use error::{Datum, FormatError, HEADER_SECTION, PoseError, QueryError};
#[cfg(feature = "alloc")]
pub use instance::Instance;
pub use joint::JointMatrix;
#[cfg(feature = "std")]
pub use model::LoadError;
#[cfg(feature = "alloc")]
pub use model::Model;
pub use motion::Motion;
pub use pose::Pose;
pub use query::{
    Aabb, BoundingSphere, Budgeted, BudgetedContacts, BudgetedPairQuery, BudgetedQuery,
    ContactManifold, ContactPoint, PairFront, PairQuery, Query,
};
pub use shape::{Ball, Capsule, Cuboid, Frustum, FrustumState, HalfSpace, Ray, Shape};
pub use simd::Kernel;
#[cfg(feature = "alloc")]
pub use skeleton::SkeletonPose;
pub use skeleton::{Clip, LocalTransform, Skeleton, SkeletonError};
pub use transform::Transform;
pub use vector::{Quat, Vec3};
pub use view::{Asset, Displacements, Group, GroupKind, NodeBones, NodeRows};
pub use workspace::{Stats, Workspace};

/// The programs of the README and of the guide, compiled with the tests.
#[cfg(all(doctest, feature = "mmap"))]
mod pages {
    #[doc = include_str!("../../README.md")]
    struct Readme;
    #[doc = include_str!("../../docs/guide/tutorial.md")]
    struct Tutorial;
    #[doc = include_str!("../../docs/guide/bake-an-animation.md")]
    struct BakeAnAnimation;
    #[doc = include_str!("../../docs/guide/pick-with-a-ray.md")]
    struct PickWithARay;
    #[doc = include_str!("../../docs/guide/pairs-in-contact.md")]
    struct PairsInContact;
}
