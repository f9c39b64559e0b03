//! The scene of the example `flexible_chair`.

#[path = "../examples/flexible_chair.rs"]
#[allow(dead_code)]
mod flexible_chair;

use bdtree_bevy::{Deformation, DeformedInstance};
use bdtree_fixtures::oracle;
use bevy_app::App;
use bevy_asset::Assets;
use bevy_camera::visibility::NoFrustumCulling;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;

use crate::drawing::{Body, deformed_mesh};
use flexible_chair::{Engine, Falling, HALF, Scene, support};

/// Two boxes lie on the deformed chair or on each other there, two beside it; they are drawn where the engine has them, and
/// the chair as the processor deforms it.
///
/// `place` says where the engine itself has a body.
fn assert_boxes_rest(engine: &dyn Engine, place: fn(&App, Entity) -> Transform) {
    let mut lines = Vec::new();
    let mut tell = |line: &str| lines.push(line.to_string());
    let chair = flexible_chair::chair();
    let (mut app, scene, found) = flexible_chair::run(&chair, engine, Falling::Boxes, &mut tell);
    let name = flexible_chair::name(engine, Falling::Boxes);
    found.save(&name);
    let places: Vec<Transform> = scene.fallen.iter().map(|at| place(&app, *at)).collect();
    let heights: Vec<f32> = places.iter().map(|at| at.translation.y).collect();
    assert!(heights.iter().all(|y| *y > HALF - 0.01), "{lines:?}");
    assert!(heights[0] > 0.45 && heights[1] > 0.45, "{lines:?}");
    assert!(heights[2] < 0.45 && heights[3] < 0.45, "{lines:?}");
    assert_touches_deformed(&app, &scene, places[0]);

    let deformation = app.world().get::<Deformation>(scene.chair).unwrap().clone();
    // Legs give way by centimeters under rapier, and by millimeters under avian, whose friction knows that feet spread.
    let least = if engine.name() == "avian" {
        0.003
    } else {
        0.015
    };
    assert!(deformation.q.iter().any(|q| q.abs() > least), "{lines:?}");
    let body = Body {
        model: chair,
        deformation,
        at: place(&app, scene.chair),
    };
    let expected = drawn_anew(&mut app, &scene, &body, &places);
    expected.save(&format!("{name}_expected"));
    let off = found.differing(&expected, 3);
    assert!(off <= 20, "{off} pixels differ");
}

/// The lowest box lies on the triangles of the deformed chair, three millimeters deep at most, and over no corner of it does the
/// curved seat leave more than two centimeters.
fn assert_touches_deformed(app: &App, scene: &Scene, at: Transform) {
    let chair = app.world().get::<DeformedInstance>(scene.chair).unwrap();
    let triangles = oracle::deformed_triangles(&chair.instance.snapshot());
    let corners = (0..8).map(|k: u32| {
        let side = |bit: u32| if k >> bit & 1 == 0 { -HALF } else { HALF };
        at.transform_point(Vec3::new(side(0), side(1), side(2)))
    });
    let down = [0.0, -1.0, 0.0];
    let gaps: Vec<f64> = corners
        .filter(|corner| corner.y < at.translation.y)
        .filter_map(|corner| {
            // From the height of the middle, so that a corner that is within shows as less than nothing.
            let from = Vec3::new(corner.x, at.translation.y, corner.z);
            let from = from.to_array().map(f64::from);
            let hit = oracle::ray(&triangles, from, down, 1.0)?;
            Some(hit.1 - f64::from(at.translation.y - corner.y))
        })
        .collect();
    assert!(gaps.len() == 4, "{gaps:?}");
    assert!(
        gaps.iter().all(|gap| *gap > -0.003 && *gap < 0.02),
        "{gaps:?}"
    );
}

/// A ball lies on the deformed chair, a few millimeters deep at most, and is still there a second later.
fn assert_ball_rests(engine: &dyn Engine, place: fn(&App, Entity) -> Transform) {
    let mut lines = Vec::new();
    let mut tell = |line: &str| lines.push(line.to_string());
    let chair = flexible_chair::chair();
    let (mut app, scene, found) = flexible_chair::run(&chair, engine, Falling::Ball, &mut tell);
    found.save(&flexible_chair::name(engine, Falling::Ball));
    let deformation = app.world().get::<Deformation>(scene.chair).unwrap();
    let is_bent = deformation.q.iter().any(|q| q.abs() > 1e-4);
    assert!(is_bent, "{lines:?}");
    let before = place(&app, scene.fallen[0]).translation;
    let step = std::time::Duration::from_secs(1) / 64;
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    support::run_undrawn(&mut app, 64);
    let after = place(&app, scene.fallen[0]).translation;
    assert!(after.distance(before) < 0.02, "{after}: {lines:?}");
    let instance = app.world().get::<DeformedInstance>(scene.chair).unwrap();
    let triangles = oracle::deformed_triangles(&instance.instance.snapshot());
    let at = after.to_array().map(f64::from);
    let (_, distance) = oracle::closest(&triangles, at, 1.0).unwrap();
    let gap = distance - f64::from(HALF);
    // On the seat, and not beside the chair.
    assert!(gap.abs() < 0.005 && after.y > 0.45, "{gap}: {lines:?}");
}

/// The same scene of plain meshes: the chair that the processor deformed, and cubes at these places.
fn drawn_anew(
    app: &mut App,
    scene: &Scene,
    body: &Body,
    places: &[Transform],
) -> support::picture::Picture {
    let world = app.world_mut();
    for entity in scene.fallen.iter().chain([&scene.chair]) {
        world.despawn(*entity);
    }
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(deformed_mesh(body));
    let wood = support::material(world, flexible_chair::WOOD);
    world.spawn((Mesh3d(mesh), wood, body.at, NoFrustumCulling));
    for at in places {
        let look = support::solid(world, flexible_chair::cube(), flexible_chair::BLUE);
        world.spawn((look, *at));
    }
    support::settle(app);
    support::take(app)
}

#[cfg(feature = "avian")]
fn avian_place(app: &App, body: Entity) -> Transform {
    use avian3d::prelude::{Position, Rotation};
    let at = app.world().get::<Position>(body).unwrap();
    let turn = app.world().get::<Rotation>(body).unwrap();
    Transform::from_translation(at.0).with_rotation(turn.0)
}

#[cfg(feature = "avian")]
#[test]
fn boxes_rest_on_a_chair_under_avian() {
    assert_boxes_rest(&flexible_chair::avian::Avian, avian_place);
}

#[cfg(feature = "avian")]
#[test]
fn a_chair_stops_a_ball_under_avian() {
    assert_ball_rests(&flexible_chair::avian::Avian, avian_place);
}

#[cfg(feature = "rapier")]
fn rapier_place(app: &App, body: Entity) -> Transform {
    use bdtree_bevy::rapier::{RapierBody, RapierWorld};
    let own = app.world().get::<RapierBody>(body).unwrap();
    let world = &app.world().resource::<RapierWorld>().world;
    let at = world.bodies.get(own.body).unwrap().position();
    Transform::from_translation(at.translation).with_rotation(at.rotation)
}

#[cfg(feature = "rapier")]
#[test]
fn boxes_rest_on_a_chair_under_rapier() {
    assert_boxes_rest(&flexible_chair::rapier::Rapier, rapier_place);
}

#[cfg(feature = "rapier")]
#[test]
fn a_chair_stops_a_ball_under_rapier() {
    assert_ball_rests(&flexible_chair::rapier::Rapier, rapier_place);
}
