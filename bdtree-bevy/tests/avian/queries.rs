//! Questions about the world beside brute force over all colliders.

use avian3d::parry::math::Pose3 as Pose;
use avian3d::parry::query::{QueryDispatcher, Ray, ShapeCastOptions};
use avian3d::parry::shape::SharedShape;
use avian3d::prelude::*;
use bdtree_bevy::Deformation;
use bdtree_bevy::avian::{BdtCollider, BdtSpatialQuery};
use bdtree_fixtures::poses;
use bdtree_parry::MeshDispatcher;
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use bevy_math::{Dir3, Quat, Vec3};
use bevy_transform::components::Transform;
use rand::RngExt;

use super::{parry_shapes, support};

/// What the tests know of a collider.
struct Known {
    entity: Entity,
    pose: Pose,
    shape: SharedShape,
    layers: CollisionLayers,
}

fn transform(pose: &Pose) -> Transform {
    Transform::from_translation(pose.translation).with_rotation(pose.rotation)
}

/// Rigid shapes and meshes at random poses, of two layers, resting in the air.
fn world() -> (App, Vec<Known>) {
    let mut app = support::app();
    let mut rng = poses::rng(9);
    let model = parry_shapes::bumpy();
    let asset = support::add(&mut app, model.model());
    let mut known = Vec::new();
    let kinds = [
        "ball", "cuboid", "capsule", "compound", "tri_mesh", "voxels",
    ];
    for k in 0..40 {
        let pose = parry_shapes::pose(6.0, &mut rng);
        let layers = CollisionLayers::from_bits(1 << (k % 2), u32::MAX);
        let body = [RigidBody::Static, RigidBody::Kinematic][k / 2 % 2];
        let more = (body, layers, transform(&pose));
        if k % 4 == 3 {
            let shape = parry_shapes::shape(kinds[k / 4 % kinds.len()]);
            let collider = Collider::from(shape.clone());
            let entity = app.world_mut().spawn((collider, more)).id();
            known.push(Known {
                entity,
                pose,
                shape,
                layers,
            });
        } else {
            let scale = 0.5 + 0.1 * (k % 5) as f32;
            let mesh = parry_shapes::mesh(model, &mut rng);
            let deformation = Deformation {
                q: mesh.q().to_vec(),
                ..Deformation::default()
            };
            let more = (
                body,
                layers,
                transform(&pose).with_scale(Vec3::splat(scale)),
            );
            let entity = support::mesh_body(&mut app, asset.clone(), (deformation, more));
            let scaled = model.scaled(f64::from(scale)).expect("a scale");
            let mesh = bdtree_parry::DeformingMesh::new(&scaled, mesh.q()).expect("a mesh");
            known.push(Known {
                entity,
                pose,
                shape: SharedShape::new(mesh),
                layers,
            });
        }
    }
    support::steps(&mut app, 2);
    (app, known)
}

fn filters(known: &[Known]) -> [SpatialQueryFilter; 3] {
    [
        SpatialQueryFilter::default(),
        SpatialQueryFilter::from_mask(LayerMask(2)),
        SpatialQueryFilter::from_excluded_entities(known.iter().step_by(3).map(|one| one.entity)),
    ]
}

fn sorted(mut entities: Vec<Entity>) -> Vec<Entity> {
    entities.sort();
    entities
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() < 2e-4 * (1.0 + a.abs())
}

fn same(own: &[(Entity, f32)], expected: &[(Entity, f32)]) -> bool {
    let each = || own.iter().zip(expected);
    own.len() == expected.len() && each().all(|(a, b)| a.0 == b.0 && near(a.1, b.1))
}

