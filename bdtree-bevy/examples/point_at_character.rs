//! A pointer hits an animated character; the triangle that it hits is shown:
//!
//! ```text
//! cargo run --example point_at_character [-- CHARACTER.glb]
//! ```
//!
//! writes `target/bevy/point_at_character.png`. Without an argument the character is a tube with four joints.

use std::path::PathBuf;

use bdtree_bevy::{
    BdtModel, BdtreePlugin, BdtreeSystems, Deformation, DeformedGizmos, DeformedInstance,
    DeformingMesh,
};
use bdtree_runtime::{Model, Ray, RayIntersection, SkeletonPose, Workspace};
use bevy_app::{App, PostUpdate, Update};
use bevy_asset::{Assets, Handle};
use bevy_camera::Camera;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::gizmos::Gizmos;
use bevy_math::{Vec2, Vec3};
use bevy_mesh::Meshable;
use bevy_time::Time;
use bevy_transform::components::{GlobalTransform, Transform};

mod support;

use support::picture::Picture;

/// What is pointed at (pixels from the upper left).
pub(crate) const POINTER: Vec2 = Vec2::new(232.0, 145.0);

/// A clip of the file that plays.
#[derive(Component)]
struct Playing {
    clip: usize,
    pose: SkeletonPose,
}

/// Where the pointer is (pixels from the upper left).
#[derive(Resource)]
pub(crate) struct Pointer(pub(crate) Vec2);

/// What it hits.
#[derive(Resource, Default)]
pub(crate) struct Hit(pub(crate) Option<(Entity, RayIntersection)>);

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() {
    let file = std::env::args_os().nth(1).map(PathBuf::from);
    let model = match file {
        Some(file) => support::models::baked_file(&file, 0),
        None => support::models::baked("skinned_tube.glb", 0),
    };
    let (app, picture) = run(&model, POINTER);
    if let Some((entity, hit)) = &app.world().resource::<Hit>().0 {
        let asset = model.asset();
        let joint = asset
            .joint_of(hit.triangle, hit.barycentric)
            .expect("a hit");
        let name = joint.and_then(|joint| asset.skeleton()?.joint_name(joint));
        println!(
            "{entity}: {:?} of {name:?} at {:?}",
            hit.triangle, hit.point
        );
    }
    println!("{}", picture.save("point_at_character").display());
}

/// The program with three characters, each in a moment of its own, and its picture.
pub(crate) fn run(model: &Model, pointer: Vec2) -> (App, Picture) {
    let mut app = support::app(480, 360, &support::models::folder());
    app.add_plugins(BdtreePlugin)
        .insert_resource(Pointer(pointer))
        .init_resource::<Hit>()
        .add_systems(Update, play)
        // Where instances are in this frame's pose.
        .add_systems(PostUpdate, pick.after(BdtreeSystems::Pose));
    support::start(&mut app);
    let world = app.world_mut();
    let handle: Handle<BdtModel> = world.resource_mut::<Assets<BdtModel>>().add(model.clone());
    let (center, size) = extent(model);
    let at = Vec3::new(0.0, 0.6, 0.0);
    support::camera(world, at + Vec3::new(0.3, 0.5, 1.6), at);
    support::sun(world, Vec3::new(1.0, 3.0, 1.5));
    let skin = support::material(world, Color::srgb(0.5, 0.6, 0.75));
    let clip_count = model
        .asset()
        .skeleton()
        .map_or(0, |skeleton| skeleton.clip_count());
    for k in 0..3 {
        let scale = 1.0 / size;
        let place = Vec3::new(1.1 * (k as f32 - 1.0), 0.7, 0.0) - center * scale;
        world.spawn((
            DeformingMesh(handle.clone()),
            skin.clone(),
            Transform::from_translation(place).with_scale(Vec3::splat(scale)),
            Playing {
                clip: k % clip_count.max(1),
                pose: SkeletonPose::new(model).expect("a file with a skeleton"),
            },
        ));
    }
    let plane = bevy_shape::Plane3d::default().mesh().size(12.0, 12.0);
    let ground = support::solid(world, plane, Color::srgb(0.6, 0.62, 0.6));
    world.spawn(ground);
    support::run_undrawn(&mut app, 25);
    support::settle(&mut app);
    let picture = support::take(&mut app);
    (app, picture)
}

/// The middle and the largest side of the box at rest (mesh units).
fn extent(model: &Model) -> (Vec3, f32) {
    let instance = bdtree_runtime::Instance::new(model).expect("an instance");
    let found = instance.aabb().expect("a box");
    let [min, max] = [found.min, found.max].map(|v| Vec3::from_array(v.map(|x| x as f32)));
    ((min + max) / 2.0, (max - min).max_element())
}

fn play(time: Res<Time>, mut characters: Query<(&mut Deformation, &mut Playing)>) {
    for (mut deformation, mut playing) in &mut characters {
        let clip = playing.clip;
        // Each looks at its clip; a file without clips stays at rest.
        if playing
            .pose
            .play(clip, f64::from(time.elapsed_secs()))
            .is_err()
        {
            continue;
        }
        deformation.q = playing.pose.q().to_vec();
        deformation.joints = support::models::joints(&playing.pose);
    }
}

/// The nearest hit of the pointer's ray, and its triangle as lines.
fn pick(
    pointer: Res<Pointer>,
    cameras: Query<(&Camera, &GlobalTransform)>,
    mut characters: Query<(Entity, &mut DeformedInstance)>,
    mut hit: ResMut<Hit>,
    mut gizmos: Gizmos,
) {
    hit.0 = None;
    let mut workspace = Workspace::new();
    for (camera, transform) in &cameras {
        let Ok(ray) = camera.viewport_to_world(transform, pointer.0) else {
            continue;
        };
        let origin = ray.origin.to_array().map(f64::from);
        let ray = Ray::new(origin, ray.direction.to_array().map(f64::from));
        for (entity, mut character) in &mut characters {
            match character.instance.query(&mut workspace).cast_ray(&ray) {
                Ok(Some(found)) => {
                    let nearest = hit
                        .0
                        .as_ref()
                        .map_or(f64::INFINITY, |(_, hit)| hit.distance);
                    if found.distance < nearest {
                        hit.0 = Some((entity, found));
                    }
                }
                Ok(None) => {}
                Err(why) => panic!("a ray is refused: {why}"),
            }
        }
    }
    if let Some((entity, found)) = &hit.0
        && let Ok((_, character)) = characters.get(*entity)
    {
        let red = Color::srgb(1.0, 0.0, 0.0);
        let shown = gizmos.ray_hit(&character.instance.pose(), found, 0.3, red);
        shown.expect("a hit of this character");
    }
}
