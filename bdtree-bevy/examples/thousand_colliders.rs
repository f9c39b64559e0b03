//! A thousand bodies of one file, each in a pose of its own, and a ball that flies over them: those that it touches turn
//! red.
//!
//! ```text
//! cargo run --example thousand_colliders
//! ```
//!
//! writes `target/bevy/thousand_colliders.png`.

use std::f32::consts::TAU;

use bdtree_bevy::{
    BdtModel, BdtreePlugin, BdtreeSystems, Deformation, DeformedInstance, DeformingMesh,
};
use bdtree_fixtures::bake;
use bdtree_runtime::{Ball, Workspace};
use bevy_app::{App, PostUpdate, Update};
use bevy_asset::{AssetServer, Handle};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_mesh::Meshable;
use bevy_pbr::{MeshMaterial3d, StandardMaterial};
use bevy_time::Time;
use bevy_transform::components::Transform;

pub(crate) mod support;

use support::picture::Picture;

/// World units.
const RADIUS: f32 = 2.0;

/// The ball.
#[derive(Component)]
pub(crate) struct Flying;

/// When the modes of a body begin to swing.
#[derive(Component)]
struct Phase(f32);

/// What touched bodies wear.
#[derive(Resource)]
pub(crate) struct Red(pub(crate) Handle<StandardMaterial>);

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() {
    support::show_errors();
    let (_, picture) = run();
    println!("{}", picture.save("thousand_colliders").display());
}

/// The program, and its picture after three quarters of a second.
pub(crate) fn run() -> (App, Picture) {
    let mesh = bake::bumpy_sphere(7, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 4));
    support::models::write(&model, "stone.bdt");
    let mut app = support::app(640, 400, &support::models::folder());
    app.add_plugins(BdtreePlugin)
        .add_systems(Update, (swing, fly))
        .add_systems(PostUpdate, touch.after(BdtreeSystems::Pose));
    support::start(&mut app);
    let stone = app
        .world()
        .resource::<AssetServer>()
        .load::<BdtModel>("stone.bdt");
    let world = app.world_mut();
    support::camera(world, Vec3::new(0.0, 15.0, 22.0), Vec3::new(0.0, 0.0, 1.5));
    support::sun(world, Vec3::new(1.0, 3.0, 1.5));
    let yellow = support::material(world, Color::srgb(0.85, 0.7, 0.3));
    let red = support::material(world, Color::srgb(0.8, 0.1, 0.1));
    world.insert_resource(Red(red.0));
    for k in 0..1000 {
        let [x, z] = [k % 40, k / 40].map(|i| i as f32);
        let place = 1.15 * Vec3::new(x - 19.5, 0.0, z - 12.0);
        world.spawn((
            DeformingMesh(stone.clone()),
            yellow.clone(),
            Phase(k as f32 * 0.37),
            Transform::from_translation(place).with_scale(Vec3::splat(0.45)),
        ));
    }
    let sphere = bevy_shape::Sphere::new(RADIUS)
        .mesh()
        .ico(5)
        .expect("a sphere");
    let ball = support::solid(world, sphere, Color::srgb(0.15, 0.35, 0.8));
    world.spawn((ball, Flying, Transform::default()));
    support::run_until(&mut app, |app| {
        let world = app.world_mut();
        world.query::<&DeformedInstance>().iter(world).count() == 1000
    });
    support::run_undrawn(&mut app, 45);
    support::settle(&mut app);
    let picture = support::take(&mut app);
    (app, picture)
}

fn swing(time: Res<Time>, mut bodies: Query<(&mut Deformation, &Phase)>) {
    let t = time.elapsed_secs();
    for (mut deformation, phase) in &mut bodies {
        deformation.q.resize(6, 0.0);
        for (k, q) in deformation.q.iter_mut().enumerate() {
            *q = 1.5 * (TAU * (0.4 + 0.1 * k as f32) * t + phase.0 * (k + 1) as f32).sin();
        }
    }
}

fn fly(time: Res<Time>, mut balls: Query<&mut Transform, With<Flying>>) {
    let t = time.elapsed_secs();
    for mut ball in &mut balls {
        ball.translation = Vec3::new(9.0 * (0.7 * t).sin(), 1.5, -5.0 * (0.9 * t).cos());
    }
}

/// Asks each body whether the ball touches it.
fn touch(
    red: Res<Red>,
    balls: Query<&Transform, With<Flying>>,
    mut bodies: Query<(&mut DeformedInstance, &mut MeshMaterial3d<StandardMaterial>)>,
    mut first: Local<Option<Handle<StandardMaterial>>>,
) {
    let mut workspace = Workspace::new();
    for ball in &balls {
        let center = ball.translation.to_array().map(f64::from);
        let shape = Ball::new(center, f64::from(RADIUS));
        for (mut body, mut material) in &mut bodies {
            let plain = first.get_or_insert_with(|| material.0.clone());
            let is_touched = match body.instance.query(&mut workspace).intersects(shape) {
                Ok(is_touched) => is_touched,
                Err(why) => panic!("a ball is refused: {why}"),
            };
            let new = if is_touched { &red.0 } else { &*plain };
            if material.0 != *new {
                material.0 = new.clone();
            }
        }
    }
}
