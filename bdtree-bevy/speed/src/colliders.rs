//! A thousand deforming colliders, against ten meshes that are deformed and refitted on the CPU.

use std::hint::black_box;
use std::time::Instant;

use bdtree_bevy::bdtree_runtime::{Model, VertexId};
use bdtree_bevy::{Deformation, DeformingCollider, TouchingPairs};
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;
use parry3d::math::Vector;
use parry3d::shape::TriMesh;

use crate::models;
use crate::world::{FRAMES, app, frames, median};

/// Colliders of a side of the cube that they stand in.
const SIDE: usize = 10;
/// Meshes that are refitted.
const REFITTED: usize = 10;

/// Prints the rows of the table.
pub(crate) fn measure() {
    println!(
        "A frame with {} deforming colliders, all of which change their pose: poses, boxes and contacts with messages; \
         against {REFITTED} meshes of the same size that one thread deforms (p + U q in f32, 8 fields) and refits with \
         parry's TriMesh::update_vertices, asking nothing of them (µs)\n",
        SIDE * SIDE * SIDE
    );
    println!("| triangles of each | pairs that touch | ours | ten refitted | ratio |");
    println!("|---|---|---|---|---|");
    for (n, spacing) in [
        (40, 2.4),
        (40, 2.05),
        (80, 2.4),
        (80, 2.05),
        (160, 2.4),
        (160, 2.05),
    ] {
        row(&models::ball(n), spacing);
    }
    println!();
}

fn q(body: usize, frame: usize) -> [f32; 8] {
    std::array::from_fn(|j| 0.4 * (0.1 * frame as f32 + body as f32 + 0.7 * j as f32).sin())
}

fn row(model: &Model, spacing: f32) {
    let places = (0..SIDE * SIDE * SIDE).map(|k| {
        let cell = [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE].map(|c| c as f32);
        Transform {
            translation: spacing * Vec3::from_array(cell),
            rotation: Quat::from_rotation_y(k as f32),
            scale: Vec3::ONE,
        }
    });
    let (mut app, entities) = app(model, places);
    for entity in &entities {
        app.world_mut()
            .entity_mut(*entity)
            .insert(DeformingCollider::default());
    }
    let mut touching = 0;
    let [ours, ..] = frames(
        &mut app,
        |app, frame| {
            for (body, entity) in entities.iter().enumerate() {
                let mut deformation = app.world_mut().get_mut::<Deformation>(*entity);
                let deformation = deformation.as_mut().expect("a deformation");
                deformation.q.clear();
                deformation.q.extend_from_slice(&q(body, frame));
            }
        },
        |app, _| {
            touching += app.world().resource::<TouchingPairs>().iter().count();
            0.0
        },
    );
    let refitted = refitted(model);
    let triangles = model.asset().triangle_count();
    // Warm-up included.
    let touching = touching / (FRAMES + 50);
    let ratio = ours / refitted;
    println!("| {triangles} | {touching} | {ours:.0} | {refitted:.0} | {ratio:.2} |");
}

/// The median of what it takes to deform and refit ten meshes.
fn refitted(model: &Model) -> f64 {
    let asset = model.asset();
    let (count, modes) = (asset.vertex_count(), asset.mode_count());
    let unit = asset.unit() as f32;
    let rest: Vec<f32> = (0..count as u32)
        .flat_map(|v| asset.positions()[v as usize].map(|x| x * unit))
        .collect();
    let mut fields = vec![vec![0.0_f32; 3 * count]; modes];
    for v in 0..count {
        let displacements = asset.displacements(VertexId(v as u32)).expect("a vertex");
        for (mode, u) in displacements.iter() {
            for k in 0..3 {
                fields[mode][3 * v + k] = u[k] * unit;
            }
        }
    }
    let triangles: Vec<[u32; 3]> = asset.triangles().iter().map(|t| t.corners).collect();
    let corner = |x: &[f32]| Vector::new(x[0], x[1], x[2]);
    let vertices: Vec<Vector> = rest.chunks_exact(3).map(corner).collect();
    let mesh = || TriMesh::new(vertices.clone(), triangles.clone()).expect("a mesh");
    let mut meshes: Vec<TriMesh> = (0..REFITTED).map(|_| mesh()).collect();
    let mut deformed = rest.clone();
    let times = (0..FRAMES / 3).map(|frame| {
        let start = Instant::now();
        for (body, mesh) in meshes.iter_mut().enumerate() {
            deformed.copy_from_slice(&rest);
            for (field, q) in fields.iter().zip(q(body, frame)) {
                for (x, u) in deformed.iter_mut().zip(field) {
                    *x += q * u;
                }
            }
            mesh.update_vertices(|vertices| {
                for (own, x) in vertices.iter_mut().zip(deformed.chunks_exact(3)) {
                    *own = corner(x);
                }
            });
        }
        black_box(&meshes);
        1e6 * start.elapsed().as_secs_f64()
    });
    median(times.collect())
}
