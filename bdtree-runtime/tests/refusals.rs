//! Every error of poses and queries has an input that triggers it, and a text that says what was
//! given and what would be right.

use std::collections::BTreeSet;

use bdtree_fixtures::bake;
use bdtree_runtime::narrow::Frustum;
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, Pose, PoseError, QueryError, StackEntry, Transform, query,
};

fn file() -> AlignedBytes {
    let mesh = bake::bumpy_sphere(8, 1);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 5, 1))
}

#[test]
fn every_pose_error_is_triggered() {
    let file = file();
    let asset = Asset::open(&file).expect("open");
    let limit = asset.modes()[2].q_limit.get();
    let posed = |q: &[f32], memory: usize, transform: Transform| {
        let mut memory = vec![0.0; memory];
        Pose::new(&asset, q, transform, &mut memory)
            .map(|_| ())
            .expect_err("refused")
    };
    let here = Transform::IDENTITY;
    let q = |x: f32| [0.0, 0.0, x, 0.0, 0.0];
    let (rotation, translation, scale) = ([0.0, 0.0, 0.0, 1.1], [f64::NAN, 0.0, 0.0], 0.0);
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
                found: limit * 2.0,
                limit,
            },
            "is over the asset's limit of",
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
            "scale is not one",
        ),
    ] {
        assert_eq!(found, expected);
        assert!(found.to_string().contains(text), "{found}");
    }
    let mut memory = [0.0; 16];
    assert!(
        Pose::new(&asset, &q(limit), here, &mut memory).is_ok(),
        "limits are inclusive"
    );
}

