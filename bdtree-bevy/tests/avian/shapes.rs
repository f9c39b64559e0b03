//! Every shape of parry with a deforming mesh as colliders of avian, in both orders: no contact is lost.

use avian3d::collision::collider::SimpleCollider;
use avian3d::parry::math::Pose3 as Pose;
use avian3d::parry::query::PointQuery;
use avian3d::prelude::*;
use bdtree_bevy::avian::BdtCollider;
use bdtree_fixtures::poses;
use bevy_math::{Quat, Vec3};
use rand::RngExt;

use super::brute::{Surface, elements};
use super::parry_shapes;

/// How far from a surface contacts are predicted.
const PREDICTION: f32 = 0.1;

/// What `BdtCollider` finds, both colliders standing somewhere in the world.
fn found(one: (&BdtCollider, Pose), two: (&BdtCollider, Pose)) -> Vec<ContactManifold> {
    let mut manifolds = Vec::new();
    let ((one, at), (two, other)) = (one, two);
    one.contact_manifolds(
        two,
        at.translation,
        at.rotation,
        other.translation,
        other.rotation,
        PREDICTION,
        &mut manifolds,
    );
    manifolds
}

fn check(kind: &str) {
    let shape = parry_shapes::shape(kind);
    let others = elements(&shape);
    let other = BdtCollider::from(shape.clone());
    let mut rng = poses::rng(23);
    let (mut touching, mut apart) = (0, 0);
    for round in 0..24 {
        let mesh = parry_shapes::mesh(parry_shapes::bumpy(), &mut rng);
        let surface = Surface::of(&mesh);
        let collider = BdtCollider::from(mesh.clone());
        let spread = [0.6, 1.0, 1.6, 2.2][round % 4] * rng.random_range(0.8..1.2);
        let pos = parry_shapes::pose(spread, &mut rng);
        let at = Pose::from_parts(
            Vec3::new(3.0, -2.0, 1.0),
            Quat::from_euler(bevy_math::EulerRot::XYZ, 0.3, 1.1, -0.4),
        );
        for is_swapped in [false, true] {
            let what = format!("{kind}, {round}, {is_swapped}");
            let expected = surface.contacts(&others, &pos, is_swapped, PREDICTION);
            let expected = expected.expect("contacts");
            let (mesh_side, other_side) = ((&collider, at), (&other, at * pos));
            let manifolds = match is_swapped {
                false => found(mesh_side, other_side),
                true => found(other_side, mesh_side),
            };
            // Right at the limit rounding decides.
            let is_sure = |dist: &f32| (dist - PREDICTION).abs() > 1e-4;
            let deepest = (expected.iter().map(|known| known.dist)).fold(f32::INFINITY, f32::min);
            let points = manifolds.iter().flat_map(|manifold| &manifold.points);
            let own =
                (points.clone().map(|point| -point.penetration)).fold(f32::INFINITY, f32::min);
            if kind == "voxels" {
                // Each alone would push where its neighbors cover it: tests of bdtree-parry ask their union.
                assert!(manifolds.is_empty() || !expected.is_empty(), "{what}");
            } else if is_sure(&deepest) {
                assert_eq!(manifolds.is_empty(), expected.is_empty(), "{what}");
                assert!(
                    own == deepest || (own - deepest).abs() < 2e-4,
                    "{what}: {own}, {deepest}"
                );
            }
            touching += usize::from(!manifolds.is_empty());
            apart += usize::from(expected.is_empty());
            for manifold in &manifolds {
                assert!(manifold.normal.is_normalized(), "{what}");
                for point in &manifold.points {
                    // On the mesh's own side of the middle, the surface is half the distance away.
                    let outwards = if is_swapped { 1.0 } else { -1.0 };
                    let here = point.point - manifold.normal * (outwards * 0.5 * point.penetration);
                    let local = at.inverse_transform_point(here);
                    // Points of a manifold share its normal, which is up to 8° from their own.
                    let slack = 5e-3 + 0.15 * point.penetration.abs();
                    let distances = surface.triangles.iter().map(|triangle| {
                        let near = triangle.project_local_point(local, false);
                        near.point.distance(local)
                    });
                    let apart = distances.fold(f32::INFINITY, f32::min);
                    assert!(
                        apart < slack,
                        "{what}: {point:?} is {apart} off the surface"
                    );
                    let origins = [mesh_side.1, other_side.1].map(|pose| pose.translation);
                    let [first, second] = if is_swapped {
                        [origins[1], origins[0]]
                    } else {
                        origins
                    };
                    assert!(
                        (first + point.anchor1).distance(point.point) < 1e-5,
                        "{what}"
                    );
                    assert!(
                        (second + point.anchor2).distance(point.point) < 1e-5,
                        "{what}"
                    );
                    assert!(!point.feature_id1.is_unknown() || !point.feature_id2.is_unknown());
                }
            }
        }
    }
    assert!(touching >= 8 && apart >= 4, "{kind}: {touching}, {apart}");
}

macro_rules! shapes {
    ($($kind:ident),* $(,)?) => {$(
        #[test]
        fn $kind() {
            check(stringify!($kind));
        }
    )*};
}
shapes!(
    ball,
    cuboid,
    capsule,
    segment,
    triangle,
    convex_polyhedron,
    cylinder,
    cone,
    round_cuboid,
    round_triangle,
    round_cylinder,
    round_cone,
    round_convex_polyhedron,
    half_space,
    tri_mesh,
    polyline,
    height_field,
    voxels,
    compound,
    custom,
);

/// Points of the last step go on: their impulses start the next step.
#[test]
fn impulses_go_on_from_step_to_step() {
    let mut rng = poses::rng(4);
    let mesh = parry_shapes::mesh(parry_shapes::bumpy(), &mut rng);
    let collider = BdtCollider::from(mesh);
    let floor = BdtCollider::from(parry_shapes::shape("cuboid"));
    let at = |lift: f32| Pose::from_translation(Vec3::new(0.0, 1.0 + lift, 0.0));
    let mut manifolds = found((&collider, Pose::IDENTITY), (&floor, at(0.0)));
    assert!(!manifolds.is_empty());
    for (k, point) in (manifolds
        .iter_mut()
        .flat_map(|manifold| &mut manifold.points))
    .enumerate()
    {
        point.warm_start_normal_impulse = 1.0 + k as f32;
    }
    let before: Vec<f32> = (manifolds.iter().flat_map(|manifold| &manifold.points))
        .map(|point| point.warm_start_normal_impulse)
        .collect();
    collider.contact_manifolds(
        &floor,
        Vec3::ZERO,
        Quat::IDENTITY,
        at(1e-4).translation,
        Quat::IDENTITY,
        PREDICTION,
        &mut manifolds,
    );
    let mut after: Vec<f32> = (manifolds.iter().flat_map(|manifold| &manifold.points))
        .map(|point| point.warm_start_normal_impulse)
        .collect();
    after.sort_by(f32::total_cmp);
    assert_eq!(before, after);
}
