//! The broad phase beside all pairs: none missing, none twice, none that is apart, few comparisons.

use std::collections::HashSet;

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::broad::{bytes_for, instance_pairs, pairs};
use bdtree_runtime::{
    BoundingSphere, Coverage, Instance, PairContact, Pose, QueryError, SliceSink, Stats, Workspace,
};
use rand::RngExt;

fn found(spheres: &[BoundingSphere], tolerance: f64) -> (Vec<[usize; 2]>, Stats) {
    let mut memory = vec![0xff; bytes_for(spheres.len())];
    let mut workspace = Workspace::in_bytes(&mut memory);
    let mut found = Vec::new();
    let coverage = pairs(spheres, tolerance, &mut workspace, &mut found);
    assert_eq!(coverage, Ok(Coverage::Complete));
    let mut again = Vec::new();
    // Memory of an earlier step.
    pairs(spheres, tolerance, &mut workspace, &mut again).expect("sound spheres");
    assert_eq!(found, again, "the same order");
    (found, workspace.stats())
}

/// Gap over the reach, below 0 where the spheres meet.
fn gap(a: &BoundingSphere, b: &BoundingSphere, tolerance: f64) -> f64 {
    let square: f64 = (0..3).map(|k| (a.center[k] - b.center[k]).powi(2)).sum();
    let reach = a.radius + b.radius + tolerance;
    (square.sqrt() - reach) / reach.max(f64::MIN_POSITIVE)
}

fn check(spheres: &[BoundingSphere], tolerance: f64) {
    let (list, stats) = found(spheres, tolerance);
    let set: HashSet<[usize; 2]> = list.iter().copied().collect();
    assert_eq!(set.len(), list.len(), "none twice");
    for i in 0..spheres.len() {
        for j in i + 1..spheres.len() {
            let gap = gap(&spheres[i], &spheres[j], tolerance);
            let is_found = set.contains(&[i, j]);
            // Half of what the comparison grants, in which either answer is right.
            assert!(is_found || gap > 0.0, "{i}, {j} missing: gap {gap:e}");
            assert!(!is_found || gap < 1e-12, "{i}, {j} too many: gap {gap:e}");
        }
    }
    assert!(stats.sphere_tests >= list.len() as u64);
}

fn random(
    count: usize,
    spread: f64,
    radius: impl Fn(f64) -> f64,
    seed: u64,
) -> Vec<BoundingSphere> {
    let mut rng = poses::rng(seed);
    (0..count)
        .map(|_| BoundingSphere {
            center: [0; 3].map(|_| spread * rng.random_range(-1.0..1.0)),
            radius: radius(rng.random_range(0.0..1.0)),
        })
        .collect()
}

/// So many spheres.
type Scene = fn(usize) -> Vec<BoundingSphere>;

#[test]
fn pairs_equal_all_pairs() {
    for seed in 0..8 {
        for tolerance in [0.0, 0.3] {
            check(&random(300, 6.0, |u| 0.5 + 0.5 * u, seed), tolerance);
            // Sizes over nine powers of two, and over hundreds.
            check(&random(300, 6.0, |u| 2_f64.powf(-9.0 * u), seed), tolerance);
            check(
                &random(300, 6.0, |u| 2_f64.powf(2.0 - 300.0 * u), seed),
                tolerance,
            );
        }
        check(&random(200, 6.0, |_| 0.0, seed), 0.5);
        check(&random(200, 1e-9, |_| 0.0, seed), 0.0);
    }
    check(&[], 0.0);
    check(&random(1, 1.0, |_| 1.0, 1), 1.0);
}

#[test]
fn touching_spheres_of_a_lattice_are_found() {
    // Whole numbers: distances are exact, neighbours touch exactly, cells end where spheres do.
    for (scale, offset) in [(1.0, 0.0), (0.125, -7.0), (1.0, 1e12), (1e29, 0.0)] {
        let lattice: Vec<BoundingSphere> = (0..343)
            .map(|i| BoundingSphere {
                center: [i % 7, i / 7 % 7, i / 49].map(|c| scale * f64::from(c) + offset),
                radius: 0.5 * scale,
            })
            .collect();
        check(&lattice, 0.0);
        let (list, _) = found(&lattice, 0.0);
        assert_eq!(list.len(), 3 * 6 * 49, "scale {scale}, offset {offset}");
    }
}

