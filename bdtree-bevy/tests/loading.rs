//! Files are loaded as assets.

use std::time::{Duration, Instant};

use bdtree_bevy::{BdtModel, BdtreePlugin, Deformation, DeformedInstance, DeformingMesh};
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, AssetServer};
use bevy_ecs::prelude::*;
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;

/// A program without a window whose files lie in a folder.
fn app(folder: &std::path::Path) -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin {
            file_path: folder.display().to_string(),
            ..Default::default()
        },
        TransformPlugin,
        BdtreePlugin,
    ));
    app
}

/// Runs frames until something is so, for 30 s at most.
fn run_until(app: &mut App, mut done: impl FnMut(&mut World) -> bool) {
    let start = Instant::now();
    while !done(app.world_mut()) {
        assert!(start.elapsed() < Duration::from_secs(30), "nothing in 30 s");
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_file_becomes_an_instance_at_the_pose_of_its_entity() {
    let folder = std::path::absolute("../fixtures/golden").unwrap();
    let mut app = app(&folder);
    let handle = app
        .world()
        .resource::<AssetServer>()
        .load::<BdtModel>("sphere.bdt");
    let entity = app
        .world_mut()
        .spawn((DeformingMesh(handle), Transform::from_xyz(1.0, 2.0, 3.0)))
        .id();
    run_until(&mut app, |world| {
        world.get::<DeformedInstance>(entity).is_some()
    });
    let modes = {
        let instance = &app
            .world()
            .get::<DeformedInstance>(entity)
            .unwrap()
            .instance;
        assert_eq!(instance.placement().translation, [1.0, 2.0, 3.0]);
        instance.q().len()
    };
    let mut q = vec![0.0; modes];
    q[0] = 0.05;
    app.world_mut().get_mut::<Deformation>(entity).unwrap().q = q.clone();
    app.update();
    let instance = &app
        .world()
        .get::<DeformedInstance>(entity)
        .unwrap()
        .instance;
    assert_eq!(instance.q(), q);
}
