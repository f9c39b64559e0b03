//! Contacts with voxels: out of their union, through faces that nothing covers.

use std::collections::HashSet;

use bdtree_fixtures::poses;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::brute::{Surface, elements};
use super::ours::{DeformingMesh, FlexibleBodies, FlexibleOptions, MeshDispatcher};
use super::parry::math::{IVector, Pose, Real, Vector};
use super::parry::query::{ContactManifold, PersistentQueryDispatcher};
use super::parry::shape::{Cuboid, Shape, SharedShape, Voxels};
use super::rapier::prelude::{
    ColliderBuilder, NarrowPhase, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};
use super::support;

const PREDICTION: Real = 0.05;

/// A contact in the frame of the shape that is no mesh: its point there and the mesh's, and the direction out of it.
#[derive(Debug, Clone, Copy)]
struct Found {
    point: Vector,
    of_mesh: Vector,
    normal: Vector,
    dist: Real,
}

/// All contacts of a mesh that stands at `pos` in the frame of another shape.
fn contacts(mesh: &DeformingMesh, pos: &Pose, other: &dyn Shape, is_swapped: bool) -> Vec<Found> {
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let (pos12, one, two): (Pose, &dyn Shape, &dyn Shape) = match is_swapped {
        false => (*pos, other, mesh),
        true => (pos.inverse(), mesh, other),
    };
    MeshDispatcher::new()
        .contact_manifolds(&pos12, one, two, PREDICTION, &mut manifolds, &mut None)
        .expect("manifolds");
    let found = manifolds.iter().flat_map(|manifold| {
        manifold.points.iter().map(move |point| {
            let (normal, own, of_mesh) = match is_swapped {
                false => (manifold.local_n1, point.local_p1, point.local_p2),
                true => (manifold.local_n2, point.local_p2, point.local_p1),
            };
            Found {
                point: own,
                of_mesh: *pos * of_mesh,
                normal,
                dist: point.dist,
            }
        })
    });
    found.collect()
}

fn voxels(size: Vector, cells: &[[i32; 3]]) -> Voxels {
    let cells: Vec<IVector> = cells
        .iter()
        .map(|cell| IVector::from_array(cell.map(Into::into)))
        .collect();
    Voxels::new(size, &cells)
}

/// A slab of two layers, whose top is at y = 0, and the box that it fills.
fn slab(cells: i32, size: Vector) -> (Voxels, SharedShape, Vector) {
    let mut all = Vec::new();
    for x in -cells..cells {
        for z in -cells..cells {
            all.extend([[x, -1, z], [x, -2, z]]);
        }
    }
    let half = size * Vector::new(cells as Real, 1.0, cells as Real);
    let center = Vector::new(0.0, -half.y, 0.0);
    (
        voxels(size, &all),
        SharedShape::new(Cuboid::new(half)),
        center,
    )
}

/// The lowest point of a mesh at a rotation.
fn lowest(mesh: &DeformingMesh, turn: &Pose) -> Real {
    let heights = Surface::of(mesh).triangles.into_iter().flat_map(|t| {
        let corners: [Vector; 3] = t.vertices().map(|v| *turn * v);
        corners.map(|at| at.y)
    });
    heights.fold(Real::INFINITY, Real::min)
}

#[test]
fn a_floor_of_voxels_pushes_as_one_box() {
    let mut rng = poses::rng(43);
    let (floor, slab, center) = slab(30, support::vector([0.11, 0.13, 0.09]));
    let mut points = 0;
    for round in 0..12 {
        let mesh = support::mesh(support::bumpy(), &mut rng);
        let mut pos = support::pose(0.5, &mut rng);
        pos.translation.y = 0.0;
        // From somewhat above the floor to nearly a voxel deep.
        pos.translation.y = rng.random_range(-0.1..0.04) - lowest(&mesh, &pos);
        for is_swapped in [false, true] {
            let found = contacts(&mesh, &pos, &floor, is_swapped);
            let in_slab = Pose::from_translation(-center) * pos;
            let expected = contacts(&mesh, &in_slab, &*slab, is_swapped);
            // Triangles next to an edge of the mesh tilt normals, on a box as well.
            for at in &found {
                let is_known = expected
                    .iter()
                    .any(|box_| box_.normal.dot(at.normal) > 0.98);
                assert!(
                    at.normal.y > 0.7 && is_known,
                    "{round}: {at:?}, {expected:?}"
                );
            }
            assert!(
                found.iter().all(|at| at.point.y.abs() < 1e-4),
                "{round}: {found:?}"
            );
            let deepest = |of: &[Found]| of.iter().map(|at| at.dist).fold(1.0, Real::min);
            assert!(
                (deepest(&found) - deepest(&expected)).abs() < 1e-5,
                "{round}: {found:?}, {expected:?}"
            );
            points += found.len();
        }
    }
    assert!(points > 40, "{points}");
}

/// Random voxels, and which cells they are.
fn heap(size: Vector, rng: &mut Pcg64Mcg) -> (Voxels, HashSet<[i32; 3]>) {
    let mut cells = HashSet::new();
    for x in -5..5 {
        for z in -5..5 {
            for y in -4..rng.random_range(-2..2) {
                cells.insert([x, y, z]);
            }
        }
    }
    let mut sorted: Vec<[i32; 3]> = cells.iter().copied().collect();
    sorted.sort_unstable();
    (voxels(size, &sorted), cells)
}

