//! Frustum culling never drops a mesh that is on screen: pictures with it are the pictures without it.

use bdtree_bevy::{Deformation, DeformingMesh};
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::Model;
use bevy_app::App;
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{NoFrustumCulling, ViewVisibility};
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;
use rand::RngExt;

use crate::drawing::{ORANGE, add_model, scene};
use crate::support::{self, material};

/// Random poses and cameras.
const ROUNDS: usize = 20;

fn models() -> Vec<Model> {
    let sphere = bake::bumpy_sphere(10, 5);
    let (face, shapes) = bake::face_with_shapes();
    let mut all = vec![
        bake::elastic("torus", 6, 8, &[]),
        bake::baked(&sphere, &bake::smooth_basis(&sphere, 5, 2)),
    ];
    // Vertices that morph targets move far beyond the box at rest.
    all.push(bake::baked(&face, &shapes));
    all
}

fn set_culled(app: &mut App, bodies: &[Entity], is_culled: bool) {
    for body in bodies {
        let mut body = app.world_mut().entity_mut(*body);
        if is_culled {
            body.remove::<NoFrustumCulling>();
        } else {
            body.insert(NoFrustumCulling);
        }
    }
}

#[test]
fn culling_drops_nothing_that_is_on_screen() {
    let mut app = scene(Vec3::new(0.0, 0.0, 8.0), Vec3::ZERO);
    let orange = material(app.world_mut(), ORANGE);
    let models = models();
    let mut rng = poses::rng(22);
    let mut bodies = Vec::new();
    for k in 0..18 {
        let handle = add_model(app.world_mut(), &models[k % models.len()]);
        bodies.push(
            app.world_mut()
                .spawn((DeformingMesh(handle), orange.clone()))
                .id(),
        );
    }
    let camera = app
        .world_mut()
        .query_filtered::<Entity, With<bevy_camera::Camera3d>>()
        .single(app.world())
        .unwrap();
    support::settle(&mut app);

    let mut dropped = 0;
    let mut shown = 0;
    let mut control = 0;
    for round in 0..ROUNDS {
        for (k, body) in bodies.iter().enumerate() {
            let model = &models[k % models.len()];
            let share = rng.random_range(0.05..0.6);
            let q = poses::random_q(model.asset(), share, &mut rng);
            let size = 1.0 / (poses::diagonal(model.asset()) * model.asset().unit());
            let at = Transform {
                translation: Vec3::from_array([0.0; 3].map(|_: f32| rng.random_range(-5.0..5.0))),
                rotation: Quat::from_array([0.0; 4].map(|_: f32| rng.random_range(-1.0..1.0)))
                    .normalize(),
                scale: Vec3::splat(rng.random_range(0.6..3.0) * size as f32),
            };
            let mut body = app.world_mut().entity_mut(*body);
            body.insert((
                at,
                Deformation {
                    q,
                    joints: Vec::new(),
                },
            ));
        }
        let eye = Vec3::from_array([0.0; 3].map(|_: f32| rng.random_range(-4.0..4.0)));
        let at = Vec3::from_array([0.0; 3].map(|_: f32| rng.random_range(-4.0..4.0)));
        app.world_mut()
            .entity_mut(camera)
            .insert(Transform::from_translation(eye).looking_at(at, Vec3::Y));
        set_culled(&mut app, &bodies, true);
        let culled = support::take_and(&mut app, |app| {
            for body in &bodies {
                let is_visible = app.world().get::<ViewVisibility>(*body).unwrap().get();
                dropped += usize::from(!is_visible);
                shown += usize::from(is_visible);
            }
        });
        set_culled(&mut app, &bodies, false);
        let all = support::take(&mut app);
        let off = culled.differing(&all, 0);
        if off > 0 {
            culled.save("visibility-culled");
            all.save("visibility-all");
        }
        assert_eq!(off, 0, "round {round}: {off} pixels differ");

        // The comparison sees what boxes that are too small would do.
        if round < 10 {
            set_culled(&mut app, &bodies, true);
            for body in &bodies {
                let mut small = app.world_mut().get_mut::<Aabb>(*body).unwrap();
                small.half_extents *= 0.2;
            }
            control += support::take(&mut app).differing(&all, 0);
        }
    }
    assert!(dropped > ROUNDS && shown > ROUNDS, "{dropped}, {shown}");
    assert!(control > 100, "{control} pixels differ with small boxes");
    println!("{ROUNDS} pictures: {shown} bodies shown, {dropped} dropped");
}
