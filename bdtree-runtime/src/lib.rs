//! Collision and proximity queries on reduced deformable meshes `p' = p + U q`, straight from
//! the reduced coordinates `q`, without ever deforming the mesh.
//!
//! ```
#![doc = include_str!("../examples/first_query.rs")]
//! ```
//!
//! A [`Model`] owns a `.bdt` file; an [`Instance`] is one deforming body with all the memory that it needs; a
//! [`Workspace`] is the memory that queries work in. [`Query`] and [`PairQuery`] list everything that can be
//! asked. `bdtree-runtime/examples` has the uses: many instances, picking, animations, forces, static memory; run one
//! with `cargo run --release -p bdtree-runtime --example picking`.
//!
//! # Queries
//!
//! | asked of one mesh | answer |
//! |---|---|
//! | [`Query::contacts`], [`Query::intersects`] | triangles that a [`Ball`], [`Capsule`], [`Cuboid`] or [`HalfSpace`] touches |
//! | [`Query::project_point`] | the nearest point |
//! | [`Query::cast_ray`], [`Query::intersects_ray`], [`Query::cast_ray_all`] | what a [`Ray`] meets: first, any, all |
//! | [`Query::cast_rays`], [`Query::intersects_rays`], [`Query::cast_rays_all`] | the same for many rays at once |
//! | [`Query::frustum_state`] | inside, across or outside a view [`Frustum`] |
//! | [`Query::level_spheres`] | lanes of a level whose spheres a shape touches, no triangles |
//!
//! | asked of two meshes | answer |
//! |---|---|
//! | [`PairQuery::contacts`], [`PairQuery::triangle_pairs`] | triangles that touch or are near |
//! | [`PairQuery::intersects`], [`PairQuery::is_within`] | whether there are any |
//! | [`PairQuery::closest_points`], [`PairQuery::distance`] | the nearest two triangles |
//! | [`PairQuery::contact_manifolds`], [`PairQuery::condense`] | regions of contact with normal, area and depth |
//! | [`PairQuery::level_spheres`] | pairs of lanes of two levels whose spheres are near, no triangles |
//! | [`PairQuery::level_triangles`] | lanes of a level of the first, and the second's triangles that are near their spheres |
//!
//! Which of many instances may meet at all: [`broad::pairs`], and `broad::instance_pairs` with the feature `alloc`.
//!
//! *Options* of a query are methods that return it: a [`StepCache`] ([`Query::cached`]), a deepest level
//! ([`Query::max_level`]), a number of visits ([`Query::max_visits`]), for many questions at one pose a
//! [`RefinedPose`] ([`Query::refined`], [`StepCache::refining`]), for pairs a [`PairFront`] ([`PairQuery::front`]).
//!
//! Rules that hold for all of them:
//!
//! * Queries take and return world coordinates and lengths. Items in stored or mesh units say so.
//! * Meshes are surfaces, not solids: a ball wholly inside a closed mesh touches nothing.
//! * Triangles are closed and two-sided. Those of zero area act as a segment or a point; rays miss them.
//! * Limits are inclusive: a triangle at exactly the radius, `max_distance` or `prediction` is reported.
//! * Coordinates are finite and at most 2^100; lengths are not negative either, and a `max_distance` may be
//!   infinite. Directions and normals are finite, not zero, and of any length. Rotations are quaternions
//!   (x, y, z, w) within 1e-3 of unit length. Anything else is [`QueryError::Argument`], whose text names the argument.
//! * A [`Sink`] takes what is found: a `Vec` or a [`SliceSink`]. Sinks append: clear them yourself.
//! * Points and vectors are `impl Into<Vec3>`, rotations `impl Into<Quat>`: [`Vec3`] lists what converts.
//!
//! # Features
//!
//! | feature | gives |
//! |---|---|
//! | (none) | `no_std`, no allocation: [`Asset`] over bytes of the caller's, [`Asset::pose`], [`Workspace::in_bytes`] and every query |
//! | `alloc` | what owns its memory: [`Model`], [`Instance`], [`SkeletonPose`], [`Workspace::new`], [`StepCache::new`], [`RefinedPose::new`], [`PairFront::new`] |
//! | `std` (default) | `alloc`; instruction sets are detected at run time; `Model::read`, `LoadError` |
//! | `mmap` | `std`; `Model::load` maps a file, whose pages are read when queries touch them |
//! | `mint` | conversions between [`Vec3`], [`Quat`], [`Transform`] and the types of mint, which glam, nalgebra and others convert to and from |
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
//! *Mesh units* are the units of the source mesh. *Stored units* are mesh units divided by the asset's unit, a power
//! of two, and relative to its origin; the tree computes in them. *World* is where a pose places the mesh:
//! `x = rotation · (scale · (origin + unit · p')) + translation`, with p' in stored units. Queries take and return
//! world coordinates and lengths. Items in stored or mesh units say so.
//!
//! *Leaf arithmetic* is the one fixed way in which a query computes the deformed vertices of a triangle
//! ([`Pose::deformed_stored`]; SPEC 5.5) and tests the triangle ([`narrow`]).
//!
//! *Guarantee*: for every q within q_limit, a query returns what the same floating-point triangle tests return when run
//! on every deformed triangle. `docs/design/guarantees.md` derives the constants; they are named here as there.
//!
//! *Poses, caches, motions*: A `Pose` borrows its asset, so they always match. A query returns `QueryError::Cache` if
//! its cache was started with another pose, and `QueryError::Motion` if a pose has no motion.
//!
//! *The paper*, which comments cite by section and equation, is D. L. James and D. K. Pai, BD-Tree: Output-Sensitive
//! Collision Detection for Reduced Deformable Models, SIGGRAPH 2004.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod animation;
mod bones;
pub mod bound;
pub mod broad;
mod cache;
mod carried;
mod contact;
mod deform;
mod depth;
mod drawing;
#[doc(hidden)]
pub mod embed;
mod epoch;
mod error;
mod force;
mod hit_bones;
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
mod refined;
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
/// The format's records, which signatures here name: `format::ModeRecord`, `format::SectionKind`.
pub use bdtree_format as format;
pub use bones::{BoneMap, BoneMatrices};
pub use cache::{CacheSize, StepCache};
pub use contact::{
    Contact, Coverage, LaneId, LaneTriangle, PairContact, PointProjection, Proxy, RayIntersection,
    Sink, SliceSink, TriangleId, TrianglePair, VertexId,
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
pub use refined::{PreparePart, RefinedPose};
pub use shape::{Ball, Capsule, Cuboid, Frustum, FrustumState, HalfSpace, Ray, Shape};
pub use simd::Kernel;
#[cfg(feature = "alloc")]
pub use skeleton::SkeletonPose;
pub use skeleton::{Channel, Clip, LocalTransform, Skeleton, SkeletonError};
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
    #[doc = include_str!("../../docs/guide/characters.md")]
    struct Characters;
    #[doc = include_str!("../../docs/guide/pairs-in-contact.md")]
    struct PairsInContact;
}
