//! Every shape of parry with a deforming mesh, in both orders, beside brute force.

use bdtree_fixtures::poses;
use rand::RngExt;

use super::brute::{Answer, Element, Surface, apart, elements};
use super::ours::{DeformingMesh, MeshDispatcher};
use super::parry::math::{Pose, Real};
use super::parry::query::{
    ContactManifold, NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher,
    ShapeCastOptions, Unsupported,
};
use super::parry::shape::{Shape, SharedShape};
use super::support;

/// How far from a surface contacts are predicted.
const PREDICTION: Real = 0.1;

/// Of distances: poses of parts are composed in another order, and parry iterates.
const TOLERANCE: Real = 2e-4;

/// How often each answer was found, or was none.
#[derive(Debug, Default)]
struct Counts {
    touching: usize,
    apart: usize,
    contacts: usize,
    hits: usize,
    turning_hits: usize,
    manifolds: usize,
}

fn same(a: Real, b: Real) -> bool {
    (a - b).abs() <= TOLERANCE * (1.0 + a.abs())
}

fn same_option(a: Answer<Option<Real>>, b: Answer<Option<Real>>, edge: Real) -> bool {
    match (a, b) {
        (Ok(Some(a)), Ok(Some(b))) => same(a, b),
        (Ok(None), Ok(None)) | (Err(Unsupported), Err(Unsupported)) => true,
        // Right at the limit rounding decides.
        (Ok(Some(x)), Ok(None)) | (Ok(None), Ok(Some(x))) => same(x, edge),
        _ => false,
    }
}

struct Case<'a> {
    mesh: &'a DeformingMesh,
    surface: &'a Surface,
    other: &'a SharedShape,
    others: &'a [Element],
    /// The other shape in the frame of the mesh.
    pos: Pose,
    is_swapped: bool,
}

