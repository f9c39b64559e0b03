//! Deforming meshes in Bevy: `.bdt` files as assets, poses as components, and collision and proximity queries that are
//! answered from the pose without deforming the mesh.
//!
//! Add [`BdtreePlugin`], load a [`BdtModel`] with Bevy's `AssetServer`, and give an entity a [`DeformingMesh`]. Write what
//! moves it to its [`Deformation`], or let others write it:
//!
//! | component | pose |
//! |---|---|
//! | [`ClipPlayer`] | a clip or the animation of the file itself |
//! | [`PoseFromMorphs`] | Bevy's `MeshMorphWeights` or `MorphWeights` |
//! | [`PoseFromJoints`] | the joint entities of Bevy's `SkinnedMesh` |
//!
//! Where two of them write the same, the later of the table wins. What does not fit (another number of weights, a sheared
//! `GlobalTransform`) stands in the entity's [`PoseFaults`] and is logged once.
//!
//! The plugin keeps on the entity a [`DeformedInstance`], [`DeformedBounds`] in the world and Bevy's `Aabb` in the entity's
//! space, which hold the deformed mesh whatever its morph targets and bones do. [`DeformingQueries`] asks all of them; a
//! [`DeformingCollider`] has [`ContactStarted`] and [`ContactStopped`] written. [`BdtreeSystems`] says when what happens.
//! With a material of Bevy's it is drawn deformed: `docs/guide/bevy.md` has a complete program, which draws.
//! With the feature `picking`, `DeformingPickingPlugin` lets pointers hit the deformed surface.
//!
//! ```no_run
//! use bdtree_bevy::{BdtModel, BdtreePlugin, ClipPlayer, DeformingMesh, DeformingQueries};
//! use bdtree_bevy::bdtree_runtime::Ray;
//! use bevy_app::{App, Startup, TaskPoolPlugin, Update};
//! use bevy_asset::{AssetPlugin, AssetServer};
//! use bevy_ecs::prelude::*;
//! use bevy_transform::TransformPlugin;
//!
//! fn spawn(mut commands: Commands, files: Res<AssetServer>) {
//!     let model = files.load::<BdtModel>("walker.bdt");
//!     commands.spawn((DeformingMesh(model), ClipPlayer::default()));
//! }
//!
//! fn look(mut queries: DeformingQueries) {
//!     let down = Ray::new([0.0, 9.0, 0.0], [0.0, -1.0, 0.0]);
//!     if let Ok(Some(hit)) = queries.cast_ray(&down, |_| true) {
//!         println!("{} is {} below", hit.entity, hit.distance);
//!     }
//! }
//!
//! # // With Bevy itself: `DefaultPlugins` instead of the first three.
//! App::new()
//!     .add_plugins((TaskPoolPlugin::default(), AssetPlugin::default(), TransformPlugin))
//!     .add_plugins(BdtreePlugin)
//!     .add_systems(Startup, spawn)
//!     .add_systems(Update, look)
//!     .run();
//! ```

mod asset;
#[cfg(feature = "avian")]
pub mod avian;
mod bounds;
mod contacts;
mod faults;
#[cfg(feature = "gizmos")]
mod gizmos;
#[cfg(feature = "picking")]
mod picking;
mod placement;
mod plugin;
mod pose;
mod queries;
#[cfg(feature = "rapier")]
pub mod rapier;
#[cfg(feature = "render")]
mod render;
#[cfg(any(feature = "avian", feature = "rapier"))]
mod shape;
mod sources;

pub use asset::{BdtLoadError, BdtLoader, BdtModel};
pub use bdtree_runtime;
pub use bounds::DeformedBounds;
pub use contacts::{ContactStarted, ContactStopped, DeformingCollider, TouchingPairs};
pub use faults::{PoseFaults, PoseStage};
#[cfg(feature = "gizmos")]
pub use gizmos::{BdtreeGizmos, DeformedGizmos, ShowBox, ShowSpheres};
#[cfg(feature = "picking")]
pub use picking::{
    DeformingHit, DeformingPickingCamera, DeformingPickingPlugin, DeformingPickingSettings,
    PickVisibility,
};
pub use placement::{PlacementError, placement};
pub use plugin::{BdtreePlugin, BdtreeSystems};
pub use pose::{Deformation, DeformedInstance, DeformingMesh};
pub use queries::{DeformingQueries, EntityHit, WorldQueryError};
#[cfg(feature = "render")]
pub use render::DrawDeformed;
pub use sources::{ClipPlayer, ClipRef, JointOrder, MorphOrder, PoseFromJoints, PoseFromMorphs};

/// The programs of the guide, compiled with the tests.
#[cfg(doctest)]
mod pages {
    #[cfg(feature = "avian")]
    #[doc = include_str!("../../docs/guide/avian.md")]
    struct Avian;
    #[cfg(feature = "render")]
    #[doc = include_str!("../../docs/guide/bevy.md")]
    struct Bevy;
}
