//! What a program adds.

use bevy_app::{App, Plugin, PostUpdate};
use bevy_asset::{AssetApp, AssetEventSystems};
use bevy_camera::visibility::VisibilitySystems;
use bevy_ecs::prelude::*;
use bevy_transform::TransformSystems;

use crate::asset::{BdtLoader, BdtModel};
use crate::bounds;
use crate::contacts::{self, ContactStarted, ContactStopped, DeformingCollider, TouchingPairs};
use crate::pose::{self, Deformation, DeformingMesh};
use crate::sources::{self, ClipPlayer, PoseFromJoints, PoseFromMorphs};

/// Loads `.bdt` files and keeps the instances that queries ask. Add it after Bevy's `AssetPlugin`.
#[derive(Debug, Default, Clone, Copy)]
pub struct BdtreePlugin;

/// What the systems of [`BdtreePlugin`] do in `PostUpdate`, in this order.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BdtreeSystems {
    /// Clips go on: before `TransformSystems::Propagate`.
    Play,
    /// Deformations take what Bevy's morph weights and joints say: after `TransformSystems::Propagate`.
    Sources,
    /// Instances take the poses of their entities.
    Pose,
    /// Boxes of the deformed meshes are written: before `VisibilitySystems::CheckVisibility`.
    Bounds,
    /// Contacts between deforming meshes begin and end.
    Contacts,
}

impl Plugin for BdtreePlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<BdtModel>()
            .init_asset_loader::<BdtLoader>()
            .register_type::<DeformingMesh>()
            .register_type::<Deformation>()
            .register_type::<ClipPlayer>()
            .register_type::<PoseFromMorphs>()
            .register_type::<PoseFromJoints>()
            .register_type::<DeformingCollider>()
            .init_resource::<TouchingPairs>()
            .add_message::<ContactStarted>()
            .add_message::<ContactStopped>()
            .configure_sets(
                PostUpdate,
                (
                    BdtreeSystems::Play.before(TransformSystems::Propagate),
                    (
                        BdtreeSystems::Sources,
                        BdtreeSystems::Pose,
                        BdtreeSystems::Bounds,
                    )
                        .chain()
                        .after(TransformSystems::Propagate)
                        .after(AssetEventSystems)
                        // Whose boxes leave morphs out.
                        .after(VisibilitySystems::CalculateBounds)
                        .before(VisibilitySystems::CheckVisibility),
                    BdtreeSystems::Contacts.after(BdtreeSystems::Bounds),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    sources::play_clips.in_set(BdtreeSystems::Play),
                    (sources::read_morphs, sources::read_joints)
                        .chain()
                        .in_set(BdtreeSystems::Sources),
                    (
                        pose::update_instances,
                        pose::make_instances,
                        contacts::set_groups,
                    )
                        .chain()
                        .in_set(BdtreeSystems::Pose),
                    (bounds::update_bounds, bounds::make_bounds)
                        .chain()
                        .in_set(BdtreeSystems::Bounds),
                    contacts::find_contacts.in_set(BdtreeSystems::Contacts),
                ),
            )
            .add_observer(pose::drop_instance)
            .add_observer(bounds::drop_bounds);
    }

    #[cfg(any(feature = "render", feature = "gizmos"))]
    fn finish(&self, app: &mut App) {
        #[cfg(feature = "render")]
        crate::render::finish(app);
        #[cfg(feature = "gizmos")]
        crate::gizmos::finish(app);
    }
}
