//! Deforming meshes in Bevy: `.bdt` files as assets, poses as components, and collision and proximity queries that are
//! answered from the pose without deforming the mesh.
//!
//! Add [`BdtreePlugin`], load a [`BdtModel`] with Bevy's `AssetServer`, and give an entity a [`DeformingMesh`]. Write what
//! moves it to its [`Deformation`]. With a material it is drawn deformed: `docs/guide/bevy.md` has a complete program.

mod asset;
#[cfg(feature = "gizmos")]
mod gizmos;
mod plugin;
mod pose;
#[cfg(feature = "render")]
mod render;

pub use asset::{BdtLoadError, BdtLoader, BdtModel};
#[cfg(feature = "gizmos")]
pub use gizmos::{BdtreeGizmos, DeformedGizmos, ShowBox, ShowSpheres};
pub use plugin::{BdtreePlugin, BdtreeSystems};
pub use pose::{Deformation, DeformedInstance, DeformingMesh};
#[cfg(feature = "render")]
pub use render::DrawDeformed;

/// The program of the guide, compiled with the tests.
#[cfg(all(doctest, feature = "render"))]
mod pages {
    #[doc = include_str!("../../docs/guide/bevy.md")]
    struct Bevy;
}