#[test]
fn equal_and_far_spheres_are_found() {
    let here = BoundingSphere {
        center: [1.0, -2.0, 3.0],
        radius: 0.0,
    };
    // All in one place: every pair is an answer.
    let (list, stats) = found(&[here; 100], 0.0);
    assert_eq!((list.len(), stats.sphere_tests), (4950, 4950));
    let mut far = random(100, 1.0, |_| 0.5, 3);
    for (i, sphere) in far.iter_mut().enumerate().take(20) {
        sphere.center[i % 3] = 2_f64.powi(5 * i as i32) * if i % 2 == 0 { 1.0 } else { -1.0 };
        sphere.radius *= if i % 5 == 0 {
            2_f64.powi(4 * i as i32)
        } else {
            1.0
        };
    }
    check(&far, 0.0);
    check(&far, 1e3);
}

/// Numbers of spheres at which the comparisons may grow with the spheres, not with their square.
#[test]
fn comparisons_grow_with_the_spheres() {
    let scenes: [(&str, Scene); 4] = [
        ("a lattice", |n| {
            let side = (n as f64).cbrt().ceil() as usize;
            let place = |i: usize| [i % side, i / side % side, i / side / side];
            (0..n)
                .map(|i| BoundingSphere {
                    center: place(i).map(|c| 1.05 * c as f64),
                    radius: 0.5,
                })
                .collect()
        }),
        ("a line", |n| {
            (0..n)
                .map(|i| BoundingSphere {
                    center: [0.01 * i as f64, 0.7 * i as f64, 0.7 * i as f64],
                    radius: 0.5,
                })
                .collect()
        }),
        ("a giant among small ones", |n| {
            let mut all = random(n, (n as f64).cbrt(), |u| 0.4 + 0.1 * u, 5);
            all[n / 2].radius = 1e9;
            all
        }),
        ("one that flew away", |n| {
            let mut all = random(n, (n as f64).cbrt(), |u| 0.4 + 0.1 * u, 6);
            all[0].center = [1e20, -1e28, 0.0];
            all
        }),
    ];
    for (name, scene) in scenes {
        for n in [1000, 8000] {
            let tests = found(&scene(n), 0.0).1.sphere_tests;
            assert!(tests < 60 * n as u64, "{name}: {tests} comparisons of {n}");
        }
    }
}

#[test]
fn what_cannot_be_answered_is_refused() {
    let spheres = random(10, 1.0, |_| 1.0, 1);
    // 32 slots from an address that is a multiple of eight.
    let needed = 32 * 16;
    assert_eq!(bytes_for(10), needed + 8);
    let mut memory = vec![0; needed + 8];
    let start = memory.as_ptr().align_offset(8);
    let memory = &mut memory[start..start + needed];
    let mut sink = Vec::new();
    let mut short = Workspace::in_bytes(&mut memory[..needed - 1]);
    let short = pairs(&spheres, 0.0, &mut short, &mut sink).err();
    let found = needed - 1;
    assert_eq!(short, Some(QueryError::Memory { needed, found }));
    let mut memory = Workspace::in_bytes(memory);
    for (bad, coordinate) in [(f64::NAN, 0), (f64::INFINITY, 2), (1e31, 1)] {
        let mut broken = spheres.clone();
        broken[3].center[coordinate] = bad;
        let error = pairs(&broken, 0.0, &mut memory, &mut sink).err();
        assert!(matches!(error, Some(QueryError::Argument(_))));
        let mut broken = spheres.clone();
        broken[3].radius = bad;
        let error = pairs(&broken, 0.0, &mut memory, &mut sink).err();
        assert!(matches!(error, Some(QueryError::Argument(_))));
        let error = pairs(&spheres, -bad, &mut memory, &mut sink).err();
        assert!(matches!(error, Some(QueryError::Argument(_))));
    }
    // A full sink.
    let (all, _) = self::found(&spheres, 0.0);
    assert!(all.len() > 3);
    for room in [0, 2, all.len()] {
        let mut room = vec![[0; 2]; room];
        let mut sink = SliceSink::new(&mut room);
        let coverage = pairs(&spheres, 0.0, &mut memory, &mut sink).expect("spheres");
        let is_short = sink.items().len() < all.len();
        assert_eq!(coverage == Coverage::Truncated, is_short);
        assert_eq!(*sink.items(), all[..sink.items().len()]);
    }
}

