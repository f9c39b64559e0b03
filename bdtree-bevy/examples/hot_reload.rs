//! A file that is baked anew while the program runs: the mesh of its entity changes, and queries answer of the new one.
//!
//! `cargo run --example hot_reload`, in `bdtree-bevy`. It needs no window: it writes a file, casts a ray at it, writes another
//! one over it and casts the ray again. In a program of yours, turn on Bevy's feature `file_watcher`; nothing else is needed.

use std::path::Path;
use std::time::{Duration, Instant};

use bdtree_bevy::bdtree_runtime::Ray;
use bdtree_bevy::{BdtModel, BdtreePlugin, DeformedInstance, DeformingMesh, DeformingQueries};
use bevy_app::{App, AppExit, ScheduleRunnerPlugin, Startup, TaskPoolPlugin, Update};
use bevy_asset::{AssetPlugin, AssetServer};
use bevy_ecs::prelude::*;
use bevy_log::LogPlugin;
use bevy_transform::TransformPlugin;

/// Where the file lies, when the program began, and what has been seen.
#[derive(Resource)]
struct Bench {
    file: std::path::PathBuf,
    start: Instant,
    /// Heights at which the ray met the mesh, one per file.
    heights: Vec<f64>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("body.bdt");
    bake(&file, "icosphere")?;
    let mut app = App::new();
    app.add_plugins((
        ScheduleRunnerPlugin::run_loop(Duration::from_millis(5)),
        LogPlugin::default(),
        TaskPoolPlugin::default(),
        AssetPlugin {
            file_path: folder.path().display().to_string(),
            ..Default::default()
        },
        TransformPlugin,
        BdtreePlugin,
    ))
    .insert_resource(Bench {
        file,
        start: Instant::now(),
        heights: Vec::new(),
    })
    .add_systems(Startup, spawn)
    .add_systems(Update, look);
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(_) => Err("the change did not arrive within 30 s".into()),
    }
}

/// Writes the file of a mesh of the fixtures, as a bake beside a running game does.
fn bake(file: &Path, mesh: &str) -> std::io::Result<()> {
    let model = bdtree_fixtures::bake::elastic(mesh, 4, 8, &[]);
    std::fs::write(file, model.asset().bytes())
}

fn spawn(mut commands: Commands, files: Res<AssetServer>) {
    let model = files.load::<BdtModel>("body.bdt");
    commands.spawn(DeformingMesh(model));
}

/// Casts a ray from above whenever the model has changed; changes the file once.
fn look(
    changed: Query<&DeformedInstance, Changed<DeformedInstance>>,
    mut queries: DeformingQueries,
    mut bench: ResMut<Bench>,
    mut exit: MessageWriter<AppExit>,
) {
    if bench.start.elapsed() > Duration::from_secs(30) {
        exit.write(AppExit::error());
    }
    let Ok(body) = changed.single() else {
        return;
    };
    let triangles = body.instance.model().asset().triangle_count();
    let down = Ray::new([0.01, 100.0, 0.02], [0.0, -1.0, 0.0]);
    match queries.cast_ray(&down, |_| true) {
        Ok(Some(hit)) => {
            println!(
                "{triangles} triangles; the ray meets the top at {:.3}",
                hit.point[1]
            );
            bench.heights.push(hit.point[1]);
        }
        Ok(None) => println!("{triangles} triangles; the ray meets nothing"),
        Err(why) => eprintln!("{why}"),
    }
    match bench.heights.len() {
        1 => {
            println!("the file changes");
            if let Err(why) = bake(&bench.file, "cube") {
                eprintln!("{}: {why}", bench.file.display());
                exit.write(AppExit::error());
            }
        }
        2 => {
            exit.write(AppExit::Success);
        }
        _ => {}
    }
}
