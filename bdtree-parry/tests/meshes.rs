//! Two deforming meshes, and meshes inside of a `Compound`.

use bdtree_fixtures::poses;
use rand::RngExt;

use super::brute::{Surface, apart, elements};
use super::ours::MeshDispatcher;
use super::parry::math::{Pose, Real};
use super::parry::query::{
    ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion, PersistentQueryDispatcher,
    QueryDispatcher, ShapeCastOptions,
};
use super::parry::shape::{Shape, SharedShape};
use super::support;

const TOLERANCE: Real = 2e-4;

fn manifolds(pos12: &Pose, one: &dyn Shape, two: &dyn Shape) -> Vec<ContactManifold<(), ()>> {
    let mut found = Vec::new();
    MeshDispatcher::new()
        .contact_manifolds(pos12, one, two, 0.05, &mut found, &mut None)
        .expect("manifolds");
    found
}

fn close(a: Option<Real>, b: Option<Real>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() < 5.0 * TOLERANCE,
        (a, b) => a.is_none() && b.is_none(),
    }
}

#[test]
fn two_meshes_are_what_all_pairs_of_triangles_are() {
    let dispatcher = MeshDispatcher::new();
    let mut rng = poses::rng(23);
    let [mut touching, mut separate, mut hits, mut regions] = [0_usize; 4];
    for spread in [0.6, 1.2, 1.6, 1.7, 2.0, 2.5] {
        let one = support::mesh(support::bumpy(), &mut rng);
        let two = support::mesh(support::bumpy(), &mut rng);
        let surface = Surface::of(&one);
        // The triangles of the second as elements.
        let triangles = Surface::of(&two).triangles.into_iter();
        let others: Vec<_> = triangles
            .map(|t| (Pose::IDENTITY, SharedShape::new(t)))
            .collect();
        let mut pos = support::pose(1.0, &mut rng);
        pos.translation *= spread as Real / pos.translation.length();

        let distance = dispatcher
            .distance(&pos, &one, &two)
            .expect("a distance")
            .distance;
        let expected = surface.distance(&others, &pos, false).expect("a distance");
        assert!(
            (distance - expected).abs() < TOLERANCE,
            "{spread}: {distance}, {expected}"
        );
        let touches = dispatcher
            .intersection_test(&pos, &one, &two)
            .expect("a test")
            .intersecting;
        assert_eq!(touches, distance == 0.0, "{spread}");
        touching += usize::from(touches);
        separate += usize::from(!touches);

        let dist = dispatcher
            .contact(&pos, &one, &two, 0.1)
            .expect("a contact");
        let expected_dist = surface
            .contact(&others, &pos, false, 0.1)
            .expect("a contact");
        let dist = dist.map(|found| found.dist);
        assert!(
            close(dist, expected_dist),
            "{spread}: {dist:?}, {expected_dist:?}"
        );

        let nearest = dispatcher
            .closest_points(&pos, &one, &two, 0.3)
            .expect("points");
        let nearest = apart(nearest, &pos);
        let expected_nearest = (expected <= 0.3).then_some(expected);
        assert!(
            close(nearest, expected_nearest),
            "{spread}: {nearest:?}, {expected}"
        );

        let velocity = -pos.translation.normalize();
        let options = ShapeCastOptions::with_max_time_of_impact(2.0);
        let hit = dispatcher
            .cast_shapes(&pos, velocity, &one, &two, options)
            .expect("a cast");
        let expected_hit = surface
            .cast(&others, &pos, false, velocity, options)
            .expect("a cast");
        let time = hit.map(|hit| hit.time_of_impact);
        assert!(
            close(time, expected_hit),
            "{spread}: {hit:?}, {expected_hit:?}"
        );
        hits += usize::from(hit.is_some());

        let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
        let falling =
            NonlinearRigidMotion::new(pos, pos.translation * 0.0, velocity, velocity * 0.0);
        let turned = dispatcher
            .cast_shapes_nonlinear(&still, &one, &falling, &two, 0.0, 2.0, true)
            .expect("a cast");
        let expected_time = surface.cast_nonlinear(&others, [&still, &falling], false, 2.0);
        let (turned, expected_time) = (
            turned.map(|hit| hit.time_of_impact),
            expected_time.expect("a cast"),
        );
        assert_eq!(turned.is_some(), expected_time.is_some(), "{spread}");
        if let (Some(a), Some(b)) = (turned, expected_time) {
            assert!((a - b).abs() < 0.02, "{spread}: {a}, {b}");
        }

        let found = manifolds(&pos, &one, &two);
        assert_eq!(found.is_empty(), distance > 0.05, "{spread}: {distance}");
        let swapped = manifolds(&pos.inverse(), &two, &one);
        assert_eq!(found.len(), swapped.len(), "{spread}");
        regions += found.len();
        for manifold in &found {
            // Surfaces are pushed apart: the second away from the first.
            let away = manifold.local_n1.dot(pos.translation);
            assert!(away > 0.0, "{spread}: {manifold:?}");
            let back = pos.rotation * manifold.local_n2;
            assert!(
                back.dot(manifold.local_n1) < -0.999,
                "{spread}: {manifold:?}"
            );
        }
    }
    assert!(
        touching > 1 && separate > 1 && hits > 3 && regions > 1,
        "{touching} {separate} {hits} {regions}"
    );
}

