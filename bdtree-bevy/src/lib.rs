//! Deforming meshes in Bevy: `.bdt` files as assets, poses as components, and collision and proximity queries that are
//! answered from the pose without deforming the mesh.
//!
//! Add [`BdtreePlugin`], load a [`BdtModel`] with Bevy's `AssetServer`, and give an entity a [`DeformingMesh`]. Write what
//! moves it to its [`Deformation`].

mod asset;
mod bounds;
mod contacts;
mod faults;
#[cfg(feature = "picking")]
mod picking;
mod placement;
mod plugin;
mod pose;
mod queries;
mod sources;

pub use asset::{BdtLoadError, BdtLoader, BdtModel};
pub use bdtree_runtime;
pub use bounds::DeformedBounds;
pub use contacts::{ContactStarted, ContactStopped, DeformingCollider, TouchingPairs};
pub use faults::{PoseFaults, PoseStage};
#[cfg(feature = "picking")]
pub use picking::{
    DeformingHit, DeformingPickingCamera, DeformingPickingPlugin, DeformingPickingSettings,
    PickVisibility,
};
pub use placement::{PlacementError, placement};
pub use plugin::{BdtreePlugin, BdtreeSystems};
pub use pose::{Deformation, DeformedInstance, DeformingMesh};
pub use queries::{DeformingQueries, EntityHit, WorldQueryError};
pub use sources::{ClipPlayer, ClipRef, JointOrder, MorphOrder, PoseFromJoints, PoseFromMorphs};
