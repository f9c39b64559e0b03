//! Colliders of avian that deform (feature `avian`).
//!
//! avian takes colliders of one type. [`BdtCollider`] is a shape of avian's or a deforming mesh, and
//! [`BdtreePhysicsPlugins`] are avian's `PhysicsPlugins` for it: every pair of shapes goes through `bdtree-parry`'s
//! dispatcher, so that contacts inside a `Compound`, `TriMesh`, `HeightField` or `Voxels` are found as well.
//!
//! * Give an entity avian's `Collider` as ever: it gets a [`BdtCollider`] of the same shape.
//! * Give a [`DeformingMesh`](crate::DeformingMesh) a [`DeformingCollider`]: its collider takes the entity's
//!   [`Deformation`](crate::Deformation) before every step, pushes what it meets, and wakes what sleeps on it.
//! * Add [`Flexible`], and contacts move the coordinates of its vibration modes.
//!
//! [`BdtSpatialQuery`] asks all of them; avian's own `SpatialQuery`, ray and shape casters and swept collision detection see
//! `Collider`s alone. Bodies
//! fast enough to pass through a mesh within a step need avian's `SpeculativeCcd`.

mod collider;
mod contacts;
mod flexible;
mod follow;
mod plugin;
mod queries;
mod surface;

pub use collider::{BdtCollider, MeshCollider};
pub use flexible::{Flexible, FlexibleModes};
pub use follow::DeformingCollider;
pub use plugin::{BdtreePhysicsPlugins, BdtreePhysicsPluginsWithHooks, ColliderPlugin};
pub use queries::BdtSpatialQuery;
