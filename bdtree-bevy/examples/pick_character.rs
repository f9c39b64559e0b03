//! A pointer over a character that moves: which triangle it is on, where on it, and which bone carries that place.
//!
//! `cargo run --example pick_character`, in `bdtree-bevy`. It needs no window: the pointer's ray is put into Bevy's `RayMap`
//! by hand, where Bevy's `PickingPlugin` puts those of real pointers.

use std::time::Duration;

use bdtree_bevy::bdtree_runtime::{Model, TriangleId};
use bdtree_bevy::{
    BdtModel, BdtreePlugin, ClipPlayer, ClipRef, DeformedInstance, DeformingHit, DeformingMesh,
    DeformingPickingPlugin, DeformingPickingSettings, PickVisibility,
};
use bevy_app::{App, AppExit, ScheduleRunnerPlugin, Startup, TaskPoolPlugin, Update};
use bevy_asset::{AssetPlugin, Assets};
use bevy_camera::Camera;
use bevy_ecs::prelude::*;
use bevy_log::LogPlugin;
use bevy_math::{Dir3, Vec3};
use bevy_picking::backend::PointerHits;
use bevy_picking::backend::ray::{RayId, RayMap};
use bevy_picking::pointer::PointerId;
use bevy_shape::Ray3d;
use bevy_time::{Time, TimePlugin};
use bevy_transform::TransformPlugin;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut app = App::new();
    app.add_plugins((
        ScheduleRunnerPlugin::run_loop(Duration::from_millis(50)),
        LogPlugin::default(),
        TaskPoolPlugin::default(),
        TimePlugin,
        // No files here.
        AssetPlugin {
            watch_for_changes_override: Some(false),
            ..Default::default()
        },
        TransformPlugin,
        BdtreePlugin,
        DeformingPickingPlugin,
    ))
    .init_resource::<RayMap>()
    .add_message::<PointerHits>()
    // Nothing is drawn here.
    .insert_resource(DeformingPickingSettings {
        visibility: PickVisibility::Any,
        ..Default::default()
    })
    .add_systems(Startup, spawn)
    .add_systems(Update, report);
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(_) => Err("no pointer hit the character in 10 s".into()),
    }
}

fn spawn(
    mut commands: Commands,
    mut models: ResMut<Assets<BdtModel>>,
    mut rays: ResMut<RayMap>,
    mut exit: MessageWriter<AppExit>,
) {
    // A bar along x on three joints, whose clip bends it to a half circle. A program loads it:
    // `files.load::<BdtModel>("character.bdt")` with Bevy's `AssetServer`.
    let Ok(model) = Model::from_bytes(&bdtree_fixtures::skin::skinned_bar()) else {
        exit.write(AppExit::error());
        return;
    };
    let bend = ClipPlayer {
        clip: ClipRef::Name("bend".to_string()),
        ..Default::default()
    };
    let model = models.add(BdtModel::from(model));
    commands.spawn((DeformingMesh(model), bend));
    let camera = commands.spawn(Camera::default()).id();
    let ray = Ray3d::new(Vec3::new(3.4, 2.3, 9.0), Dir3::NEG_Z);
    let id = RayId::new(camera, PointerId::Mouse);
    rays.map.insert(id, ray);
}

/// Prints what the pointer is on, twenty times.
fn report(
    mut hits: MessageReader<PointerHits>,
    bodies: Query<&DeformedInstance>,
    players: Query<&ClipPlayer>,
    time: Res<Time>,
    mut count: Local<usize>,
    mut exit: MessageWriter<AppExit>,
) {
    for (entity, data) in hits.read().flat_map(|hits| &hits.picks) {
        let (Some(hit), Ok(body)) = (data.extra_as::<DeformingHit>(), bodies.get(*entity)) else {
            continue;
        };
        let asset = body.instance.model().asset();
        let joint = asset.joint_of(TriangleId(hit.triangle), hit.barycentric);
        let joint = joint.ok().flatten();
        let name = joint.and_then(|joint| asset.skeleton()?.joint_name(joint));
        let clip_s = players.get(*entity).map_or(0.0, |player| player.time_s);
        println!(
            "at {clip_s:.2} s of the clip: triangle {} at {:.2?}, {:.3} away, carried by {}",
            hit.triangle,
            hit.barycentric,
            hit.distance,
            name.unwrap_or("no bone"),
        );
        *count += 1;
    }
    if *count >= 20 {
        exit.write(AppExit::Success);
    } else if time.elapsed_secs() > 10.0 {
        exit.write(AppExit::error());
    }
}