fn cell_of(point: Vector, size: Vector) -> [i32; 3] {
    (point / size).floor().to_array().map(|x| x as i32)
}

/// Each point lies on an open face, pushes out of it, and is as deep as it says; where mesh and voxels are apart, the nearest
/// points are there.
#[test]
fn contacts_push_out_of_open_faces() {
    let mut rng = poses::rng(47);
    let size = support::vector([0.2, 0.15, 0.25]);
    let (mut apart, mut within) = (0, 0);
    for round in 0..16 {
        let (shape, cells) = heap(size, &mut rng);
        let mesh = support::mesh(support::bumpy(), &mut rng);
        let mut pos = support::pose(0.4, &mut rng);
        let top = Vector::new(0.0, 2.0 * size.y, 0.0);
        pos.translation.y = 0.0;
        let low = lowest(&mesh, &pos);
        pos.translation.y = top.y - low - rng.random_range(-0.03..0.3);
        let shared = SharedShape::new(shape.clone());
        let distance = Surface::of(&mesh)
            .distance(&elements(&shared), &pos.inverse(), false)
            .expect("a distance");
        for is_swapped in [false, true] {
            let found = contacts(&mesh, &pos, &shape, is_swapped);
            for at in &found {
                let normal = at.normal;
                // Through which kind of face: triangles next to an edge of the mesh tilt normals.
                let axis = Vector::AXES.into_iter().flat_map(|axis| [axis, -axis]);
                let axis = axis.max_by(|a, b| a.dot(normal).total_cmp(&b.dot(normal)));
                let step = axis.expect("an axis") * 0.01;
                let is_filled = |p: Vector| cells.contains(&cell_of(p, size));
                assert!(
                    around(at.point - step).into_iter().any(is_filled),
                    "{round}: {at:?} is on no voxel"
                );
                assert!(
                    !around(at.point + step).into_iter().all(is_filled),
                    "{round}: {at:?} is covered"
                );
                let along = (at.of_mesh - at.point).dot(normal);
                // parry takes distances before it tilts normals.
                assert!((along - at.dist).abs() < 1e-3, "{round}: {at:?}, {along}");
            }
            if distance > 1e-4 && distance < PREDICTION - 1e-4 {
                apart += 1;
                let nearest = found.iter().map(|at| at.dist).fold(1.0, Real::min);
                assert!(
                    (nearest - distance).abs() < 1e-4,
                    "{round}: {nearest}, {distance}"
                );
            } else if distance == 0.0 {
                within += 1;
                assert!(found.iter().any(|at| at.dist < 0.0), "{round}: {found:?}");
            }
        }
    }
    assert!(apart >= 2 && within >= 10, "{apart}, {within}");
}

/// Points about a point, so that one on the border of cells is in each of them.
fn around(at: Vector) -> Vec<Vector> {
    let sides = [-1e-3, 1e-3];
    let mut all = Vec::new();
    for x in sides {
        for y in sides {
            all.extend(sides.map(|z| at + support::vector([x, y, z])));
        }
    }
    all
}

/// A body slides over a floor without friction: how fast it is after a second, and how far it sank or rose.
fn slide(floor: ColliderBuilder, top: Real) -> (Vector, Real) {
    let mut world = PhysicsWorld::new();
    world.narrow_phase = NarrowPhase::with_query_dispatcher(MeshDispatcher::new());
    world.insert_collider(
        floor.translation(Vector::new(0.0, top, 0.0)).friction(0.0),
        None,
    );
    let mut flexible = FlexibleBodies::new();
    let model = bdtree_parry::DeformingModel::new(crate::flexible::chair(), 1.0).expect("a model");
    let options = FlexibleOptions {
        friction: 0.0,
        is_deformable: false,
        ..FlexibleOptions::default()
    };
    let frame = RigidBodyBuilder::dynamic()
        .translation(Vector::new(-1.0, 0.002, 0.0))
        .linvel(Vector::new(1.5, 0.0, 0.2));
    let (bodies, colliders) = (&mut world.bodies, &mut world.colliders);
    let (chair, _): (RigidBodyHandle, _) = flexible
        .insert(&model, &options, frame, bodies, colliders)
        .expect("a body");
    for _ in 0..90 {
        flexible.step(&mut world).expect("a step");
    }
    let body = &world.bodies[chair];
    (body.linvel(), body.translation().y)
}

#[test]
fn a_chair_slides_over_voxels_as_over_a_box() {
    let size = support::vector([0.1, 0.1, 0.1]);
    let (floor, _, _) = slab(30, size);
    let on_box = slide(ColliderBuilder::cuboid(3.0, 0.1, 3.0), -0.1);
    let on_voxels = slide(ColliderBuilder::new(SharedShape::new(floor)), 0.0);
    println!("{on_box:?}, {on_voxels:?}");
    // Its feet lose some speed on a box as well, where triangles next to edges of the mesh tilt normals.
    assert!(on_box.0.x > 1.2, "{on_box:?}");
    assert!(
        on_voxels.0.x > 0.85 * on_box.0.x,
        "{on_voxels:?}, {on_box:?}"
    );
    assert!(on_voxels.1.abs() < 0.002, "{on_voxels:?}");
}
