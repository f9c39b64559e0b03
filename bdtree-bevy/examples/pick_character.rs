//! A pointer over characters that move: the triangle that it is on is shown, and the bone that carries that place is named.
//!
//! ```text
//! cargo run --example pick_character [-- CHARACTER.glb]
//! ```
//!
//! writes `target/bevy/pick_character.png`. Without an argument the character is a tube with four joints.

use std::path::PathBuf;

use bdtree_bevy::bdtree_runtime::{Instance, Model, TriangleId};
use bdtree_bevy::{
    BdtModel, BdtreePlugin, BdtreeSystems, ClipPlayer, ClipRef, DeformedInstance, DeformingHit,
    DeformingMesh, DeformingPickingPlugin,
};
use bevy_app::{App, PostUpdate, PreUpdate};
use bevy_asset::Assets;
use bevy_camera::Camera;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::gizmos::Gizmos;
use bevy_math::{Isometry3d, Vec2, Vec3};
use bevy_mesh::Meshable;
use bevy_picking::PickingSystems;
use bevy_picking::backend::PointerHits;
use bevy_picking::backend::ray::{RayId, RayMap};
use bevy_picking::pointer::PointerId;
use bevy_transform::components::{GlobalTransform, Transform};

pub(crate) mod support;

use support::picture::Picture;

/// What is pointed at (pixels from the upper left).
pub(crate) const POINTER: Vec2 = Vec2::new(232.0, 145.0);

/// What the pointer is on.
#[derive(Resource, Default)]
pub(crate) struct Picked(pub(crate) Option<(Entity, DeformingHit)>);

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() {
    support::show_errors();
    let file = std::env::args_os().nth(1).map(PathBuf::from);
    let model = match file {
        Some(file) => support::models::baked_file(&file, 0),
        None => support::models::baked("skinned_tube.glb", 0),
    };
    let (app, picture) = run(&model);
    match &app.world().resource::<Picked>().0 {
        Some((entity, hit)) => println!(
            "{entity}: triangle {} at {:.2?}, {:.3} away, carried by {}",
            hit.triangle,
            hit.barycentric,
            hit.distance,
            bone(&model, hit).unwrap_or("no bone"),
        ),
        None => println!("nothing is below the pointer"),
    }
    println!("{}", picture.save("pick_character").display());
}

/// The name of the joint that moves the place of a hit most.
pub(crate) fn bone<'m>(model: &'m Model, hit: &DeformingHit) -> Option<&'m str> {
    let asset = model.asset();
    let joint = asset.joint_of(TriangleId(hit.triangle), hit.barycentric);
    asset.skeleton()?.joint_name(joint.ok()??)
}

/// The program with three characters, each with a clip of its own, and its picture.
pub(crate) fn run(model: &Model) -> (App, Picture) {
    let mut app = support::app(480, 360, &support::models::folder());
    app.add_plugins((BdtreePlugin, DeformingPickingPlugin))
        // A program with a window adds Bevy's `DefaultPickingPlugins` in the place of these three lines: they make rays of
        // the pointers of windows.
        .init_resource::<RayMap>()
        .add_message::<PointerHits>()
        .add_systems(PreUpdate, point.before(PickingSystems::Backend))
        .init_resource::<Picked>()
        .add_systems(PreUpdate, pick.after(PickingSystems::Backend))
        // Where instances are in the pose that is drawn.
        .add_systems(PostUpdate, show.after(BdtreeSystems::Pose));
    support::start(&mut app);
    let world = app.world_mut();
    let mut models = world.resource_mut::<Assets<BdtModel>>();
    let handle = models.add(BdtModel::from(model.clone()));
    let (center, size) = extent(model);
    let at = Vec3::new(0.0, 0.6, 0.0);
    support::camera(world, at + Vec3::new(0.3, 0.5, 1.6), at);
    support::sun(world, Vec3::new(1.0, 3.0, 1.5));
    let skin = support::material(world, Color::srgb(0.5, 0.6, 0.75));
    let skeleton = model.asset().skeleton();
    let clip_count = skeleton.map_or(0, |skeleton| skeleton.clip_count());
    for k in 0..3 {
        let scale = 1.0 / size;
        let place = Vec3::new(1.1 * (k as f32 - 1.0), 0.7, 0.0) - center * scale;
        let character = world.spawn((
            DeformingMesh(handle.clone()),
            skin.clone(),
            Transform::from_translation(place).with_scale(Vec3::splat(scale)),
        ));
        let character = character.id();
        if clip_count > 0 {
            let clip = ClipRef::Index(k % clip_count);
            world.entity_mut(character).insert(ClipPlayer {
                clip,
                ..Default::default()
            });
        }
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
    let instance = Instance::new(model).expect("an instance");
    let found = instance.aabb().expect("a box");
    let [min, max] = [found.min, found.max].map(|v| Vec3::from_array(v.map(|x| x as f32)));
    ((min + max) / 2.0, (max - min).max_element())
}

/// The ray of a mouse that rests on the picture.
fn point(cameras: Query<(Entity, &Camera, &GlobalTransform)>, mut rays: ResMut<RayMap>) {
    rays.map.clear();
    for (entity, camera, at) in &cameras {
        if let Ok(ray) = camera.viewport_to_world(at, POINTER) {
            let id = RayId::new(entity, PointerId::Mouse);
            rays.map.insert(id, ray);
        }
    }
}

/// The nearest of what the pointer hits.
fn pick(mut hits: MessageReader<PointerHits>, mut picked: ResMut<Picked>) {
    let picks = hits.read().flat_map(|hits| &hits.picks);
    let of_meshes =
        picks.filter_map(|(entity, data)| Some((*entity, *data.extra_as::<DeformingHit>()?)));
    picked.0 = of_meshes.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
}

/// Lines around the triangle and a cross at the point, where both are in this frame's pose.
fn show(picked: Res<Picked>, bodies: Query<&DeformedInstance>, mut gizmos: Gizmos) {
    let Some((entity, hit)) = &picked.0 else {
        return;
    };
    let Ok(body) = bodies.get(*entity) else {
        return;
    };
    let pose = body.instance.snapshot();
    let Ok(corners) = pose.deformed_triangle(TriangleId(hit.triangle)) else {
        return;
    };
    let corners = corners.map(|v| Vec3::from_array(v.map(|x| x as f32)));
    let weights = hit.barycentric.map(|w| w as f32);
    let at: Vec3 = (corners.iter().zip(weights)).map(|(v, w)| *v * w).sum();
    let red = Color::srgb(1.0, 0.0, 0.0);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    gizmos.lineloop(corners, red);
    gizmos.cross(Isometry3d::from_translation(at), 0.03, red);
    gizmos.arrow(at, at + 0.3 * normal.normalize_or_zero(), red);
}
