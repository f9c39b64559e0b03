//! What a program adds.

use bevy_app::{App, Plugin, PostUpdate};
use bevy_asset::AssetApp;
use bevy_camera::visibility::VisibilitySystems;
use bevy_ecs::prelude::*;
use bevy_transform::TransformSystems;

use crate::asset::{BdtLoader, BdtModel};
use crate::pose::{self, Deformation, DeformingMesh};

/// Loads `.bdt` files and keeps the instances that queries ask. Add it after Bevy's `AssetPlugin`.
#[derive(Debug, Default, Clone, Copy)]
pub struct BdtreePlugin;

/// What the systems of [`BdtreePlugin`] do in `PostUpdate`, in this order.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BdtreeSystems {
    /// Instances take the poses of their entities: after `TransformSystems::Propagate`.
    Pose,
    /// Boxes of the deformed meshes are written: before `VisibilitySystems::CheckVisibility`.
    Bounds,
}

impl Plugin for BdtreePlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<BdtModel>()
            .init_asset_loader::<BdtLoader>()
            .register_type::<DeformingMesh>()
            .register_type::<Deformation>()
            .configure_sets(
                PostUpdate,
                (BdtreeSystems::Pose, BdtreeSystems::Bounds)
                    .chain()
                    .after(TransformSystems::Propagate)
                    .before(VisibilitySystems::CheckVisibility),
            )
            .add_systems(
                PostUpdate,
                pose::update_instances.in_set(BdtreeSystems::Pose),
            );
    }

    #[cfg(any(feature = "render", feature = "gizmos"))]
    fn finish(&self, app: &mut App) {
        #[cfg(feature = "render")]
        crate::render::finish(app);
        #[cfg(feature = "gizmos")]
        crate::gizmos::finish(app);
    }
}
