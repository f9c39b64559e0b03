//! A chair from a `.bdt` file that vibrates and stops a ball:
//!
//! ```text
//! cargo run --example first_mesh
//! ```
//!
//! writes `target/bevy/first_mesh.png`.

use std::f32::consts::TAU;

use bdtree_bevy::{
    BdtModel, BdtreePlugin, BdtreeSystems, Deformation, DeformedInstance, DeformingMesh,
};
use bdtree_runtime::{Ball, Contact, Workspace};
use bevy_app::{App, PostUpdate, Update};
use bevy_asset::AssetServer;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_math::{DVec3, Vec3};
use bevy_mesh::Meshable;
use bevy_time::Time;
use bevy_transform::components::Transform;

mod support;

use support::picture::Picture;

/// World units.
const RADIUS: f64 = 0.08;
const SEAT: f32 = 0.45;

/// A ball that falls.
#[derive(Component)]
pub(crate) struct Falling {
    pub(crate) velocity: DVec3,
    pub(crate) touches: usize,
}

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() {
    support::show_errors();
    let (_, picture) = run();
    println!("{}", picture.save("first_mesh").display());
}

/// The program, and its picture after three seconds.
pub(crate) fn run() -> (App, Picture) {
    support::models::write(&support::models::baked("chair.obj", 6), "chair.bdt");
    let mut app = support::app(480, 360, &support::models::folder());
    app.add_plugins(BdtreePlugin)
        .add_systems(Update, vibrate)
        // Where instances are in this frame's pose.
        .add_systems(PostUpdate, fall.after(BdtreeSystems::Pose));
    support::start(&mut app);
    let chair = app
        .world()
        .resource::<AssetServer>()
        .load::<BdtModel>("chair.bdt");
    let world = app.world_mut();
    support::camera(world, Vec3::new(1.1, 1.1, 1.6), Vec3::new(0.0, 0.4, 0.0));
    support::sun(world, Vec3::new(1.0, 3.0, 1.5));
    let wood = support::material(world, Color::srgb(0.75, 0.5, 0.3));
    world.spawn((DeformingMesh(chair), wood));
    let plane = bevy_shape::Plane3d::default().mesh().size(6.0, 6.0);
    let ground = support::solid(world, plane, Color::srgb(0.6, 0.62, 0.6));
    world.spawn(ground);
    let sphere = bevy_shape::Sphere::new(RADIUS as f32)
        .mesh()
        .ico(5)
        .expect("a sphere");
    let ball = support::solid(world, sphere, Color::srgb(0.15, 0.35, 0.8));
    world.spawn((
        ball,
        Transform::from_xyz(0.02, 3.0 * SEAT, 0.02),
        Falling {
            velocity: DVec3::ZERO,
            touches: 0,
        },
    ));
    support::run_until(&mut app, |app| {
        let world = app.world_mut();
        world.query::<&DeformedInstance>().iter(world).count() > 0
    });
    support::run_undrawn(&mut app, 180);
    support::settle(&mut app);
    let picture = support::take(&mut app);
    (app, picture)
}

/// Three modes go up and down.
fn vibrate(time: Res<Time>, mut meshes: Query<(&mut Deformation, &DeformedInstance)>) {
    let t = time.elapsed_secs();
    for (mut deformation, body) in &mut meshes {
        let mode_count = body.instance.q().len();
        let amplitude = |k: usize| if k < 3 { 0.04 } else { 0.0 };
        deformation.q = (0..mode_count)
            .map(|k| amplitude(k) * (TAU * (0.5 + 0.3 * k as f32) * t).sin())
            .collect();
    }
}

/// Moves the ball and lets the chair push it out of itself.
fn fall(
    time: Res<Time>,
    mut balls: Query<(&mut Transform, &mut Falling)>,
    mut meshes: Query<&mut DeformedInstance>,
    mut found: Local<Vec<Contact>>,
) {
    let dt = f64::from(time.delta_secs());
    let mut workspace = Workspace::new();
    for (mut transform, mut ball) in &mut balls {
        ball.velocity.y -= 9.81 * dt;
        let mut center = transform.translation.as_dvec3() + ball.velocity * dt;
        for mut mesh in &mut meshes {
            found.clear();
            let shape = Ball::new(center.to_array(), RADIUS);
            if let Err(why) = mesh
                .instance
                .query(&mut workspace)
                .contacts(shape, &mut *found)
            {
                panic!("a ball is refused: {why}");
            }
            // The deepest: others along the same way are gone with it.
            let deepest = found
                .iter()
                .min_by(|a, b| a.distance.total_cmp(&b.distance));
            if let Some(contact) = deepest {
                let normal = DVec3::from_array(contact.normal);
                center -= normal * contact.distance;
                let into = ball.velocity.dot(normal).min(0.0);
                ball.velocity -= 1.3 * into * normal;
                // Friction, or it would roll off.
                ball.velocity *= 0.9;
                ball.touches += 1;
            }
        }
        if center.y < RADIUS {
            center.y = RADIUS;
            ball.velocity.y = 0.0;
        }
        transform.translation = center.as_vec3();
    }
}
