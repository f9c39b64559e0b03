//! Spheres of a level against triangles, beside all spheres and all triangles: wherever two meshes stand, with and without
//! modes and bones, at every level, with every kernel and cache; what they refuse.

use bdtree_fixtures::bones::{KINDS, random_matrices};
use bdtree_fixtures::compare::level_triangles::check_level_triangles;
use bdtree_fixtures::compare::near;
use bdtree_fixtures::{oracle, poses};
use bdtree_runtime::{
    Coverage, LaneTriangle, Motion, PairFront, QueryError, Transform, Workspace, narrow,
};
use rand::RngExt;

use crate::bones::creature;
use crate::level_spheres::{files, posed};

#[test]
fn triangles_near_spheres_are_reported() {
    let mut rng = poses::rng(1);
    let mut counts = [0; 2];
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
                let found = check_level_triangles(two.with_kernels(), 4, &mut rng);
                counts = [0, 1].map(|k| counts[k] + found[k]);
            });
        }
    }
    // Many are left out that lie in a leaf whose sphere is near.
    assert!(counts.iter().all(|n| *n > 50_000), "{counts:?}");
}

#[test]
fn the_same_with_bones() {
    let mut rng = poses::rng(3);
    let mut counts = [0; 2];
    for model in [creature(2, 2, true, 1.0, 2), creature(20, 4, false, 1.0, 4)] {
        let asset = model.asset();
        for kind in 0..KINDS {
            let bones = [0; 2].map(|_| random_matrices(asset, kind, &mut rng));
            let q = poses::random_q(asset, 0.2, &mut rng);
            let place = poses::random_transform(1.0, &mut rng);
            let beside = poses::random_transform(2.0, &mut rng);
            posed(asset, &q, &bones[0], place, |a| {
                posed(asset, &q, &bones[1], beside, |b| {
                    let both: Vec<_> = a.iter().zip(b).map(|(a, b)| [*a, *b]).collect();
                    let found = check_level_triangles(&both, 4, &mut rng);
                    counts = [0, 1].map(|k| counts[k] + found[k]);
                });
            });
        }
    }
    assert!(counts.iter().all(|n| *n > 3_000), "{counts:?}");
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
        // Whatever is entered, triangles are measured.
        (1.0, 0.0, far, false),
        (0.0, 0.0, far, true),
    ] {
        let beside = Transform {
            translation: [away, 0.0, 0.0],
            ..small
        };
        near::two((asset, &q, small), (asset, &q, beside), |two| {
            for [a, b] in two.with_kernels() {
                let mut found: Vec<LaneTriangle> = Vec::new();
                let mut workspace = Workspace::new();
                let mut query = a.against(b, &mut workspace);
                let coverage = query.level_triangles(0, prediction, reach, &mut found);
                assert_eq!(coverage, Ok(Coverage::Complete));
                assert_eq!(!found.is_empty(), is_near, "{away:e} {reach:e}");
            }
        });
    }
}

/// Each triangle's distance to the sphere is compared with the prediction to the last bits of f64.
#[test]
fn predictions_are_compared_in_f64() {
    let [model, ..] = &files()[..] else {
        panic!("a file");
    };
    let asset = model.asset();
    let mut rng = poses::rng(5);
    let mut told = 0;
    for _ in 0..20 {
        let q = poses::random_q(asset, 0.2, &mut rng);
        let beside = Transform::from_translation([3.0, 0.4, -0.2]);
        near::two(
            (asset, &q, Transform::IDENTITY),
            (asset, &q, beside),
            |two| {
                let [_, body] = two.triangles();
                let spheres = oracle::spheres::Spheres::of(&two.a);
                let lane = &spheres.lanes[0];
                let triangle = rng.random_range(0..body.len());
                let gap =
                    narrow::closest_point(lane.center, &body[triangle]).distance - lane.radius;
                assert!(gap > 0.0, "apart");
                for (factor, is_near) in [(1.0 + 1e-10, true), (1.0 - 1e-10, false)] {
                    let mut found: Vec<LaneTriangle> = Vec::new();
                    let mut workspace = Workspace::new();
                    let mut query = two.a.against(&two.b, &mut workspace);
                    let coverage = query.level_triangles(0, gap * factor, 1.0, &mut found);
                    assert_eq!(coverage, Ok(Coverage::Complete));
                    let is = |pair: &LaneTriangle| {
                        pair.lane == lane.lane && pair.triangle.0 as usize == triangle
                    };
                    assert_eq!(found.iter().any(is), is_near, "{gap}");
                    told += 1;
                }
            },
        );
    }
    assert_eq!(told, 40);
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
    let (mut pairs, mut proxies) = (Vec::new(), Vec::new());
    let level = QueryError::Argument("max_level: level_triangles has a level of its own");
    for first in [true, false] {
        let query = pose.against(&pose, &mut workspace);
        let mut query = match first {
            true => query.max_level1(0, &mut proxies),
            false => query.max_level2(0, &mut proxies),
        };
        let refused = query.level_triangles(0, 0.0, 0.0, &mut pairs);
        assert_eq!(refused, Err(level));
    }
    let mut front = PairFront::new();
    let query = pose.against(&pose, &mut workspace);
    let mut query = query.front(&mut front);
    let refused = query.level_triangles(0, 0.0, 0.0, &mut pairs);
    let text = "front: level_triangles keeps none";
    assert_eq!(refused, Err(QueryError::Argument(text)));
    assert!(pairs.is_empty() && proxies.is_empty());
}
