//! A file that is baked anew while the program runs: the mesh that is drawn changes, and queries answer of the new one.
//!
//! ```text
//! cargo run --example hot_reload
//! ```
//!
//! writes `target/bevy/hot_reload_before.png` and `hot_reload.png`, with a dot where a ray from above meets the mesh. In a
//! program of yours, turn on Bevy's feature `file_watcher`; nothing else is needed.

use std::path::Path;

use bdtree_bevy::bdtree_runtime::Ray;
use bdtree_bevy::{
    BdtModel, BdtreePlugin, BdtreeSystems, DeformedInstance, DeformingMesh, DeformingQueries,
};
use bevy_app::{App, PostUpdate};
use bevy_asset::AssetServer;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

pub(crate) mod support;

use support::picture::Picture;

/// The meshes of the fixtures that the file holds one after the other.
pub(crate) const MESHES: [&str; 2] = ["icosphere", "torus"];

/// Keeps the file while the program runs.
#[derive(Resource)]
struct Folder(#[allow(dead_code)] tempfile::TempDir);

/// Marks where a ray from above meets the mesh.
#[derive(Component)]
pub(crate) struct Mark;

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    support::show_errors();
    let (_, [before, after]) = run()?;
    println!("{}", before.save("hot_reload_before").display());
    println!("{}", after.save("hot_reload").display());
    Ok(())
}

/// The program, and its pictures before and after the file changed.
pub(crate) fn run() -> std::io::Result<(App, [Picture; 2])> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("body.bdt");
    bake(&file, MESHES[0])?;
    let mut app = support::app(320, 240, folder.path());
    app.insert_resource(Folder(folder))
        .add_plugins(BdtreePlugin)
        // Where queries answer of this frame.
        .add_systems(PostUpdate, mark.after(BdtreeSystems::Bounds));
    support::start(&mut app);
    let files = app.world().resource::<AssetServer>();
    let mesh = files.load::<BdtModel>("body.bdt");
    let world = app.world_mut();
    support::camera(world, Vec3::new(0.0, 3.0, 3.5), Vec3::ZERO);
    support::sun(world, Vec3::new(1.0, 3.0, 1.5));
    let look = support::material(world, Color::srgb(0.75, 0.5, 0.3));
    world.spawn((DeformingMesh(mesh), look));
    let ball = bevy_shape::Sphere::new(0.05);
    let red = support::solid(world, ball, Color::srgb(0.8, 0.1, 0.1));
    world.spawn((red, Mark, Transform::default()));

    support::run_until(&mut app, |app| !triangle_counts(app).is_empty());
    let before = picture(&mut app);
    let old = triangle_counts(&mut app);
    bake(&file, MESHES[1])?;
    support::run_until(&mut app, |app| triangle_counts(app) != old);
    let after = picture(&mut app);
    Ok((app, [before, after]))
}

/// A picture once everything is drawn.
fn picture(app: &mut App) -> Picture {
    support::settle(app);
    support::take(app)
}

/// Writes the file of a mesh of the fixtures, as a bake beside a running game does.
fn bake(file: &Path, mesh: &str) -> std::io::Result<()> {
    let model = bdtree_fixtures::bake::elastic(mesh, 4, 8, &[]);
    std::fs::write(file, model.asset().bytes())
}

/// The size of each mesh that is there.
fn triangle_counts(app: &mut App) -> Vec<usize> {
    let world = app.world_mut();
    let mut bodies = world.query::<&DeformedInstance>();
    let size = |body: &DeformedInstance| body.instance.model().asset().triangle_count();
    bodies.iter(world).map(size).collect()
}

/// Puts the dot where a ray from above meets the mesh; where none does it stays.
fn mark(mut queries: DeformingQueries, mut marks: Query<&mut Transform, With<Mark>>) -> Result {
    let down = Ray::new([0.8, 100.0, 0.1], [0.0, -1.0, 0.0]);
    if let Some(hit) = queries.cast_ray(&down, |_| true)? {
        for mut mark in &mut marks {
            mark.translation = hit.position();
        }
    }
    Ok(())
}
