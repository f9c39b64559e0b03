//! A flexible chair among rigid boxes, under avian or rapier.
//!
//!     cargo run --features avian --example flexible_chair -- ../target/chair.bdt
//!     cargo run --features rapier --example flexible_chair -- ../target/chair.bdt
//!
//! Four boxes fall on a chair and around it. Without a window; prints what happens in five seconds of simulated time. Without a
//! file it bakes the chair of the fixtures, coarsely. With both features avian moves the bodies.

use std::time::Duration;

use bdtree_bevy::{BdtModel, BdtreePlugin, Deformation, DeformingMesh};
use bdtree_runtime::Model;
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, Handle};
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;

/// Half of a box's edge.
pub const HALF: f32 = 0.08;

/// Where boxes start: over the seat, beside it, and on each other.
const STARTS: [[f32; 3]; 4] = [
    [0.02, 0.9, 0.0],
    [-0.03, 1.2, 0.04],
    [0.5, 0.4, 0.1],
    [0.48, 0.7, 0.12],
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = match std::env::args().nth(1) {
        Some(path) => Model::read(path)?,
        None => bdtree_fixtures::bake::elastic("chair", 6, 30, &[]),
    };
    let mut app = program();
    let scene = scene(&mut app, &file);
    println!("under {}", engine::NAME);
    for step in 0..=64 * 5 {
        app.update();
        if step % 64 == 0 {
            println!("{}", state(&app, &scene));
        }
    }
    Ok(())
}

/// A program without a window: each update is a step of 1/64 s.
pub fn program() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        TransformPlugin,
        AssetPlugin::default(),
        BdtreePlugin,
    ))
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
        1.0 / 64.0,
    )));
    engine::add(&mut app);
    app.finish();
    app.cleanup();
    app
}

/// The entities of the scene, for those who draw it.
pub struct Scene {
    /// Has a `DeformingMesh`.
    pub chair: Entity,
    /// Cubes with edges of twice [`HALF`].
    pub boxes: Vec<Entity>,
}

/// A chair on the ground, which is the plane y = 0, and boxes above it, in a program with the engine's plugins.
pub fn scene(app: &mut App, file: &Model) -> Scene {
    let asset = app
        .world_mut()
        .resource_mut::<Assets<BdtModel>>()
        .add(BdtModel::from(file.clone()));
    engine::ground(app);
    let chair = engine::chair(app, asset, Transform::from_xyz(0.0, 0.01, 0.0));
    let boxes = (0..).zip(STARTS).map(|(k, at)| {
        let turn = Quat::from_rotation_y(0.4 * k as f32);
        let at = Transform::from_translation(Vec3::from_array(at)).with_rotation(turn);
        engine::cube(app, at)
    });
    let boxes = boxes.collect();
    Scene { chair, boxes }
}

/// Heights of the boxes and the largest coordinate of the chair.
fn state(app: &App, scene: &Scene) -> String {
    let height = |entity: &Entity| {
        let at = app.world().get::<Transform>(*entity);
        format!("{:.3}", at.map_or(f32::NAN, |at| at.translation.y))
    };
    let heights: Vec<String> = scene.boxes.iter().map(height).collect();
    let q = app.world().get::<Deformation>(scene.chair);
    let largest = q.map_or(0.0, |pose| pose.q.iter().fold(0.0, |m, q| q.abs().max(m)));
    format!(
        "boxes at {} m, largest |q| {largest:.5}",
        heights.join(", ")
    )
}

/// What differs between engines: avian.
#[cfg(feature = "avian")]
mod engine {
    use super::*;
    use avian3d::prelude::*;
    use bdtree_bevy::avian::{BdtreePhysicsPlugins, Flexible};

    pub(super) const NAME: &str = "avian";

    pub(super) fn add(app: &mut App) {
        app.add_plugins(BdtreePhysicsPlugins::default());
    }

    pub(super) fn ground(app: &mut App) {
        let ground = (
            RigidBody::Static,
            Collider::cuboid(10.0, 1.0, 10.0),
            Transform::from_xyz(0.0, -0.5, 0.0),
        );
        app.world_mut().spawn(ground);
    }

    pub(super) fn chair(app: &mut App, mesh: Handle<BdtModel>, at: Transform) -> Entity {
        let chair = (
            DeformingMesh(mesh),
            Flexible::default(),
            RigidBody::Dynamic,
            Friction::new(0.5),
            at,
        );
        app.world_mut().spawn(chair).id()
    }

    pub(super) fn cube(app: &mut App, at: Transform) -> Entity {
        let edge = 2.0 * HALF;
        let cube = (
            RigidBody::Dynamic,
            Collider::cuboid(edge, edge, edge),
            Mass(2.0),
            Friction::new(0.5),
            at,
        );
        app.world_mut().spawn(cube).id()
    }
}

/// What differs between engines: rapier.
#[cfg(all(feature = "rapier", not(feature = "avian")))]
mod engine {
    use super::*;
    use bdtree_bevy::rapier::{RapierBody, RapierFlexible, RapierPlugin, RapierWorld};
    use rapier3d::prelude::*;

    pub(super) const NAME: &str = "rapier";

    pub(super) fn add(app: &mut App) {
        app.add_plugins(RapierPlugin::default());
    }

    pub(super) fn ground(app: &mut App) {
        let ground = ColliderBuilder::cuboid(5.0, 0.5, 5.0);
        let mut world = app.world_mut().resource_mut::<RapierWorld>();
        let at = Vector::new(0.0, -0.5, 0.0);
        world.world.insert_collider(ground.translation(at), None);
    }

    pub(super) fn chair(app: &mut App, mesh: Handle<BdtModel>, at: Transform) -> Entity {
        let chair = (DeformingMesh(mesh), RapierFlexible::default(), at);
        app.world_mut().spawn(chair).id()
    }

    pub(super) fn cube(app: &mut App, at: Transform) -> Entity {
        let pose = rapier3d::math::Pose::from_parts(at.translation, at.rotation);
        let mut world = app.world_mut().resource_mut::<RapierWorld>();
        let (body, _) = world.world.insert(
            RigidBodyBuilder::dynamic().pose(pose),
            ColliderBuilder::cuboid(HALF, HALF, HALF)
                .mass(2.0)
                .friction(0.5),
        );
        app.world_mut().spawn((RapierBody::from(body), at)).id()
    }
}

/// Without an engine the scene stands still.
#[cfg(not(any(feature = "avian", feature = "rapier")))]
mod engine {
    use super::*;

    pub(super) const NAME: &str = "no engine: add --features avian or --features rapier";

    pub(super) fn add(_: &mut App) {}

    pub(super) fn ground(_: &mut App) {}

    pub(super) fn chair(app: &mut App, mesh: Handle<BdtModel>, at: Transform) -> Entity {
        app.world_mut().spawn((DeformingMesh(mesh), at)).id()
    }

    pub(super) fn cube(app: &mut App, at: Transform) -> Entity {
        app.world_mut().spawn(at).id()
    }
}
