//! Worlds of many deforming meshes, and how long their frames take.

use std::time::Instant;

use bdtree_bevy::bdtree_runtime::Model;
use bdtree_bevy::{BdtModel, BdtreePlugin, DeformingMesh};
use bevy_app::{App, PostUpdate, TaskPoolOptions, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets};
use bevy_ecs::prelude::*;
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;

/// Frames that are measured.
pub(crate) const FRAMES: usize = 300;
/// Frames before them.
const WARM_UP: usize = 50;

/// A world of one entity per place.
pub(crate) fn app(model: &Model, places: impl Iterator<Item = Transform>) -> (App, Vec<Entity>) {
    let mut app = App::new();
    let files = AssetPlugin {
        watch_for_changes_override: Some(false),
        ..Default::default()
    };
    // As many threads that compute as cores: by default Bevy keeps two of them for other tasks, which there are none of here.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut tasks = TaskPoolOptions::default();
    tasks.compute.min_threads = cores;
    let tasks = TaskPoolPlugin {
        task_pool_options: tasks,
    };
    app.add_plugins((tasks, files, TransformPlugin, BdtreePlugin));
    let mut models = app.world_mut().resource_mut::<Assets<BdtModel>>();
    let handle = models.add(BdtModel::from(model.clone()));
    let entities = places
        .map(|place| {
            let mesh = DeformingMesh(handle.clone());
            app.world_mut().spawn((mesh, place)).id()
        })
        .collect();
    app.finish();
    app.cleanup();
    app.update();
    app.update();
    (app, entities)
}

/// The medians, in microseconds, of what `PostUpdate` takes, in which all systems of the plugin are, and of what `then`
/// says it took, which runs after it; `before` runs first and is not measured.
pub(crate) fn frames(
    app: &mut App,
    mut before: impl FnMut(&mut App, usize),
    mut then: impl FnMut(&mut App, usize) -> f64,
) -> [f64; 3] {
    let mut times = [const { Vec::new() }; 3];
    for frame in 0..WARM_UP + FRAMES {
        before(app, frame);
        let start = Instant::now();
        app.world_mut().run_schedule(PostUpdate);
        let systems = 1e6 * start.elapsed().as_secs_f64();
        let rest = then(app, frame);
        app.world_mut().clear_trackers();
        if frame >= WARM_UP {
            times[0].push(systems);
            times[1].push(rest);
            times[2].push(systems + rest);
        }
    }
    times.map(median)
}

/// Of a few times.
pub(crate) fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