#[test]
fn every_query_error_is_triggered() {
    let file = file();
    let asset = Asset::open(&file).expect("open");
    let copy = AlignedBytes::copy_of(&file);
    let other = Asset::open(&copy).expect("open");
    let mut memory = [0.0; 16];
    let pose = Pose::new(&asset, &[0.0; 5], Transform::IDENTITY, &mut memory).expect("pose");
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut pairs = vec![Default::default(); asset.pair_stack_len(&asset)];
    let mut out: Vec<Contact> = Vec::new();
    let mut pair_out = Vec::new();
    let (nan, far, inf) = (f64::NAN, 2e30, f64::INFINITY);
    let origin = [0.0; 3];

    let found = query::ball(&other, &pose, origin, 1.0, &mut stack, &mut out);
    assert_eq!(found, Err(QueryError::PoseMismatch));
    let (turned, half) = ([0.0, 0.0, 0.0, 1.0], [1.0; 3]);
    let found = query::capsule(&other, &pose, origin, origin, 1.0, &mut stack, &mut out);
    assert_eq!(found, Err(QueryError::PoseMismatch));
    let found = query::cuboid(&other, &pose, origin, turned, half, &mut stack, &mut out);
    assert_eq!(found, Err(QueryError::PoseMismatch));
    let planes = Frustum::new(&[[0.0, 0.0, 1.0, 0.0]]).expect("planes");
    let found = query::frustum(&other, &pose, &planes, &mut stack);
    assert_eq!(found, Err(QueryError::PoseMismatch));
    let found = query::root_sphere(&other, &pose);
    assert_eq!(found, Err(QueryError::PoseMismatch));
    let two = ((&asset, &pose), (&other, &pose));
    let found = query::pair(two.0, two.1, 0.0, &mut pairs, &mut pair_out);
    assert_eq!(found, Err(QueryError::PoseMismatch));
    assert_eq!(
        QueryError::PoseMismatch.to_string(),
        "the pose was made for another asset"
    );

    let needed = asset.stack_len();
    let memory = QueryError::Memory {
        needed,
        found: needed - 1,
    };
    assert!(memory.to_string().contains(&format!("{needed} are needed")));
    let short = &mut stack[1..];
    assert_eq!(
        query::ball(&asset, &pose, origin, 1.0, short, &mut out),
        Err(memory)
    );
    assert_eq!(
        query::plane(&asset, &pose, [1.0; 3], 0.0, short, &mut out),
        Err(memory)
    );
    assert_eq!(
        query::closest(&asset, &pose, origin, inf, short),
        Err(memory)
    );
    assert_eq!(
        query::ray(&asset, &pose, origin, [1.0; 3], inf, short),
        Err(memory)
    );
    assert_eq!(
        query::capsule(&asset, &pose, origin, origin, 1.0, short, &mut out),
        Err(memory)
    );
    assert_eq!(
        query::cuboid(&asset, &pose, origin, turned, half, short, &mut out),
        Err(memory)
    );
    assert_eq!(query::frustum(&asset, &pose, &planes, short), Err(memory));
    let needed = pairs.len();
    let memory = QueryError::Memory {
        needed,
        found: needed - 1,
    };
    let same = ((&asset, &pose), (&asset, &pose));
    let found = query::pair(same.0, same.1, 0.0, &mut pairs[1..], &mut pair_out);
    assert_eq!(found, Err(memory));

    let mut texts = BTreeSet::new();
    let mut argument = |found: Option<QueryError>| match found {
        Some(QueryError::Argument(text)) => {
            assert_eq!(QueryError::Argument(text).to_string(), text);
            texts.insert(text);
        }
        other => panic!("{other:?}"),
    };
    for bad in [nan, inf, far] {
        let point = [0.0, bad, 0.0];
        argument(query::ball(&asset, &pose, point, 1.0, &mut stack, &mut out).err());
        argument(query::ball(&asset, &pose, origin, bad, &mut stack, &mut out).err());
        argument(query::plane(&asset, &pose, [1.0; 3], bad, &mut stack, &mut out).err());
        let (out, stack) = (&mut out, &mut stack);
        argument(query::capsule(&asset, &pose, point, origin, 1.0, stack, out).err());
        argument(query::capsule(&asset, &pose, origin, point, 1.0, stack, out).err());
        argument(query::cuboid(&asset, &pose, point, turned, half, stack, out).err());
        let quaternion = [0.0, bad, 0.0, 1.0];
        argument(query::cuboid(&asset, &pose, origin, quaternion, half, stack, out).err());
        argument(query::closest(&asset, &pose, point, inf, stack).err());
        argument(query::ray(&asset, &pose, point, [1.0; 3], inf, stack).err());
        argument(query::pair(same.0, same.1, bad, &mut pairs, &mut pair_out).err());
    }
    for bad in [nan, -1.0, -f64::MIN_POSITIVE, far] {
        let (thick, thin) = ([1.0, bad, 1.0], &mut out);
        argument(query::capsule(&asset, &pose, origin, origin, bad, &mut stack, thin).err());
        argument(query::cuboid(&asset, &pose, origin, turned, thick, &mut stack, thin).err());
        argument(query::ball(&asset, &pose, origin, bad, &mut stack, &mut out).err());
        argument(query::closest(&asset, &pose, origin, bad, &mut stack).err());
        argument(query::ray(&asset, &pose, origin, [1.0; 3], bad, &mut stack).err());
        argument(query::pair(same.0, same.1, bad, &mut pairs, &mut pair_out).err());
    }
    for bad in [[0.0; 3], [nan, 1.0, 0.0], [1.0, inf, 0.0]] {
        argument(query::plane(&asset, &pose, bad, 0.0, &mut stack, &mut out).err());
        argument(query::ray(&asset, &pose, origin, bad, inf, &mut stack).err());
    }
    for bad in [[0.0; 4], [0.0, 0.0, 0.0, 1.0011], [0.5, 0.5, 0.5, 0.497]] {
        argument(query::cuboid(&asset, &pose, origin, bad, half, &mut stack, &mut out).err());
    }
    let edge = [0.0, 0.0, 0.0, 0.99901];
    assert!(query::cuboid(&asset, &pose, origin, edge, half, &mut stack, &mut out).is_ok());
    assert!(texts.len() >= 13, "{texts:?}");
}
