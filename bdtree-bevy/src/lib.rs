//! Deforming meshes in Bevy: `.bdt` files as assets, poses as components, and collision and proximity queries that are
//! answered from the pose without deforming the mesh.
//!
//! Add [`BdtreePlugin`], load a [`BdtModel`] with Bevy's `AssetServer`, and give an entity a [`DeformingMesh`]. Write what
//! moves it to its [`Deformation`].

mod asset;
#[cfg(feature = "avian")]
pub mod avian;
mod plugin;
mod pose;
#[cfg(feature = "rapier")]
pub mod rapier;
#[cfg(any(feature = "avian", feature = "rapier"))]
mod shape;

pub use asset::{BdtLoadError, BdtLoader, BdtModel};
pub use plugin::{BdtreePlugin, BdtreeSystems};
pub use pose::{Deformation, DeformedInstance, DeformingMesh};

/// The program of the guide, compiled with the tests.
#[cfg(all(doctest, feature = "avian"))]
mod pages {
    #[doc = include_str!("../../docs/guide/avian.md")]
    struct Avian;
}
