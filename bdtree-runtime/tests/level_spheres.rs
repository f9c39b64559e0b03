//! Queries that end at spheres, beside the list of all spheres: of one mesh and of two, wherever they stand, with and without
//! modes and bones, at every level, with every kernel and cache; what they refuse.

use bdtree_fixtures::bones::{KINDS, random_matrices};
use bdtree_fixtures::compare::levels::{check_level_pairs, check_level_spheres};
use bdtree_fixtures::compare::{kernels, near};
use bdtree_fixtures::oracle::spheres::{Spheres, distance};
use bdtree_fixtures::{bake, golden, oracle, poses};
use bdtree_runtime::{
    Asset, Ball, BoneMatrices, Coverage, LaneId, Model, Motion, PairFront, Pose, QueryError, Ray,
    Transform, Workspace,
};
use rand::RngExt;

use crate::bones::creature;

/// All modes for each vertex, few of them, none; and the golden files, two of which have a single triangle per lane.
pub(crate) fn files() -> Vec<Model> {
    let mesh = bake::bumpy_sphere(14, 1);
    let mut files = vec![
        bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5)),
        bake::baked(&mesh, &bake::local_basis(&mesh, 9, 5)),
        bake::baked(&mesh, &bake::rigid(&mesh)),
    ];
    for (name, bytes) in golden::files() {
        if name.ends_with(".bdt") {
            files.push(Model::from_bytes(&bytes).expect("a golden file"));
        }
    }
    assert!(files.len() > 6);
    files
}