/// Root spheres and grid together miss no pair of bodies that touches.
#[test]
fn touching_bodies_are_pairs_of_the_broad_phase() {
    let mesh = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 5));
    let asset = *model.asset();
    let mut rng = poses::rng(3);
    let mut memory = vec![vec![0.0; asset.pose_len()]; 40];
    let placed: Vec<Pose<'_>> = memory
        .iter_mut()
        .map(|memory| {
            let q = poses::random_q(&asset, 0.2, &mut rng);
            let place = poses::random_transform(6.0, &mut rng);
            asset.pose(&q, place, memory).expect("pose")
        })
        .collect();
    let spheres: Vec<BoundingSphere> = placed
        .iter()
        .map(|pose| pose.bounding_sphere().expect("sphere"))
        .collect();
    let mut workspace = Workspace::new();
    let mut touching = 0;
    for tolerance in [0.0, 0.2] {
        let set: HashSet<[usize; 2]> = found(&spheres, tolerance).0.into_iter().collect();
        assert!(set.len() < 40 * 39 / 4, "some are apart");
        for i in 0..placed.len() {
            for j in i + 1..placed.len() {
                let mut contacts: Vec<PairContact> = Vec::new();
                let mut query = placed[i].against(&placed[j], &mut workspace);
                query.contacts(tolerance, &mut contacts).expect("pair");
                if !contacts.is_empty() {
                    touching += 1;
                    assert!(set.contains(&[i, j]), "{i} touches {j}");
                }
            }
        }
    }
    assert!(touching > 20, "{touching}");
}

/// Instances: the pairs of their spheres, without those whose groups do not meet.
#[test]
fn instances_that_do_not_meet_are_no_pairs() {
    let mesh = bake::bumpy_sphere(6, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 5));
    let mut rng = poses::rng(8);
    let bodies: Vec<Instance> = (0..30)
        .map(|i| {
            let mut body = Instance::new(&model).expect("an instance");
            let q = poses::random_q(model.asset(), 0.2, &mut rng);
            let place = poses::random_transform(3.0, &mut rng);
            body.set_pose(&q, place).expect("a pose");
            body.collision_group = 1 << (i % 3);
            // Group 2 meets itself alone; group 1 meets group 0, which does not meet it.
            body.collision_mask = [0b001, 0b011, 0b100][i % 3];
            body
        })
        .collect();
    let spheres: Vec<BoundingSphere> = bodies
        .iter()
        .map(|body| body.bounding_sphere().expect("sphere"))
        .collect();
    let mut workspace = Workspace::new();
    let mut filtered = Vec::new();
    let coverage = instance_pairs(&bodies, 0.1, &mut workspace, &mut filtered);
    assert_eq!(coverage, Ok(Coverage::Complete));
    let (all, stats) = found(&spheres, 0.1);
    assert_eq!(workspace.stats(), stats);
    let meet = |[i, j]: &[usize; 2]| i % 3 == j % 3;
    let expected: Vec<[usize; 2]> = all.iter().copied().filter(meet).collect();
    assert!(expected.len() > 10 && all.len() > 2 * expected.len());
    assert_eq!(filtered, expected);
    // A full sink ends the search at a pair that meets, not at one that is left out.
    let mut room = [[0; 2]; 5];
    let mut sink = SliceSink::new(&mut room);
    let coverage = instance_pairs(&bodies, 0.1, &mut workspace, &mut sink);
    assert_eq!(coverage, Ok(Coverage::Truncated));
    assert_eq!(*sink.items(), expected[..5]);
}
