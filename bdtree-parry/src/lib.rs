//! Reduced deformable meshes `p' = p + U q` as shapes of parry and bodies of rapier.
//!
//! A [`DeformingModel`] is a `.bdt` file as physics engines need it: with the neighbors of each triangle and its mass. A
//! [`DeformingMesh`] is that model at one q: a [`Shape`](parry3d::shape::Shape), cheap to clone. A [`MeshDispatcher`]
//! answers parry's queries between such meshes and every other shape, and asks parry's own dispatcher for the rest.
//!
//! ```
#![doc = include_str!("../examples/first_shape.rs")]
//! ```
//!
//! # How a query goes
//!
//! The tree of the asset finds, from q alone, the triangles that can matter: those in reach of the other shape's box, ball,
//! capsule or half-space. Only their vertices are computed. parry's own functions for a triangle and a shape do the rest,
//! so answers are those of parry for a mesh of all deformed triangles. Two deforming meshes are asked exactly by
//! `bdtree-runtime`, and so are rays and points.
//!
//! | asked | of a mesh and any other shape | of two meshes |
//! |---|---|---|
//! | `intersection_test`, `distance`, `closest_points` | the best over triangles | exact, in f64 |
//! | `contact` | the deepest triangle | the deepest pair of triangles |
//! | `contact_manifolds` | the points of all triangles, grouped by normal | regions of contact, with depth |
//! | `cast_shapes`, `cast_shapes_nonlinear` | the first triangle | the first triangle of one and of the other |
//!
//! Meshes are surfaces: a shape wholly inside a closed one touches nothing.
//!
//! # Composite shapes
//!
//! parry's dispatcher takes composite shapes apart and drops what it does not know in them: contacts of a shape of its user's
//! with a `Compound`, `TriMesh`, `Polyline`, `HeightField` or `Voxels` would be lost without an error. So
//! [`MeshDispatcher`] is asked first and takes them apart itself, also a `Compound` that holds deforming meshes.
//!
//! `contact_manifolds` pushes out of `Voxels` through the faces that no neighbor covers, as parry does: what slides over a floor
//! of voxels does not stop at the next one. Nothing pushes out what is behind such faces by more than two voxels. All other
//! queries, `contact` too, are of each voxel alone.
//!
//! # Features
//!
//! | feature | gives |
//! |---|---|
//! | `f32` (default) | shapes of `parry3d`, here |
//! | `f64` | shapes of `parry3d-f64`, in the module `double` |
//! | `modes`, `modes-f64` | `FlexibleBody`: the modes of a body, for other engines |
//! | `rapier`, `rapier-f64` | `FlexibleBodies`: bodies of `rapier3d` and `rapier3d-f64` whose contacts move q |
// The same files make the shapes of either precision.
#![allow(clippy::duplicate_mod)]

// Numbers are of its type already.
#[cfg(feature = "f64")]
#[allow(clippy::unnecessary_cast, clippy::useless_conversion)]
pub mod double;
mod error;
mod model;
#[cfg(feature = "f32")]
mod single;

pub use error::ShapeError;
pub use model::DeformingModel;
#[cfg(feature = "f32")]
pub use single::*;

/// The program of the guide, compiled with the tests.
#[cfg(all(doctest, feature = "rapier"))]
mod pages {
    #[doc = include_str!("../../docs/guide/rapier.md")]
    struct Rapier;
}