/// A pose for each kernel, with any bones.
pub(crate) fn posed<T>(
    asset: &Asset<'_>,
    q: &[f32],
    bones: &[[[f64; 4]; 3]],
    place: Transform,
    f: impl FnOnce(&[Pose<'_>]) -> T,
) -> T {
    let assets: Vec<Asset<'_>> = kernels(asset).collect();
    let mut memories: Vec<Vec<f32>> = assets.iter().map(|a| vec![0.0; a.pose_len()]).collect();
    let poses = assets.iter().zip(&mut memories).map(|(asset, memory)| {
        let pose = match bones {
            [] => asset.pose(q, place, memory),
            _ => asset.pose_with_bones(q, BoneMatrices::Skinning(bones), place, memory),
        };
        pose.expect("a pose")
    });
    f(&poses.collect::<Vec<_>>())
}

#[test]
fn lanes_whose_spheres_a_shape_touches_are_reported() {
    let mut rng = poses::rng(1);
    let mut counts = [0; 2];
    for model in files() {
        let asset = model.asset();
        for round in 0..9 {
            let q = poses::random_q(asset, [0.0, 0.1, 0.5][round % 3], &mut rng);
            let place = poses::random_transform(10.0, &mut rng);
            posed(asset, &q, &[], place, |poses| {
                let body = oracle::deformed_triangles(&poses[0]);
                let [at, other] = [0; 2].map(|_| body[rng.random_range(0..body.len())][0]);
                let size = asset.unit() * poses::diagonal(asset);
                let size = size * place.scale * rng.random_range(0.0..0.3);
                let found = check_level_spheres(poses, [at, other], size);
                counts = [0, 1].map(|k| counts[k] + found[k]);
            });
        }
    }
    assert!(counts.iter().all(|n| *n > 10_000), "{counts:?}");
}

#[test]
fn pairs_whose_spheres_are_near_are_reported() {
    let mut rng = poses::rng(2);
    let mut reported = 0;
    let files = files();
    for (number, model) in files.iter().enumerate() {
        let asset = model.asset();
        for round in 0..6 {
            // With itself, and every other time with the next file.
            let other = files[(number + round % 2) % files.len()].asset();
            let [q, q2] = [asset, other].map(|asset| {
                let share = [0.0, 0.1, 0.5][round % 3];
                poses::random_q(asset, share, &mut rng)
            });
            let place = poses::random_transform(10.0, &mut rng);
            let mut beside = poses::random_transform(0.0, &mut rng);
            let size = asset.unit() * poses::diagonal(asset) * place.scale;
            let gap = size * [0.0, 0.5, 1.5][rng.random_range(0..3)];
            beside.translation = (place.translation).map(|x| x + gap * rng.random_range(-1.0..1.0));
            near::two((asset, &q, place), (other, &q2, beside), |two| {
                reported += check_level_pairs(two.with_kernels(), 4, &mut rng);
            });
        }
    }
    assert!(reported > 100_000, "{reported}");
}

#[test]
fn the_same_with_bones() {
    let mut rng = poses::rng(3);
    let (mut counts, mut reported) = ([0; 2], 0);
    for model in [creature(2, 2, true, 1.0, 2), creature(20, 4, false, 1.0, 4)] {
        let asset = model.asset();
        for kind in 0..KINDS {
            let bones = [0; 2].map(|_| random_matrices(asset, kind, &mut rng));
            let q = poses::random_q(asset, 0.2, &mut rng);
            let place = poses::random_transform(1.0, &mut rng);
            let beside = poses::random_transform(2.0, &mut rng);
            posed(asset, &q, &bones[0], place, |a| {
                let body = oracle::deformed_triangles(&a[0]);
                let [at, other] = [0; 2].map(|_| body[rng.random_range(0..body.len())][0]);
                let size = place.scale * rng.random_range(0.0..0.5);
                let found = check_level_spheres(a, [at, other], size);
                counts = [0, 1].map(|k| counts[k] + found[k]);
                posed(asset, &q, &bones[1], beside, |b| {
                    let both: Vec<_> = a.iter().zip(b).map(|(a, b)| [*a, *b]).collect();
                    reported += check_level_pairs(&both, 4, &mut rng);
                });
            });
        }
    }
    assert!(counts.iter().all(|n| *n > 500), "{counts:?}");
    assert!(reported > 10_000, "{reported}");
}

/// Spheres reach beyond vertices: where no vertex can be near the other body, spheres may still overlap.
#[test]
fn spheres_of_bodies_that_are_apart_may_meet() {
    let mesh = bake::bumpy_sphere(14, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5));
    let asset = model.asset();
    let mut rng = poses::rng(4);
    let q = vec![0.0; asset.mode_count()];
    let mut met = 0;
    for _ in 0..40 {
        let place = Transform {
            scale: 1.0,
            ..poses::random_transform(5.0, &mut rng)
        };
        let mut beside = Transform {
            scale: 1.0,
            ..poses::random_transform(1.0, &mut rng)
        };
        let direction = oracle::unit(beside.translation);
        let apart = rng.random_range(2.0..3.0);
        beside.translation = [0, 1, 2].map(|k| place.translation[k] + apart * direction[k]);
        near::two((asset, &q, place), (asset, &q, beside), |two| {
            check_level_pairs(two.with_kernels(), 4, &mut rng);
            let [a, b] = [&two.a, &two.b].map(Spheres::of);
            let mut found: Vec<[LaneId; 2]> = Vec::new();
            let mut workspace = Workspace::new();
            let mut query = two.a.against(&two.b, &mut workspace);
            let coverage = query.level_spheres([0; 2], 0.0, 0.0, &mut found);
            assert_eq!(coverage, Ok(Coverage::Complete));
            if distance(a.origin, b.origin) > 1.001 * (a.reach + b.reach) {
                met += found.len();
            }
        });
    }
    assert!(met > 3, "{met}");
}

/// So far away that f32 could not hold it, and with a reach that nothing is beyond.
#[test]
fn the_farthest_places_have_answers() {
    let [model, ..] = &files()[..] else {
        panic!("a file");
    };
    let asset = model.asset();
    let q = vec![0.0; asset.mode_count()];
    let small = Transform {
        scale: 2_f64.powi(-60),
        ..Transform::IDENTITY
    };
    let far = 2_f64.powi(79);
    for (away, prediction, reach, is_near) in [
        (far, 0.0, 0.0, false),
        (far, far, 2.0 * far, true),
        (1.0, 0.0, 0.0, false),
        (0.0, 0.0, far, true),
    ] {
        let beside = Transform {
            translation: [away, 0.0, 0.0],
            ..small
        };
        near::two((asset, &q, small), (asset, &q, beside), |two| {
            for [a, b] in two.with_kernels() {
                let mut found: Vec<[LaneId; 2]> = Vec::new();
                let mut workspace = Workspace::new();
                let mut query = a.against(b, &mut workspace);
                let coverage = query.level_spheres([0; 2], prediction, reach, &mut found);
                assert_eq!(coverage, Ok(Coverage::Complete));
                assert_eq!(!found.is_empty(), is_near, "{away:e} {reach:e}");
            }
        });
    }
}

#[test]
fn a_level_of_the_query_and_fronts_are_refused() {
    let [model, ..] = &files()[..] else {
        panic!("a file");
    };
    let asset = *model.asset();
    let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
    let pose = (asset.pose(&q, Transform::IDENTITY, &mut memory)).expect("a pose");
    let pose = pose.moving(&Motion::new(&pose)).expect("its motion");
    let mut workspace = Workspace::new();
    let (mut lanes, mut pairs, mut proxies) = (Vec::new(), Vec::new(), Vec::new());
    let ball = Ball::new([1.0, 0.0, 0.0], 0.5);
    let level = QueryError::Argument("max_level: level_spheres has a level of its own");
    let mut query = pose.query(&mut workspace).max_level(0, &mut proxies);
    assert_eq!(query.level_spheres(0, ball, &mut lanes), Err(level));
    for first in [true, false] {
        let query = pose.against(&pose, &mut workspace);
        let mut query = match first {
            true => query.max_level1(0, &mut proxies),
            false => query.max_level2(0, &mut proxies),
        };
        let refused = query.level_spheres([0; 2], 0.0, 0.0, &mut pairs);
        assert_eq!(refused, Err(level));
    }
    let mut front = PairFront::new();
    let query = pose.against(&pose, &mut workspace);
    let mut query = query.front(&mut front);
    let refused = query.level_spheres([0; 2], 0.0, 0.0, &mut pairs);
    let text = "front: level_spheres keeps none";
    assert_eq!(refused, Err(QueryError::Argument(text)));
    assert!(lanes.is_empty() && pairs.is_empty() && proxies.is_empty());
}

/// A proxy names its lane, the same one that `level_spheres` reports.
#[test]
fn proxies_name_their_lanes() {
    let mut rng = poses::rng(5);
    let mut known = 0;
    for model in files() {
        let asset = model.asset();
        let q = poses::random_q(asset, 0.2, &mut rng);
        let place = poses::random_transform(3.0, &mut rng);
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(&q, place, &mut memory).expect("a pose");
        let spheres = Spheres::of(&pose);
        let at = oracle::deformed_triangles(&pose)[0][0];
        let mut workspace = Workspace::new();
        for level in 0..asset.depth() {
            let (mut proxies, mut lanes) = (Vec::new(), Vec::new());
            let ball = Ball::new(at, 0.5 * place.scale);
            let mut contacts: Vec<bdtree_runtime::Contact> = Vec::new();
            let mut query = pose.query(&mut workspace).max_level(level, &mut proxies);
            query.contacts(ball, &mut contacts).expect("ball");
            let ray = Ray::new(at.map(|x| 2.0 * x), at.map(|x| -x));
            query.cast_ray(&ray).expect("ray");
            let mut query = pose.query(&mut workspace);
            query.level_spheres(level, ball, &mut lanes).expect("ball");
            for (k, proxy) in proxies.iter().enumerate() {
                let of = spheres.lanes.iter().find(|lane| lane.lane == proxy.lane);
                let of = of.expect("a lane");
                assert!(of.level == level && !of.is_leaf);
                let near = 1e-9 * (of.radius + spheres.reach) + 16.0 * spheres.error;
                assert!(distance(proxy.center, of.center) <= near);
                assert!((proxy.radius - of.radius).abs() <= near);
                // Those of the ball come first.
                known += usize::from(k < lanes.len() && lanes.contains(&proxy.lane));
            }
        }
    }
    assert!(known > 50, "{known}");
}
