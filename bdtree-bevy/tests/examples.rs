//! Each example runs and shows what it says.

use std::time::Duration;

use bdtree_bevy::{Deformation, DeformedInstance};
use bevy_app::App;
use bevy_asset::Assets;
use bevy_camera::Camera;
use bevy_camera::visibility::NoFrustumCulling;
use bevy_ecs::prelude::*;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_pbr::{MeshMaterial3d, StandardMaterial};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::{GlobalTransform, Transform};

use crate::drawing::{Body, deformed_mesh};

#[path = "../examples/first_mesh.rs"]
mod first_mesh;
#[path = "../examples/hot_reload.rs"]
mod hot_reload;
#[path = "../examples/morph_ball.rs"]
mod morph_ball;
#[cfg(feature = "picking")]
#[path = "../examples/pick_character.rs"]
mod pick_character;
#[path = "../examples/thousand_colliders.rs"]
mod thousand_colliders;

/// Pixels whose red, green and blue pass.
fn count(pixels: &[[u8; 3]], passes: impl Fn(u8, u8, u8) -> bool) -> usize {
    let is_it = |p: &&[u8; 3]| passes(p[0], p[1], p[2]);
    pixels.iter().filter(is_it).count()
}

fn is_red(r: u8, g: u8, b: u8) -> bool {
    r > 110 && r / 2 > g.max(b)
}

fn is_blue(r: u8, _: u8, b: u8) -> bool {
    b > 90 && b / 2 > r
}

#[test]
fn first_mesh() {
    let (mut app, picture) = first_mesh::run();
    picture.save("first_mesh");
    let world = app.world_mut();
    let (ball, falling) = world
        .query::<(&Transform, &first_mesh::Falling)>()
        .single(world)
        .unwrap();
    let height = ball.translation.y;
    // On the seat, not on the ground.
    assert!((0.4..0.7).contains(&height), "{height}");
    assert!(falling.touches > 20, "{}", falling.touches);
    let body = world.query::<&DeformedInstance>().single(world).unwrap();
    assert!(body.instance.q().iter().any(|q| q.abs() > 0.01));
    assert!(count(&picture.pixels, is_blue) > 300);
}

#[test]
fn thousand_colliders() {
    let (mut app, picture) = thousand_colliders::run();
    picture.save("thousand_colliders");
    let red = app.world().resource::<thousand_colliders::Red>().0.clone();
    let world = app.world_mut();
    let ball = *world
        .query_filtered::<&Transform, With<thousand_colliders::Flying>>()
        .single(world)
        .unwrap();
    // Brute force over the deformed triangles.
    let center = ball.translation.to_array().map(f64::from);
    let mut touched = 0;
    let mut bodies = world.query::<(&DeformedInstance, &MeshMaterial3d<StandardMaterial>)>();
    for (body, material) in bodies.iter(world) {
        let pose = body.instance.pose();
        let count = body.instance.model().asset().triangle_count() as u32;
        let is_near = |id| {
            let corners = pose
                .deformed_triangle(bdtree_runtime::TriangleId(id))
                .unwrap();
            let nearest = bdtree_runtime::narrow::closest_point(center, &corners).point;
            let off = [0, 1, 2].map(|k| nearest[k] - center[k]);
            off.iter().map(|d| d * d).sum::<f64>().sqrt() <= 2.0
        };
        let is_touched = (0..count).any(is_near);
        assert_eq!(is_touched, material.0 == red);
        touched += usize::from(is_touched);
    }
    assert!(touched > 5, "{touched}");
    assert_drawn_as_deformed(&mut app);
    assert!(count(&picture.pixels, is_red) > 100);
    assert!(count(&picture.pixels, is_blue) > 100);
}

/// All bodies of the scene, which are more than are deformed at a time, look as the processor deforms them.
fn assert_drawn_as_deformed(app: &mut App) {
    use thousand_colliders::support;
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    app.update();
    let found = support::take(app);
    let world = app.world_mut();
    let mut bodies = world.query::<(
        Entity,
        &DeformedInstance,
        &Deformation,
        &Transform,
        &MeshMaterial3d<StandardMaterial>,
    )>();
    let mut deformed = Vec::new();
    for (entity, body, deformation, at, material) in bodies.iter(world) {
        let mesh = deformed_mesh(&Body {
            model: body.instance.model().clone(),
            deformation: deformation.clone(),
            at: *at,
        });
        deformed.push((entity, mesh, *at, material.clone()));
    }
    assert_eq!(deformed.len(), 1000);
    for (entity, ..) in &deformed {
        world.despawn(*entity);
    }
    support::settle(app);
    let none = support::take(app);
    let world = app.world_mut();
    for (_, mesh, at, material) in deformed {
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        world.spawn((Mesh3d(mesh), at, material, NoFrustumCulling));
    }
    support::settle(app);
    let expected = support::take(app);
    expected.save("thousand_colliders_expected");
    let off = found.differing(&expected, 3);
    assert!(off <= 50, "{off} pixels differ");
    let drawn = found.differing(&none, 3);
    assert!(drawn > 50_000, "{drawn} pixels");
}

