//! Every error of poses and queries has an input that triggers it, and a text that says what was
//! given and what would be right.

use std::collections::BTreeSet;

use bdtree_fixtures::bake;
use bdtree_runtime::{
    Ball, CacheSize, Capsule, Contact, ContactManifold, Cuboid, Frustum, HalfSpace, Model,
    PairContact, PoseError, QueryError, Ray, Shape, StepCache, Transform, Workspace,
};

fn file() -> Model {
    let mesh = bake::bumpy_sphere(8, 1);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 5, 1))
}

#[test]
fn every_pose_error_is_triggered() {
    let file = file();
    let asset = *file.asset();
    let limit = asset.modes()[2].q_limit.get();
    let posed = |q: &[f32], memory: usize, transform: Transform| {
        let mut memory = vec![0.0; memory];
        asset
            .pose(q, transform, &mut memory)
            .map(|_| ())
            .expect_err("refused")
    };
    let here = Transform::IDENTITY;
    let q = |x: f32| [0.0, 0.0, x, 0.0, 0.0];
    let (rotation, translation, scale) = ([0.0, 0.0, 0.0, 1.1], [f64::NAN, 0.0, 0.0], 0.0);
    let over = format!("q[2] = {} exceeds the limit of {limit}", -limit * 2.0);
    for (found, expected, text) in [
        (
            posed(&[0.0; 4], 10, here),
            PoseError::ModeCount {
                expected: 5,
                found: 4,
            },
            "q has 4 entries but the asset has 5 modes",
        ),
        (
            posed(&[0.0; 5], 9, here),
            PoseError::Memory {
                needed: 14,
                found: 9,
            },
            "pose memory holds 9 numbers, 14 are needed",
        ),
        (
            posed(&q(f32::NAN), 14, here),
            PoseError::NotFinite { mode: 2 },
            "q[2] is not a finite number",
        ),
        (
            posed(&q(f32::NEG_INFINITY), 14, here),
            PoseError::NotFinite { mode: 2 },
            "q[2] is not",
        ),
        (
            posed(&q(-limit * 2.0), 14, here),
            PoseError::OverLimit {
                mode: 2,
                found: -limit * 2.0,
                limit,
            },
            over.as_str(),
        ),
        (
            posed(&q(0.0), 14, Transform { rotation, ..here }),
            PoseError::Rotation,
            "quaternion",
        ),
        (
            posed(
                &q(0.0),
                14,
                Transform {
                    translation,
                    ..here
                },
            ),
            PoseError::Translation,
            "translation is not finite",
        ),
        (
            posed(&q(0.0), 14, Transform { scale, ..here }),
            PoseError::Scale,
            "scale is not between 2^-60 and 2^60",
        ),
    ] {
        assert_eq!(found, expected);
        assert!(found.to_string().contains(text), "{found}");
    }
    let mut memory = [0.0; 16];
    assert!(
        asset.pose(&q(limit), here, &mut memory).is_ok(),
        "limits are inclusive"
    );
}

