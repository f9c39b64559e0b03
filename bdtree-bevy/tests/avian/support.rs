//! Worlds of tests.

use std::time::Duration;

use avian3d::prelude::*;
use bdtree_bevy::avian::{BdtreePhysicsPlugins, DeformingCollider};
use bdtree_bevy::{BdtModel, BdtreePlugin, DeformingMesh};
use bdtree_runtime::Model;
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, Handle};
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;

/// Seconds of a step.
pub(crate) const STEP_S: f32 = 1.0 / 64.0;

/// A program without a window, one physics step per update.
pub(crate) fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        TransformPlugin,
        AssetPlugin::default(),
        BdtreePlugin,
        BdtreePhysicsPlugins::default(),
    ))
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(
        STEP_S,
    )));
    app.finish();
    app.cleanup();
    // Time has not moved in the first update.
    app.update();
    app
}

/// An asset in the program.
pub(crate) fn add(app: &mut App, model: &Model) -> Handle<BdtModel> {
    let mut models = app.world_mut().resource_mut::<Assets<BdtModel>>();
    models.add(BdtModel::from(model.clone()))
}

/// A body that is a deforming mesh.
pub(crate) fn mesh_body(app: &mut App, mesh: Handle<BdtModel>, more: impl Bundle) -> Entity {
    let body = (DeformingMesh(mesh), DeformingCollider, more);
    app.world_mut().spawn(body).id()
}

pub(crate) fn steps(app: &mut App, count: usize) {
    for _ in 0..count {
        app.update();
    }
}

/// Contacts of two entities, deepest first.
pub(crate) fn contacts(app: &App, a: Entity, b: Entity) -> Vec<ContactPoint> {
    let graph = app.world().resource::<ContactGraph>();
    let mut points: Vec<ContactPoint> = graph
        .get(a, b)
        .map(|(_, pair)| {
            let points = pair.manifolds.iter().flat_map(|manifold| &manifold.points);
            points.copied().collect()
        })
        .unwrap_or_default();
    points.sort_by(|a, b| b.penetration.total_cmp(&a.penetration));
    points
}