#[test]
fn morph_ball() {
    let (mut app, [before, after]) = morph_ball::run();
    before.save("morph_ball_before");
    after.save("morph_ball");
    let world = app.world_mut();
    let ball = world
        .query_filtered::<&Transform, With<morph_ball::Squeezed>>()
        .single(world)
        .unwrap();
    let height = ball.translation.y;
    assert!(height > morph_ball::BEFORE + 0.1, "{height}");
    assert!(height.is_finite() && ball.translation.x.hypot(ball.translation.z) < 0.3);
    assert!(before.differing(&after, 10) > 2000);
}

#[cfg(feature = "picking")]
#[test]
fn pick_character() {
    use pick_character::{Picked, support};
    let model = crate::support::models::baked("skinned_tube.glb", 0);
    let (mut app, picture) = pick_character::run(&model);
    picture.save("pick_character");
    assert!(count(&picture.pixels, is_red) > 50);
    // The arrow begins at the pointer.
    let [x, y] = pick_character::POINTER.to_array().map(|x| x as u32);
    let around = (x - 10..x + 10).flat_map(|x| (y - 10..y + 10).map(move |y| (x, y)));
    let around: Vec<_> = around.map(|(x, y)| picture.pixel(x, y)).collect();
    assert!(count(&around, is_red) > 5);

    // What is picked while nothing moves is what brute force over the deformed triangles finds.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    support::take(&mut app).save("pick_character_still");
    // A picture leaves frames without a camera behind, in which nothing is picked.
    for _ in 0..3 {
        app.update();
    }
    let world = app.world_mut();
    let (camera, at) = world
        .query::<(&Camera, &GlobalTransform)>()
        .single(world)
        .unwrap();
    let ray = camera
        .viewport_to_world(at, pick_character::POINTER)
        .unwrap();
    let (from, along) = (ray.origin.to_array(), ray.direction.to_array());
    let (from, along) = (from.map(f64::from), along.map(f64::from));
    let along = bdtree_fixtures::oracle::unit(along);
    let mut bodies = world.query::<(Entity, &DeformedInstance)>();
    let found = bodies.iter(world).filter_map(|(entity, body)| {
        let triangles = bdtree_fixtures::oracle::deformed_triangles(&body.instance.snapshot());
        let hit = bdtree_fixtures::oracle::ray(&triangles, from, along, f64::INFINITY)?;
        Some((entity, hit))
    });
    let (entity, (triangle, distance)) = found
        .min_by(|a, b| a.1.1.total_cmp(&b.1.1))
        .expect("a character below the pointer");
    let picked = world.resource::<Picked>().0;
    let (picked, hit) = picked.expect("a hit");
    assert_eq!((picked, hit.triangle), (entity, triangle));
    assert!((hit.distance - distance).abs() < 1e-9 * distance);
    assert!(pick_character::bone(&model, &hit).is_some());
}

#[test]
fn hot_reload() {
    use hot_reload::{MESHES, Mark, support};
    let (mut app, pictures) = hot_reload::run().unwrap();
    pictures[0].save("hot_reload_before");
    pictures[1].save("hot_reload");
    // The dot is on the torus, whose tube has the radius 0.35 around a circle of radius 1.
    let world = app.world_mut();
    let mut marks = world.query_filtered::<&Transform, With<Mark>>();
    let at = marks.single(world).unwrap().translation;
    let off = at.x.hypot(at.z) - 1.0;
    assert!((off.hypot(at.y) - 0.35).abs() < 0.02, "{at}");
    assert!(at.y > 0.2 && count(&pictures[1].pixels, is_red) > 10);
    // Each picture is that of its mesh, which the processor draws.
    let mut bodies = world.query_filtered::<Entity, With<DeformedInstance>>();
    let body = bodies.single(world).unwrap();
    let look = world.get::<MeshMaterial3d<StandardMaterial>>(body);
    let look = look.unwrap().clone();
    world.despawn(body);
    let mut dots = world.query_filtered::<Entity, With<Mark>>();
    let dot = dots.single(world).unwrap();
    world.despawn(dot);
    for (name, found) in MESHES.iter().zip(&pictures) {
        let body = Body {
            model: bdtree_fixtures::bake::elastic(name, 4, 8, &[]),
            deformation: Deformation::default(),
            at: Transform::default(),
        };
        let world = app.world_mut();
        let mesh = deformed_mesh(&body);
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let drawn = world.spawn((Mesh3d(mesh), look.clone(), NoFrustumCulling));
        let drawn = drawn.id();
        support::settle(&mut app);
        let expected = support::take(&mut app);
        app.world_mut().despawn(drawn);
        // All but the dot and its shadow.
        let off = found.differing(&expected, 3);
        assert!(off < 200, "{name}: {off} pixels differ");
    }
    let changed = pictures[0].differing(&pictures[1], 3);
    assert!(changed > 5000, "{changed}");
}
