//! A pointer over a thousand animated characters.

use std::time::Instant;

use bdtree_bevy::bdtree_runtime::{Model, Ray, SkeletonPose};
use bdtree_bevy::{ClipPlayer, Deformation, DeformingQueries};
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemId;
use bevy_math::{Affine3A, Mat4, Quat, Vec3};
use bevy_time::Time;
use bevy_transform::components::Transform;

use crate::models;
use crate::world::{app, frames};

/// Characters, in a square.
const COUNT: usize = 1000;
const ROW: usize = 32;

/// The ray of the frame, how long it took (µs), and how often one has hit.
#[derive(Resource, Default)]
struct Hover {
    ray: Option<Ray>,
    took: f64,
    hit_count: usize,
    ray_count: usize,
}

fn cast(mut queries: DeformingQueries, mut hover: ResMut<Hover>) {
    let Some(ray) = hover.ray else {
        return;
    };
    let start = Instant::now();
    let hit = queries.cast_ray(&ray, |_| true);
    hover.took = 1e6 * start.elapsed().as_secs_f64();
    hover.hit_count += usize::from(hit.is_ok_and(|hit| hit.is_some()));
    hover.ray_count += 1;
}

/// Prints the rows of the table.
pub(crate) fn measure() {
    println!(
        "Hovering over {COUNT} animated characters, all of which change their pose in each frame (µs)\n"
    );
    println!("| characters | poses and boxes | ray | together | rays that hit |");
    println!("|---|---|---|---|---|");
    let ball = models::ball(40);
    row(
        "8 morph targets, 6 400 triangles",
        &ball,
        |app, entities, frame| morph(app, entities, 8, frame),
    );
    let face = models::face();
    row("52 morph targets, a face", &face, |app, entities, frame| {
        morph(app, entities, 52, frame)
    });
    let limb = models::limb();
    let poses = swinging(&limb);
    row("40 bones, matrices given", &limb, |app, entities, frame| {
        for (k, entity) in entities.iter().enumerate() {
            let mut deformation = deformation(app, *entity);
            deformation
                .joints
                .clone_from(&poses[(k + frame) % poses.len()]);
        }
    });
    row("40 bones, clips played", &limb, |app, entities, frame| {
        if frame == 0 {
            for (k, entity) in entities.iter().enumerate() {
                let time_s = k as f64 / COUNT as f64;
                let player = ClipPlayer {
                    time_s,
                    ..Default::default()
                };
                app.world_mut().entity_mut(*entity).insert(player);
            }
            app.init_resource::<Time>();
        }
        let step = std::time::Duration::from_millis(16);
        app.world_mut().resource_mut::<Time>().advance_by(step);
    });
    println!();
}

fn deformation(app: &mut App, entity: Entity) -> Mut<'_, Deformation> {
    let deformation = app.world_mut().get_mut::<Deformation>(entity);
    deformation.expect("a deformation")
}

/// Weights that go up and down, all of them other than 0.
fn morph(app: &mut App, entities: &[Entity], count: usize, frame: usize) {
    for (k, entity) in entities.iter().enumerate() {
        let mut deformation = deformation(app, *entity);
        deformation.q.resize(count, 0.0);
        for (j, q) in deformation.q.iter_mut().enumerate() {
            *q = 0.5 + 0.4 * (0.1 * frame as f32 + k as f32 + 0.7 * j as f32).sin();
        }
    }
}

/// Joints at some times of the clip.
fn swinging(model: &Model) -> Vec<Vec<Affine3A>> {
    let mut pose = SkeletonPose::new(model).expect("a skeleton");
    (0..61)
        .map(|k| {
            pose.play(0, k as f64 / 60.0).expect("a clip");
            let joints = pose.joints().iter().map(|joint| {
                let columns = bdtree_bevy::bdtree_runtime::joint::to_columns(joint);
                let columns = columns.map(|column| column.map(|x| x as f32));
                Affine3A::from_mat4(Mat4::from_cols_array_2d(&columns))
            });
            joints.collect()
        })
        .collect()
}

fn row(what: &str, model: &Model, mut pose: impl FnMut(&mut App, &[Entity], usize)) {
    // As large as the model, with gaps of a quarter.
    let mut at_rest = bdtree_bevy::bdtree_runtime::Instance::new(model).expect("an instance");
    at_rest
        .set_placement(bdtree_bevy::bdtree_runtime::Transform::IDENTITY)
        .expect("a place");
    let aabb = at_rest.aabb().expect("a box");
    let size = [0, 1, 2].map(|k| aabb.max[k] - aabb.min[k]);
    let gap = 1.25 * size[0].max(size[2]) as f32;
    let places = (0..COUNT).map(|k| {
        let (row, column) = (k / ROW, k % ROW);
        Transform {
            translation: Vec3::new(gap * column as f32, 0.0, gap * row as f32),
            rotation: Quat::from_rotation_y(k as f32),
            scale: Vec3::ONE,
        }
    });
    let (mut app, entities) = app(model, places);
    app.init_resource::<Hover>();
    let id: SystemId = app.world_mut().register_system(cast);
    // From above one side, as a camera looks, to a place among them.
    let width = f64::from(gap) * ROW as f64;
    let middle = 0.5 * (aabb.max[1] + aabb.min[1]);
    let eye = [0.5 * width, middle + 0.3 * width, -0.4 * width];
    let times = frames(
        &mut app,
        |app, frame| pose(app, &entities, frame),
        |app, frame| {
            let [u, v] = [0.618_034, 0.754_878].map(|step| (step * frame as f64).fract());
            let target = [u * width, middle, v * width];
            let direction = [0, 1, 2].map(|k| target[k] - eye[k]);
            app.world_mut().resource_mut::<Hover>().ray = Some(Ray::new(eye, direction));
            app.world_mut().run_system(id).expect("a system");
            app.world().resource::<Hover>().took
        },
    );
    let hover = app.world().resource::<Hover>();
    let share = 100 * hover.hit_count / hover.ray_count.max(1);
    let [poses, ray, both] = times;
    println!("| {what} | {poses:.0} | {ray:.1} | {both:.0} | {share} % |");
}