impl Case<'_> {
    fn shapes(&self) -> (Pose, &dyn Shape, &dyn Shape) {
        match self.is_swapped {
            false => (self.pos, self.mesh, &**self.other),
            true => (self.pos.inverse(), &**self.other, self.mesh),
        }
    }

    fn check(&self, what: &str, counts: &mut Counts) {
        let dispatcher = MeshDispatcher::new();
        let (pos12, one, two) = self.shapes();
        let (surface, others, pos, swap) = (self.surface, self.others, &self.pos, self.is_swapped);

        let distance = dispatcher.distance(&pos12, one, two).expect("a distance");
        let expected = surface.distance(others, pos, swap).expect("a distance");
        assert!(
            same(distance.distance, expected),
            "{what}: {distance:?}, {expected}"
        );

        let touches = dispatcher
            .intersection_test(&pos12, one, two)
            .map(|found| found.intersecting);
        let expected_touches = surface.intersects(others, pos, swap);
        let is_close_call = expected > 0.0 && expected < TOLERANCE;
        assert!(
            touches == expected_touches || is_close_call,
            "{what}: {touches:?}, {expected}"
        );
        match touches {
            Ok(true) => counts.touching += 1,
            _ => counts.apart += 1,
        }

        let contact = dispatcher.contact(&pos12, one, two, PREDICTION);
        let expected = surface.contact(others, pos, swap, PREDICTION);
        let dist = contact.map(|found| found.map(|found| found.dist));
        assert!(
            same_option(dist, expected, PREDICTION),
            "{what}: {contact:?}, {expected:?}"
        );
        if let Ok(Some(found)) = contact {
            counts.contacts += 1;
            let along = (pos12 * found.point2 - found.point1).dot(found.normal1);
            assert!(same(along, found.dist), "{what}: {found:?} says {along}");
            let back = pos12.rotation * found.normal2;
            assert!(same(back.dot(found.normal1), -1.0), "{what}: {found:?}");
        }

        for limit in [0.25, 1e3] {
            let found = dispatcher.closest_points(&pos12, one, two, limit);
            let found = found.map(|found| apart(found, &pos12));
            let expected = surface.closest(others, pos, swap, limit);
            assert!(
                same_option(found, expected, limit),
                "{what}: {found:?}, {expected:?}"
            );
        }
        self.check_casts(what, counts);
        // Those of voxels are of their union, not of each: the tests of voxels ask them.
        if self.other.as_voxels().is_none() {
            self.check_manifolds(what, counts);
        }
    }

    fn check_casts(&self, what: &str, counts: &mut Counts) {
        let dispatcher = MeshDispatcher::new();
        let (pos12, one, two) = self.shapes();
        let mut rng = poses::rng(self.surface.triangles.len() as u64 + u64::from(self.is_swapped));
        // Towards each other, past each other, away.
        let towards = (-pos12.translation).normalize_or_zero();
        let aside = support::pose(1.0, &mut rng).translation;
        for (velocity, end) in [
            (towards, 10.0),
            (towards * 0.5 + aside, 3.0),
            (-towards, 1e9),
        ] {
            for target_distance in [0.0, 0.05] {
                let options = ShapeCastOptions {
                    max_time_of_impact: end,
                    target_distance,
                    ..ShapeCastOptions::default()
                };
                let hit = dispatcher.cast_shapes(&pos12, velocity, one, two, options);
                let (surface, others) = (self.surface, self.others);
                let expected = surface.cast(others, &self.pos, self.is_swapped, velocity, options);
                let time = hit.map(|hit| hit.map(|hit| hit.time_of_impact));
                assert!(
                    same_option(time, expected, end),
                    "{what}: {hit:?}, {expected:?}"
                );
                counts.hits += usize::from(matches!(hit, Ok(Some(_))));
            }
        }
        let turn = support::pose(1.5, &mut rng).translation;
        let still = NonlinearRigidMotion::constant_position(Pose::IDENTITY);
        let center = self.mesh.compute_local_aabb().center();
        let own = NonlinearRigidMotion::new(Pose::IDENTITY, center, aside * 0.2, turn);
        let velocity = -self.pos.translation.normalize_or_zero();
        let others = NonlinearRigidMotion::new(self.pos, center * 0.1, velocity, -turn * 0.5);
        for own in [own, still] {
            let motions = [&own, &others];
            let hit = match self.is_swapped {
                false => dispatcher.cast_shapes_nonlinear(&own, one, &others, two, 0.0, 1.5, true),
                true => dispatcher.cast_shapes_nonlinear(&others, one, &own, two, 0.0, 1.5, true),
            };
            let expected = self
                .surface
                .cast_nonlinear(self.others, motions, self.is_swapped, 1.5);
            let time = hit.map(|hit| hit.map(|hit| hit.time_of_impact));
            // parry steps towards the time of contact: how far it gets depends on the end of the interval.
            let is_same = match (time, expected) {
                (Ok(Some(a)), Ok(Some(b))) => (a - b).abs() < 0.02,
                (a, b) => same_option(a, b, 1.5),
            };
            assert!(is_same, "{what}: {hit:?}, {expected:?}");
            counts.turning_hits += usize::from(matches!(hit, Ok(Some(_))));
        }
    }

    fn check_manifolds(&self, what: &str, counts: &mut Counts) {
        let (pos12, one, two) = self.shapes();
        let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
        MeshDispatcher::new()
            .contact_manifolds(&pos12, one, two, PREDICTION, &mut manifolds, &mut None)
            .expect("manifolds");
        let (others, swap) = (self.others, self.is_swapped);
        let expected = self
            .surface
            .contacts(others, &self.pos, swap, PREDICTION)
            .expect("contacts");
        assert_eq!(
            manifolds.is_empty(),
            expected.is_empty(),
            "{what}: {manifolds:?}, {expected:?}"
        );
        counts.manifolds += manifolds.len();
        let deepest = expected
            .iter()
            .map(|found| found.dist)
            .fold(Real::INFINITY, Real::min);
        let points = manifolds.iter().flat_map(|manifold| &manifold.points);
        let found = points
            .map(|point| point.dist)
            .fold(Real::INFINITY, Real::min);
        assert!(
            found == deepest || same(found, deepest),
            "{what}: {found}, {deepest}"
        );
        for manifold in &manifolds {
            assert!(
                (1..=4).contains(&manifold.points.len()),
                "{what}: {manifold:?}"
            );
            let normal = if swap {
                manifold.local_n2
            } else {
                manifold.local_n1
            };
            for point in &manifold.points {
                let at = if swap { point.local_p2 } else { point.local_p1 };
                let is_known = expected.iter().any(|known| {
                    // Where edges are nearly parallel, a pose in another order of rounding moves the point along them.
                    known.point.distance(at) < 5e-3
                        && same(known.dist, point.dist)
                        && known.normal.dot(normal) > 0.98
                });
                assert!(is_known, "{what}: {point:?} is of no triangle");
            }
        }
        // No direction of contact is lost.
        for known in &expected {
            let normal_of =
                |m: &ContactManifold<(), ()>| if swap { m.local_n2 } else { m.local_n1 };
            let is_there = manifolds
                .iter()
                .any(|m| normal_of(m).dot(known.normal) > 0.98);
            assert!(is_there, "{what}: {known:?} is lost");
        }
    }
}

/// Random q and poses of a shape, in both orders.
fn check(kind: &str) {
    let other = support::shape(kind);
    let others = elements(&other);
    let mut rng = poses::rng(17);
    let mut counts = Counts::default();
    for round in 0..6 {
        let mesh = support::mesh(support::bumpy(), &mut rng);
        let surface = Surface::of(&mesh);
        for spread in [0.5, 0.9, 1.6] {
            let pos = support::pose(spread * rng.random_range(0.8..1.2), &mut rng);
            for is_swapped in [false, true] {
                let case = Case {
                    mesh: &mesh,
                    surface: &surface,
                    other: &other,
                    others: &others,
                    pos,
                    is_swapped,
                };
                case.check(
                    &format!("{kind}, {round}, {spread}, {is_swapped}"),
                    &mut counts,
                );
            }
        }
    }
    println!("{kind}: {counts:?}");
    let is_mixed = counts.touching > 3 && counts.apart > 3 && counts.contacts > 3;
    assert!(is_mixed && counts.hits > 10, "{kind}: {counts:?}");
    assert!(
        counts.manifolds > 3 || kind == "voxels",
        "{kind}: {counts:?}"
    );
    // parry turns no half-space.
    assert!(
        counts.turning_hits > 5 || kind == "half_space",
        "{kind}: {counts:?}"
    );
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