#[test]
fn answers_are_those_of_all_colliders() {
    let (mut app, known) = world();
    let mut state = SystemState::<BdtSpatialQuery>::new(app.world_mut());
    let query = state.get(app.world()).expect("a query");
    let mut rng = poses::rng(10);
    let dispatcher = MeshDispatcher::new();
    let (mut rays, mut casts, mut touching, mut inside, mut boxes) = (0, 0, 0, 0, 0);
    for round in 0..900 {
        let filter = &filters(&known)[round % 3];
        let all = || {
            known
                .iter()
                .filter(|one| filter.test(one.entity, one.layers))
        };
        let what = format!("round {round}");

        // Rays.
        let at = parry_shapes::pose(7.0, &mut rng);
        let origin = at.translation;
        let direction = Dir3::new(at.rotation * Vec3::X).expect("a direction");
        let limit = rng.random_range(1.0..12.0);
        let ray = Ray::new(origin, direction.into());
        let mut expected: Vec<(Entity, f32)> = all()
            .filter_map(|one| {
                let hit = one.shape.cast_ray(&one.pose, &ray, limit, true)?;
                Some((one.entity, hit))
            })
            .collect();
        expected.sort_by(|a, b| a.1.total_cmp(&b.1));
        let first = query.cast_ray(origin, direction, limit, true, filter);
        let own = first.map(|hit| (hit.entity, hit.distance));
        assert!(
            same(own.as_slice(), &expected[..expected.len().min(1)]),
            "{what}"
        );
        let hits = query.ray_hits(origin, direction, limit, true, filter);
        let mut hits: Vec<_> = hits.iter().map(|hit| (hit.entity, hit.distance)).collect();
        hits.sort_by(|a, b| a.1.total_cmp(&b.1));
        assert!(same(&hits, &expected), "{what}: {hits:?}, {expected:?}");
        rays += expected.len();

        // Shapes that move.
        let kind = ["ball", "cuboid", "capsule", "cone"][round % 4];
        let (shape, rotation) = (parry_shapes::shape(kind), at.rotation);
        let collider = BdtCollider::from(shape.clone());
        let config = ShapeCastConfig::from_max_distance(limit);
        let options = ShapeCastOptions {
            max_time_of_impact: limit,
            ..ShapeCastOptions::default()
        };
        let mut expected: Vec<(Entity, f32)> = all()
            .filter_map(|one| {
                let pos12 = one.pose.inv_mul(&at);
                let velocity = one.pose.rotation.inverse() * Vec3::from(direction);
                let found = dispatcher.cast_shapes(&pos12, velocity, &*one.shape, &*shape, options);
                Some((one.entity, found.ok()??.time_of_impact))
            })
            .collect();
        expected.sort_by(|a, b| a.1.total_cmp(&b.1));
        let first = query.cast_shape(&collider, origin, rotation, direction, &config, filter);
        assert_eq!(first.is_some(), !expected.is_empty(), "{what}");
        if let Some(hit) = first {
            assert!(
                near(hit.distance, expected[0].1),
                "{what}: {hit:?}, {expected:?}"
            );
            casts += 1;
        }
        let hits = query.shape_hits(&collider, origin, rotation, direction, &config, filter);
        let own = sorted(hits.iter().map(|hit| hit.entity).collect());
        let expected = sorted(expected.iter().map(|hit| hit.0).collect());
        assert_eq!(own, expected, "{what}");

        // Shapes that stand.
        let expected = all().filter(|one| {
            let pos12 = one.pose.inv_mul(&at);
            let found = dispatcher.intersection_test(&pos12, &*one.shape, &*shape);
            found.is_ok_and(|found| found.intersecting)
        });
        let expected = sorted(expected.map(|one| one.entity).collect());
        let own = query.shape_intersections(&collider, origin, rotation, filter);
        assert_eq!(sorted(own), expected, "{what}");
        touching += expected.len();

        // Points: half of them in the middle of a collider.
        let point = match round % 2 {
            0 => origin,
            _ => known[rng.random_range(0..known.len())].pose.translation,
        };
        let expected = all()
            .map(|one| one.shape.project_point(&one.pose, point, true))
            .map(|found| found.point.distance(point))
            .fold(f32::INFINITY, f32::min);
        let own = query.project_point(point, true, filter).expect("a point");
        assert!(near(own.point.distance(point), expected), "{what}: {own:?}");
        let expected = all().filter(|one| one.shape.contains_point(&one.pose, point));
        let expected = sorted(expected.map(|one| one.entity).collect());
        assert_eq!(
            sorted(query.point_intersections(point, filter)),
            expected,
            "{what}"
        );
        inside += expected.len();

        // Boxes: avian's are loosened by the tolerance of contacts.
        let around = ColliderAabb::new(origin, Vec3::splat(0.8));
        let own = query.aabb_intersections(around, filter);
        for one in all() {
            let tight = one.shape.compute_aabb(&one.pose);
            let tight = ColliderAabb::from_min_max(tight.mins, tight.maxs);
            let loose = tight.grow(Vec3::splat(0.03));
            let is_there = own.contains(&one.entity);
            assert!(is_there || !tight.intersects(&around), "{what}");
            assert!(!is_there || loose.intersects(&around), "{what}");
        }
        boxes += own.len();
    }
    let counts = [rays, casts, touching, inside, boxes];
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
}

/// `Quat` of the transform is that of the answer: a mesh that was turned is hit where it stands.
#[test]
fn a_turned_mesh_is_hit_where_it_stands() {
    let mut app = support::app();
    let model = parry_shapes::bumpy();
    let asset = support::add(&mut app, model.model());
    let turn = Quat::from_rotation_z(0.7);
    let at = Transform::from_xyz(5.0, 0.0, 0.0).with_rotation(turn);
    let entity = support::mesh_body(&mut app, asset, (RigidBody::Static, at));
    support::steps(&mut app, 2);
    let mut state = SystemState::<BdtSpatialQuery>::new(app.world_mut());
    let query = state.get(app.world()).expect("a query");
    let filter = SpatialQueryFilter::default();
    let hit = query
        .cast_ray(Vec3::ZERO, Dir3::X, 10.0, true, &filter)
        .expect("a hit");
    assert_eq!(hit.entity, entity);
    let mesh = (app.world().get::<BdtCollider>(entity))
        .and_then(BdtCollider::mesh)
        .expect("a mesh");
    let inverse = turn.inverse();
    let ray = Ray::new(inverse * Vec3::new(-5.0, 0.0, 0.0), inverse * Vec3::X);
    use avian3d::parry::query::RayCast;
    let expected = mesh.cast_local_ray(&ray, 10.0, true).expect("a hit");
    assert!((hit.distance - expected).abs() < 1e-5);
    assert!(hit.normal.x < 0.0, "{:?}", hit.normal);
}