#[test]
fn every_query_error_is_triggered() {
    let file = file();
    let asset = *file.asset();
    let mut memory = [0.0; 16];
    let pose = asset
        .pose(&[0.0; 5], Transform::IDENTITY, &mut memory)
        .expect("pose");
    let mut out: Vec<Contact> = Vec::new();
    let mut pair_out: Vec<PairContact> = Vec::new();
    let (mut lanes, mut lane_pairs, mut lane_triangles) = (Vec::new(), Vec::new(), Vec::new());
    let (nan, far, inf) = (f64::NAN, 2e30, f64::INFINITY);
    let origin = [0.0; 3];
    let (turned, half) = ([0.0, 0.0, 0.0, 1.0], [1.0; 3]);
    let planes = Frustum::new(&[[0.0, 0.0, 1.0, 0.0]]).expect("planes");
    let shapes: [Shape; 4] = [
        Ball::new(origin, 1.0).into(),
        HalfSpace::new([1.0; 3], 0.0).into(),
        Capsule::new(origin, origin, 1.0).into(),
        Cuboid::new(origin, half).into(),
    ];
    let ray = Ray::new(origin, [1.0; 3]);

    let text = QueryError::Memory {
        needed: 70,
        found: 69,
    };
    assert_eq!(
        text.to_string(),
        "the query needs 70 bytes of memory, it has 69"
    );
    // One byte fewer than what each kind of query needs, from an address that is a multiple of eight.
    let mut bytes = [0_u64; 1024];
    let bytes = zerocopy::IntoBytes::as_mut_bytes(&mut bytes[..]);
    let most = bytes.len();
    let mut short = |ask: &mut dyn FnMut(&mut Workspace<'_>) -> Option<QueryError>| {
        let Some(QueryError::Memory { needed, found: 0 }) = ask(&mut Workspace::in_bytes(&mut []))
        else {
            panic!("nothing is enough");
        };
        assert!(64 < needed && needed < most, "{needed}");
        let found = needed - 1;
        let refused = ask(&mut Workspace::in_bytes(&mut bytes[..found]));
        assert_eq!(refused, Some(QueryError::Memory { needed, found }));
        let answer = ask(&mut Workspace::in_bytes(&mut bytes[..needed]));
        assert_eq!(answer, None, "{needed} bytes are enough");
    };
    for shape in shapes {
        short(&mut |memory| pose.query(memory).contacts(shape, &mut out).err());
        short(&mut |memory| pose.query(memory).intersects(shape).err());
        short(&mut |memory| {
            let mut query = pose.query(memory);
            query.level_spheres(1, shape, &mut lanes).err()
        });
    }
    short(&mut |memory| pose.query(memory).project_point(origin, inf).err());
    short(&mut |memory| pose.query(memory).cast_ray(&ray).err());
    short(&mut |memory| pose.query(memory).frustum_state(&planes).err());
    short(&mut |memory| {
        pose.against(&pose, memory)
            .contacts(0.0, &mut pair_out)
            .err()
    });
    short(&mut |memory| pose.against(&pose, memory).intersects().err());
    short(&mut |memory| {
        let mut query = pose.against(&pose, memory);
        query.level_spheres([1; 2], 0.0, 0.1, &mut lane_pairs).err()
    });
    short(&mut |memory| {
        let mut query = pose.against(&pose, memory);
        query
            .level_triangles(1, 0.0, 0.1, &mut lane_triangles)
            .err()
    });
    short(&mut |memory| pose.against(&pose, memory).distance(inf).err());

    let mut texts = BTreeSet::new();
    let mut argument = |found: Option<QueryError>| match found {
        Some(QueryError::Argument(text)) => {
            assert_eq!(QueryError::Argument(text).to_string(), text);
            texts.insert(text);
        }
        other => panic!("{other:?}"),
    };
    let mut workspace = Workspace::new();
    for bad in [nan, inf, far] {
        let point = [0.0, bad, 0.0];
        let quaternion = [0.0, bad, 0.0, 1.0];
        let mut query = pose.query(&mut workspace);
        for shape in [
            Ball::new(point, 1.0).into(),
            Ball::new(origin, bad).into(),
            HalfSpace::new([1.0; 3], bad).into(),
            Capsule::new(point, origin, 1.0).into(),
            Capsule::new(origin, point, 1.0).into(),
            Cuboid::new(point, half).into(),
            Shape::from(Cuboid::new(origin, half).rotated(quaternion)),
        ] {
            argument(query.contacts(shape, &mut out).err());
            argument(query.intersects(shape).err());
            lanes.clear();
            argument(query.level_spheres(1, shape, &mut lanes).err());
            assert!(lanes.is_empty());
        }
        argument(query.project_point(point, inf).err());
        argument(query.cast_ray(&Ray::new(point, [1.0; 3])).err());
        let mut query = pose.against(&pose, &mut workspace);
        argument(query.contacts(bad, &mut pair_out).err());
        argument(query.is_within(bad).err());
        lane_pairs.clear();
        lane_triangles.clear();
        for [prediction, reach] in [[bad, 0.0], [0.0, bad]] {
            let refused = query.level_spheres([1; 2], prediction, reach, &mut lane_pairs);
            argument(refused.err());
            let refused = query.level_triangles(1, prediction, reach, &mut lane_triangles);
            argument(refused.err());
        }
        assert!(lane_pairs.is_empty() && lane_triangles.is_empty());
    }
    for bad in [nan, -1.0, -f64::MIN_POSITIVE, far] {
        let mut query = pose.query(&mut workspace);
        for shape in [
            Capsule::new(origin, origin, bad).into(),
            Cuboid::new(origin, [1.0, bad, 1.0]).into(),
            Shape::from(Ball::new(origin, bad)),
        ] {
            argument(query.contacts(shape, &mut out).err());
        }
        // What programs take for no limit is one.
        let nearest = query.project_point(origin, bad);
        let hit = query.cast_ray(&ray.with_max_distance(bad));
        if bad > 0.0 {
            let nearest = nearest.expect("a limit").expect("the mesh");
            let whole = query.project_point(origin, inf).expect("no limit");
            assert_eq!(Some(nearest), whole);
            assert_eq!(hit, query.cast_ray(&ray.with_max_distance(f64::MAX)));
            assert_eq!(hit, query.cast_ray(&ray));
        } else {
            argument(nearest.err());
            argument(hit.err());
        }
        let mut query = pose.against(&pose, &mut workspace);
        argument(query.contacts(bad, &mut pair_out).err());
        argument(query.is_within(bad).err());
        lane_pairs.clear();
        lane_triangles.clear();
        for [prediction, reach] in [[bad, 0.0], [0.0, bad]] {
            let refused = query.level_spheres([1; 2], prediction, reach, &mut lane_pairs);
            argument(refused.err());
            let refused = query.level_triangles(1, prediction, reach, &mut lane_triangles);
            argument(refused.err());
        }
        assert!(lane_pairs.is_empty() && lane_triangles.is_empty());
    }
    let mut query = pose.query(&mut workspace);
    for bad in [[0.0; 3], [nan, 1.0, 0.0], [1.0, inf, 0.0]] {
        argument(query.contacts(HalfSpace::new(bad, 0.0), &mut out).err());
        argument(query.cast_ray(&Ray::new(origin, bad)).err());
    }
    for bad in [[0.0; 4], [0.0, 0.0, 0.0, 1.0011], [0.5, 0.5, 0.5, 0.497]] {
        argument(
            query
                .contacts(Cuboid::new(origin, half).rotated(bad), &mut out)
                .err(),
        );
    }
    let edge = Cuboid::new(origin, half).rotated([0.0, 0.0, 0.0, 0.99901]);
    assert!(query.contacts(edge, &mut out).is_ok());
    assert!(
        query
            .contacts(Cuboid::new(origin, half).rotated(turned), &mut out)
            .is_ok()
    );
    assert!(texts.len() >= 14, "{texts:?}");
}