/// parry's own dispatcher finds nothing here: it drops pairs that it does not know.
#[test]
fn nothing_vanishes_in_a_compound_of_meshes() {
    let dispatcher = MeshDispatcher::new();
    let mut rng = poses::rng(29);
    let mesh = support::mesh(support::bumpy(), &mut rng);
    let far = Pose::translation(4.0, 0.0, 0.0);
    let compound = SharedShape::compound(vec![
        (far, SharedShape::ball(0.5)),
        (
            Pose::translation(0.0, 0.3, 0.0),
            SharedShape::new(mesh.clone()),
        ),
    ]);
    let mut touching = 0;
    for kind in [
        "ball",
        "cuboid",
        "half_space",
        "tri_mesh",
        "polyline",
        "height_field",
        "voxels",
        "compound",
        "custom",
    ] {
        let other = support::shape(kind);
        for _ in 0..4 {
            let pos = support::pose(rng.random_range(0.6..1.0), &mut rng);
            let own = Pose::translation(0.0, 0.3, 0.0).inverse() * pos;
            let expected = dispatcher
                .distance(&own, &mesh, &*other)
                .expect("a distance")
                .distance;
            // The ball of the compound may be nearer to a half-space.
            let parts = elements(&other);
            let of_ball = parts.iter().map(|(place, shape)| {
                let pos = far.inverse() * pos * *place;
                let ball = SharedShape::ball(0.5);
                DefaultQueryDispatcher
                    .distance(&pos, &*ball, &**shape)
                    .expect("a distance")
                    .distance
            });
            let of_ball = of_ball.fold(Real::INFINITY, Real::min);
            let expected = expected.min(of_ball);
            for is_swapped in [false, true] {
                let (pos12, one, two): (Pose, &dyn Shape, &dyn Shape) = match is_swapped {
                    false => (pos, &*compound, &*other),
                    true => (pos.inverse(), &*other, &*compound),
                };
                let found = dispatcher
                    .distance(&pos12, one, two)
                    .expect("a distance")
                    .distance;
                assert!(
                    (found - expected).abs() < TOLERANCE,
                    "{kind}: {found}, {expected}"
                );
                let touches = dispatcher
                    .intersection_test(&pos12, one, two)
                    .expect("a test");
                let is_close_call = expected > 0.0 && expected < TOLERANCE;
                assert!(
                    touches.intersecting == (expected == 0.0) || is_close_call,
                    "{kind}"
                );
                let is_contact = dispatcher
                    .contact(&pos12, one, two, 0.05)
                    .expect("a contact");
                assert_eq!(is_contact.is_some(), expected <= 0.05, "{kind}: {expected}");
                // Where a closed mesh is touched from within alone, parry has no contact either.
                let found = manifolds(&pos12, one, two);
                let alone = manifolds(&own, &mesh, &*other);
                let is_near_ball = of_ball <= 0.05;
                assert!(
                    found.len() >= alone.len().max(usize::from(is_near_ball)),
                    "{kind}: {expected}"
                );
                assert!(expected <= 0.05 || found.is_empty(), "{kind}: {expected}");
                touching += usize::from(!found.is_empty());
            }
        }
    }
    assert!(touching > 20, "{touching}");
    assert!(!manifolds(&Pose::IDENTITY, &*compound, &mesh).is_empty());
}

#[test]
fn pairs_without_a_mesh_are_parrys() {
    let dispatcher = MeshDispatcher::new();
    let (ball, cuboid) = (support::shape("ball"), support::shape("compound"));
    let pos = Pose::translation(0.2, 0.9, 0.0);
    let ours = dispatcher
        .distance(&pos, &*ball, &*cuboid)
        .expect("a distance");
    let theirs = DefaultQueryDispatcher
        .distance(&pos, &*ball, &*cuboid)
        .expect("a distance");
    assert_eq!(ours, theirs);
    assert!(ours.distance > 0.0);
    let found = manifolds(&Pose::translation(0.2, 0.1, 0.0), &*ball, &*cuboid);
    assert!(!found.is_empty());
}
