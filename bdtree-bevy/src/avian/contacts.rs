//! Contact manifolds of avian from those of the dispatcher.

use avian3d::collision::contact_types::PackedFeatureId;
use avian3d::parry::math::Pose3 as Pose;
use avian3d::parry::query::{
    ContactManifold as ParryManifold, PersistentQueryDispatcher, TrackedContact,
};
use avian3d::parry::shape::{PackedFeatureId as ParryFeatureId, Shape};
use avian3d::prelude::{ContactManifold, ContactPoint};
use bdtree_parry::{DeformingMesh, MeshDispatcher};
use bevy_math::Vec2;

/// Impulses that the solver starts with, carried from step to step.
#[derive(Debug, Clone, Copy, Default)]
struct Warm {
    normal: f32,
    tangent: Vec2,
}

/// Whether a shape is a deforming mesh or a `Compound` that holds one.
pub(super) fn holds_mesh(shape: &dyn Shape) -> bool {
    let is_mesh = |shape: &dyn Shape| shape.as_shape::<DeformingMesh>().is_some();
    match shape.as_compound() {
        Some(compound) => (compound.shapes().iter()).any(|(_, part)| is_mesh(&**part)),
        None => is_mesh(shape),
    }
}

/// Puts the contacts of two shapes in the place of the last step's, whose points go on where they last: avian alone would
/// match the points of at most four manifolds.
pub(super) fn manifolds(
    [shape1, shape2]: [&dyn Shape; 2],
    [pose1, pose2]: [Pose; 2],
    prediction: f32,
    manifolds: &mut Vec<ContactManifold>,
) {
    let mut own: Vec<ParryManifold<(), Warm>> = (manifolds.iter())
        .map(|manifold| to_parry(manifold, &pose1, &pose2))
        .collect();
    let pos12 = pose1.inv_mul(&pose2);
    let found = MeshDispatcher::new()
        .contact_manifolds(&pos12, shape1, shape2, prediction, &mut own, &mut None);
    manifolds.clear();
    // Shapes that parry cannot ask about touch nothing, as in avian.
    if found.is_err() {
        return;
    }
    manifolds.extend(
        own.iter()
            .filter_map(|manifold| to_avian(manifold, &pose1, &pose2)),
    );
}

/// The manifold of the last step, seen from where the shapes are now.
fn to_parry(manifold: &ContactManifold, pose1: &Pose, pose2: &Pose) -> ParryManifold<(), Warm> {
    let normal = manifold.normal;
    let mut made = ParryManifold::with_data(0, 0, ());
    made.local_n1 = pose1.rotation.inverse() * normal;
    made.local_n2 = pose2.rotation.inverse() * -normal;
    made.points.extend(manifold.points.iter().map(|point| {
        let half = normal * (0.5 * point.penetration);
        let mut tracked = TrackedContact::new(
            pose1.inverse_transform_point(point.point + half),
            pose2.inverse_transform_point(point.point - half),
            ParryFeatureId(point.feature_id1.0),
            ParryFeatureId(point.feature_id2.0),
            -point.penetration,
        );
        tracked.data = Warm {
            normal: point.warm_start_normal_impulse,
            tangent: point.warm_start_tangent_impulse,
        };
        tracked
    }));
    made
}

/// As avian makes its own: points lie midway between the surfaces, anchors are relative to the origins of the shapes.
fn to_avian(
    manifold: &ParryManifold<(), Warm>,
    pose1: &Pose,
    pose2: &Pose,
) -> Option<ContactManifold> {
    let normal = (pose1.rotation * manifold.local_n1).try_normalize()?;
    if manifold.points.is_empty() {
        return None;
    }
    let points = manifold.points.iter().map(|contact| {
        let anchor1 = pose1.rotation * contact.local_p1 + normal * (0.5 * contact.dist);
        let anchor2 = anchor1 + (pose1.translation - pose2.translation);
        let mut point =
            ContactPoint::new(anchor1, anchor2, pose1.translation + anchor1, -contact.dist)
                .with_feature_ids(
                    PackedFeatureId(contact.fid1.0),
                    PackedFeatureId(contact.fid2.0),
                );
        point.warm_start_normal_impulse = contact.data.normal;
        point.warm_start_tangent_impulse = contact.data.tangent;
        point
    });
    Some(ContactManifold::new(points, normal))
}