/// A cache that was started with another pose: every question says so, whichever side it is of.
#[test]
fn a_cache_of_another_pose_is_refused() {
    let file = file();
    let asset = *file.asset();
    let q = [0.0, 0.1, 0.0, 0.0, 0.0];
    let mut memory = [[0.0; 16], [0.0; 16]];
    let [memory0, memory1] = &mut memory;
    let pose = asset
        .pose(&[0.0; 5], Transform::IDENTITY, memory0)
        .expect("pose");
    let other = asset.pose(&q, Transform::IDENTITY, memory1).expect("pose");
    let mut workspace = Workspace::new();
    let mut out: Vec<Contact> = Vec::new();
    let mut pair_out: Vec<PairContact> = Vec::new();
    let (mut lanes, mut lane_pairs, mut lane_triangles) = (Vec::new(), Vec::new(), Vec::new());
    let size = CacheSize::all(&asset);
    let (mut right, mut wrong, mut never) = (
        StepCache::new(size),
        StepCache::new(size),
        StepCache::new(size),
    );
    right.start(&pose);
    wrong.start(&other);
    let ball = Ball::new([1.0, 0.0, 0.0], 0.5);
    for cache in [&mut wrong, &mut never] {
        let mut query = pose.query(&mut workspace).cached(cache);
        assert_eq!(query.contacts(ball, &mut out), Err(QueryError::Cache));
        assert_eq!(query.intersects(ball), Err(QueryError::Cache));
        let refused = query.level_spheres(0, ball, &mut lanes);
        assert_eq!(refused, Err(QueryError::Cache));
        assert_eq!(query.project_point([0.0; 3], 9.0), Err(QueryError::Cache));
        let ray = Ray::new([0.0; 3], [1.0; 3]);
        assert_eq!(query.cast_ray(&ray), Err(QueryError::Cache));
        let mut query = query.max_visits(9);
        assert_eq!(query.cast_ray(&ray).err(), Some(QueryError::Cache));
    }
    for first in [true, false] {
        let (one, two) = if first {
            (&mut wrong, &mut right)
        } else {
            (&mut right, &mut wrong)
        };
        let mut query = pose.against(&pose, &mut workspace).cached(one, two);
        assert_eq!(query.contacts(0.0, &mut pair_out), Err(QueryError::Cache));
        assert_eq!(query.distance(1.0), Err(QueryError::Cache));
        let refused = query.level_spheres([0; 2], 0.0, 1.0, &mut lane_pairs);
        assert_eq!(refused, Err(QueryError::Cache));
        let refused = query.level_triangles(0, 0.0, 1.0, &mut lane_triangles);
        assert_eq!(refused, Err(QueryError::Cache));
        let mut manifolds: Vec<ContactManifold> = Vec::new();
        let refused = query.contact_manifolds(0.0, &mut manifolds);
        assert_eq!(refused, Err(QueryError::Cache));
        let mut query = query.max_visits(9);
        assert_eq!(query.closest_points(1.0).err(), Some(QueryError::Cache));
    }
    assert!(out.is_empty() && pair_out.is_empty());
    assert!(lanes.is_empty() && lane_pairs.is_empty() && lane_triangles.is_empty());
    // The pose elsewhere is the same to a cache.
    let placed = pose.placed(Transform::from_translation([2.0, 0.0, 0.0]));
    let placed = placed.expect("a placement");
    let mut query = placed.query(&mut workspace).cached(&mut right);
    assert!(query.contacts(ball, &mut out).is_ok());
    // Memory that is too short for a cache.
    let mut bytes = vec![
        0;
        CacheSize {
            nodes: 3,
            leaves: 2
        }
        .bytes()
    ];
    let short = StepCache::in_bytes(
        &mut bytes[..3 * 136 + 2 * 176 - 1],
        CacheSize {
            nodes: 3,
            leaves: 2,
        },
    );
    assert!(matches!(short, Err(QueryError::Memory { needed, .. }) if needed == 3 * 136 + 2 * 176));
    assert!(
        StepCache::in_bytes(
            &mut bytes[1..],
            CacheSize {
                nodes: 3,
                leaves: 2
            }
        )
        .is_ok()
    );
}
