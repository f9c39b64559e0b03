//! A ring whose morph target closes its hole squeezes a ball out:
//!
//! ```text
//! cargo run --example morph_ball
//! ```
//!
//! writes `target/bevy/morph_ball.png`.

use bdtree_bevy::{
    BdtModel, BdtreePlugin, BdtreeSystems, Deformation, DeformedInstance, DeformingMesh,
};
use bdtree_build::input::RawMesh;
use bdtree_fixtures::{bake, models};
use bdtree_runtime::{Ball, Contact, Model, Workspace};
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

/// World units; the hole's radius is 0.65.
const RADIUS: f64 = 0.62;
/// Where the ball lies before it is squeezed.
pub(crate) const BEFORE: f32 = 0.3;

/// The ball.
#[derive(Component)]
pub(crate) struct Squeezed;

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() {
    support::show_errors();
    let (_, [before, after]) = run();
    println!("{}", before.save("morph_ball_before").display());
    println!("{}", after.save("morph_ball").display());
}

/// The program, and pictures before and after the weight went from 0 to 1 within two seconds.
pub(crate) fn run() -> (App, [Picture; 2]) {
    support::models::write(&ring(), "ring.bdt");
    let mut app = support::app(480, 360, &support::models::folder());
    app.add_plugins(BdtreePlugin)
        .insert_resource(Weight(0.0))
        .add_systems(Update, close)
        .add_systems(PostUpdate, squeeze.after(BdtreeSystems::Pose));
    support::start(&mut app);
    let ring = app
        .world()
        .resource::<AssetServer>()
        .load::<BdtModel>("ring.bdt");
    let world = app.world_mut();
    support::camera(world, Vec3::new(0.0, 2.4, 3.0), Vec3::new(0.0, 0.2, 0.0));
    support::sun(world, Vec3::new(1.5, 3.0, 1.0));
    let green = support::material(world, Color::srgb(0.35, 0.65, 0.4));
    world.spawn((DeformingMesh(ring), green));
    let plane = bevy_shape::Plane3d::default().mesh().size(8.0, 8.0);
    let ground = support::solid(world, plane, Color::srgb(0.6, 0.62, 0.6));
    world.spawn((ground, Transform::from_xyz(0.0, -0.35, 0.0)));
    let sphere = bevy_shape::Sphere::new(RADIUS as f32)
        .mesh()
        .ico(5)
        .expect("a sphere");
    let ball = support::solid(world, sphere, Color::srgb(0.8, 0.25, 0.15));
    world.spawn((ball, Squeezed, Transform::from_xyz(0.0, BEFORE, 0.0)));
    support::run_until(&mut app, |app| {
        let world = app.world_mut();
        world.query::<&DeformedInstance>().iter(world).count() > 0
    });
    support::settle(&mut app);
    let before = support::take(&mut app);
    app.insert_resource(Weight(0.5));
    support::run_undrawn(&mut app, 150);
    support::settle(&mut app);
    let after = support::take(&mut app);
    (app, [before, after])
}

/// A torus with one target that moves its inner side towards the axis.
fn ring() -> Model {
    let torus = models::mesh("torus").expect("a mesh");
    let mesh = RawMesh {
        name: "ring".to_string(),
        positions: torus.positions,
        triangles: torus.triangles,
        ..RawMesh::default()
    };
    let towards_axis = |p: &[f64; 3]| {
        let from_axis = p[0].hypot(p[2]);
        let share = ((1.35 - from_axis) / 0.7).clamp(0.0, 1.0);
        let by = -0.4 * share * share / from_axis;
        [by * p[0], 0.0, by * p[2]]
    };
    let field = mesh.positions.iter().map(towards_axis).collect();
    bake::baked(&mesh, &bake::basis_of(&[field]))
}

/// How much the weight of the target grows in a second.
#[derive(Resource)]
struct Weight(f32);

fn close(time: Res<Time>, speed: Res<Weight>, mut rings: Query<&mut Deformation>) {
    for mut deformation in &mut rings {
        let before = deformation.q.first().copied().unwrap_or(0.0);
        let weight = (before + speed.0 * time.delta_secs()).min(1.0);
        if weight != before {
            deformation.q = vec![weight];
        }
    }
}

/// The ball, which is held down by its weight, gives way to the ring.
fn squeeze(
    mut balls: Query<&mut Transform, With<Squeezed>>,
    mut rings: Query<&mut DeformedInstance>,
    mut found: Local<Vec<Contact>>,
) {
    let mut workspace = Workspace::new();
    for mut transform in &mut balls {
        let mut center = transform.translation.as_dvec3();
        for mut ring in &mut rings {
            // Several contacts of a step hold it from all sides: a few rounds sort them out.
            for _ in 0..8 {
                found.clear();
                let shape = Ball::new(center.to_array(), RADIUS);
                let contacts = ring
                    .instance
                    .query(&mut workspace)
                    .contacts(shape, &mut *found);
                if let Err(why) = contacts {
                    panic!("a ball is refused: {why}");
                }
                let push: DVec3 = found
                    .iter()
                    .map(|c| -c.distance.min(0.0) * DVec3::from_array(c.normal))
                    .sum();
                center += push / found.len().max(1) as f64;
            }
        }
        transform.translation = center.as_vec3();
    }
}
