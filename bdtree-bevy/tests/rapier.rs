//! A world of rapier in Bevy.

use std::time::Duration;

use bdtree_bevy::rapier::{RapierBody, RapierFlexible, RapierPlugin, RapierWorld};
use bdtree_bevy::{BdtModel, BdtreePlugin, Deformation, DeformingMesh};
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use rapier3d::prelude::*;

use crate::chair::chair;

/// A program without a window, one step per update, a floor.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        TransformPlugin,
        AssetPlugin::default(),
        BdtreePlugin,
        RapierPlugin::default(),
    ))
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
        1.0 / 64.0,
    )));
    let floor = ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::new(0.0, -0.5, 0.0));
    let mut world = app.world_mut().resource_mut::<RapierWorld>();
    world.world.insert_collider(floor, None);
    app.update();
    app
}

#[test]
fn a_chair_stops_a_ball_and_writes_back() {
    let mut app = app();
    let asset =
        (app.world_mut().resource_mut::<Assets<BdtModel>>()).add(BdtModel::from(chair().clone()));
    let at = Transform::from_xyz(0.0, 0.02, 0.0);
    let body = (DeformingMesh(asset), RapierFlexible::default(), at);
    let chair = app.world_mut().spawn(body).id();
    let (ball, _) = (app.world_mut().resource_mut::<RapierWorld>())
        .world
        .insert(
            RigidBodyBuilder::dynamic()
                .translation(Vector::new(0.0, 1.0, 0.0))
                .angular_damping(2.0),
            ColliderBuilder::ball(0.1).mass(3.0).friction(0.8),
        );
    let ball = app.world_mut().spawn(RapierBody::from(ball)).id();
    let mut largest = 0.0_f32;
    for _ in 0..64 * 4 {
        app.update();
        let q = &app.world().get::<Deformation>(chair).expect("a mesh").q;
        largest = q.iter().fold(largest, |most, q| most.max(q.abs()));
    }
    assert!(largest > 0.0, "contacts moved q");
    let height = (app.world().get::<Transform>(ball).expect("a body"))
        .translation
        .y;
    assert!((0.48..0.56).contains(&height), "{height}");
    let own = *app.world().get::<RapierBody>(chair).expect("a body");
    let world = app.world().resource::<RapierWorld>();
    let q = world.flexible.q(own.flexible.expect("modes")).expect("q");
    assert_eq!(app.world().get::<Deformation>(chair).expect("a mesh").q, q);

    // Without the entity there is no body.
    app.world_mut().entity_mut(chair).despawn();
    let world = app.world().resource::<RapierWorld>();
    assert!(world.world.bodies.get(own.body).is_none());
    assert!(world.flexible.q(own.flexible.expect("modes")).is_none());
    for _ in 0..64 {
        app.update();
    }
    let height = (app.world().get::<Transform>(ball).expect("a body"))
        .translation
        .y;
    assert!(height < 0.3, "the ball falls: {height}");
}

/// The page shows what the module's documentation compiles and runs.
#[test]
fn the_page_shows_the_module() {
    let page = std::fs::read_to_string("../docs/guide/rapier.md").expect("the page");
    let (_, rest) = page.split_once("```rust,ignore\n").expect("the program");
    let (program, _) = rest.split_once("```").expect("its end");
    let module = std::fs::read_to_string("src/rapier.rs").expect("the module");
    let lines = module.lines().filter_map(|line| line.strip_prefix("//!"));
    let shown: Vec<&str> = (lines.map(|line| line.strip_prefix(' ').unwrap_or(line)))
        .filter(|line| !line.starts_with("# "))
        .collect();
    assert!(shown.join("\n").contains(program.trim_end()));
}
