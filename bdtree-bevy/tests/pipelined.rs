//! With Bevy's pipelined rendering, which draws a frame while the next one runs, pictures are those without it.

use bdtree_bevy::{BdtModel, Deformation, DeformingMesh};
use bdtree_fixtures::bake;
use bdtree_runtime::Model;
use bevy_app::App;
use bevy_asset::{AssetId, Assets};
use bevy_math::Vec3;
use bevy_render::RenderApp;
use bevy_render::pipelined_rendering::PipelinedRenderingPlugin;

use crate::drawing::{ORANGE, add_model, scene_with};
use crate::support::{self, material, picture::Picture};

fn sphere(n: u32) -> Model {
    let mesh = bake::bumpy_sphere(n, 7);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 3))
}

/// A mesh in changing poses, then as another file, then gone.
fn pictures(add: impl FnOnce(&mut App)) -> (App, Vec<Picture>) {
    let mut app = scene_with(Vec3::new(0.0, 2.0, 3.0), Vec3::ZERO, add);
    let handle = add_model(app.world_mut(), &sphere(12));
    let id: AssetId<BdtModel> = handle.id();
    let orange = material(app.world_mut(), ORANGE);
    let body = app.world_mut().spawn((DeformingMesh(handle), orange)).id();
    let mut all = Vec::new();
    let mut take = |app: &mut App| {
        // Frames in which nothing changes, as many as meshes and shaders may need.
        for _ in 0..2 {
            app.update();
        }
        all.push(support::take(app));
    };
    for pose in [1.0, -1.3] {
        // A pose each frame, the last of which stays.
        for step in 1..=3 {
            let q = [1.0, -3.0, 2.0, 1.5].map(|q| q * pose * step as f32 / 3.0);
            app.world_mut().get_mut::<Deformation>(body).unwrap().q = q.to_vec();
            app.update();
        }
        take(&mut app);
    }
    let mut models = app.world_mut().resource_mut::<Assets<BdtModel>>();
    models.insert(id, sphere(20).into()).unwrap();
    take(&mut app);
    app.world_mut().despawn(body);
    take(&mut app);
    (app, all)
}

#[test]
fn pipelined_rendering_draws_the_same() {
    let (app, expected) = pictures(|_| {});
    assert!(app.get_sub_app(RenderApp).is_some());
    drop(app);
    let (app, found) = pictures(|app| {
        app.add_plugins(PipelinedRenderingPlugin);
    });
    // The renderer is in its own thread.
    assert!(app.get_sub_app(RenderApp).is_none());
    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let off = found.differing(expected, 0);
        if off > 0 {
            found.save("pipelined-found");
            expected.save("pipelined-expected");
        }
        assert_eq!(off, 0, "picture {k}");
    }
    // Each is another.
    for pair in found.windows(2) {
        assert!(pair[0].differing(&pair[1], 3) > 200);
    }
}
