//! Node spheres kept over steps (paper, eqs. 8–11): answers are those without, updates are saved, and a
//! reference of another step is refused.

use bdtree_fixtures::{bake, compare, poses};
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, LeafSlot, NodeSlot, PairContact, PairStackEntry, Pose, PoseError,
    StackEntry, StepCache, Transform, query,
};
use rand::RngExt;

type Cache = StepCache<Vec<NodeSlot>, Vec<LeafSlot>>;

fn cache(nodes: usize, leaves: usize) -> Cache {
    StepCache::new(vec![NodeSlot::EMPTY; nodes], vec![LeafSlot::EMPTY; leaves])
}

fn bumpy() -> AlignedBytes {
    let mesh = bake::bumpy_sphere(20, 3);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 7, 4))
}

/// Ball, ray, closest, plane and pair answers at a pose, with and without what is kept.
fn check(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    kept: &mut bdtree_runtime::CachedPose<'_>,
    center: [f64; 3],
    size: f64,
) {
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let balls = [0.02, 0.1].map(|share| {
        let (mut plain, mut cached): (Vec<Contact>, Vec<Contact>) = (Vec::new(), Vec::new());
        query::ball(asset, pose, center, share * size, &mut stack, &mut plain).unwrap();
        query::ball(
            asset,
            &mut *kept,
            center,
            share * size,
            &mut stack,
            &mut cached,
        )
        .unwrap();
        plain.sort_by_key(|c| c.triangle);
        cached.sort_by_key(|c| c.triangle);
        assert_eq!(plain, cached);
        plain.len()
    });
    assert!(balls[1] > 0, "the larger ball touches");
    let plain = query::closest(asset, pose, center, f64::INFINITY, &mut stack).unwrap();
    let cached = query::closest(asset, &mut *kept, center, f64::INFINITY, &mut stack).unwrap();
    assert_eq!(plain.hit, cached.hit);
    let origin = [center[0] + 2.0 * size, center[1] - size, center[2] + size];
    let along = [0, 1, 2].map(|k| center[k] - origin[k]);
    let plain = query::ray(asset, pose, origin, along, f64::INFINITY, &mut stack).unwrap();
    let cached = query::ray(asset, &mut *kept, origin, along, f64::INFINITY, &mut stack).unwrap();
    assert_eq!(plain.hit, cached.hit);
    let offset = (0..3).map(|k| along[k] * center[k]).sum::<f64>()
        / along.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (mut plain, mut cached): (Vec<Contact>, Vec<Contact>) = (Vec::new(), Vec::new());
    query::plane(asset, pose, along, offset, &mut stack, &mut plain).unwrap();
    query::plane(asset, &mut *kept, along, offset, &mut stack, &mut cached).unwrap();
    plain.sort_by_key(|c| c.triangle);
    cached.sort_by_key(|c| c.triangle);
    assert_eq!(plain, cached);
}

/// A walk of q with steps of `step` of the diagonal, an epoch every `epoch` steps.
fn walk(bytes: &AlignedBytes, slots: (usize, usize), step: f64, epoch: usize, seed: u64) {
    let asset = Asset::open(bytes).unwrap();
    for asset in compare::kernels(asset) {
        let mut rng = poses::rng(seed);
        let mut cache = cache(slots.0, slots.1);
        let size = poses::diagonal(&asset) * asset.unit();
        let mut q = poses::random_q(&asset, 0.1, &mut rng);
        let mut reference_q = q.clone();
        for time in 0..9 {
            let place = poses::random_transform(size, &mut rng);
            let (mut memory, mut reference_memory) =
                (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
            let pose = Pose::new(&asset, &q, place, &mut memory).unwrap();
            // The reference may stand anywhere: nodes do not see placements.
            let reference = Pose::new(
                &asset,
                &reference_q,
                Transform::IDENTITY,
                &mut reference_memory,
            )
            .unwrap();
            let at_start = time % epoch == 0;
            let mut kept = if at_start {
                cache.start(&pose)
            } else {
                cache.follow(&asset, &reference, &pose).unwrap()
            };
            let growth = kept.growth(&asset).unwrap();
            assert_eq!(growth == 0.0, at_start, "growth {growth}");
            let vertex = rng.random_range(0..asset.vertex_count() as u32);
            let center = asset
                .deformed(&pose, bdtree_runtime::VertexId(vertex))
                .unwrap();
            check(&asset, &pose, &mut kept, center, size * place.scale);
            if at_start {
                reference_q.clone_from(&q);
            }
            let change = poses::random_q(&asset, step, &mut rng);
            for (q, change) in q.iter_mut().zip(change) {
                *q += change;
            }
        }
    }
}

#[test]
fn answers_are_those_of_fresh_spheres() {
    let bytes = bumpy();
    for (round, slots) in [(0, 0), (1, 1), (13, 7), (4096, 4096)]
        .into_iter()
        .enumerate()
    {
        for (step, epoch) in [(0.001, 4), (0.02, 3), (0.3, 9)] {
            walk(&bytes, slots, step, epoch, 10 + round as u64);
        }
    }
}

#[test]
fn local_fields_follow_too() {
    let (mesh, basis) = bake::face_with_shapes();
    let bytes = bake::baked(&mesh, &basis);
    walk(&bytes, (512, 128), 0.01, 5, 3);
}

#[test]
fn pairs_follow() {
    let bytes = bumpy();
    let asset = Asset::open(&bytes).unwrap();
    let mut rng = poses::rng(5);
    let size = poses::diagonal(&asset) * asset.unit();
    let mut caches = [cache(64, 64), cache(4096, 16)];
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(&asset)];
    let mut reference_q = [0, 1].map(|_| poses::random_q(&asset, 0.1, &mut rng));
    let mut q = reference_q.clone();
    let mut touching = 0;
    for time in 0..12 {
        let places = [0, 1].map(|k| Transform {
            translation: [
                0.42 * size * f64::from(k),
                0.05 * size * f64::from(time % 4),
                0.0,
            ],
            ..Transform::IDENTITY
        });
        let mut memory = [0; 4].map(|_| vec![0.0; asset.pose_len()]);
        let [m0, m1, m2, m3] = &mut memory;
        let poses_now = [
            Pose::new(&asset, &q[0], places[0], m0).unwrap(),
            Pose::new(&asset, &q[1], places[1], m1).unwrap(),
        ];
        let references = [
            Pose::new(&asset, &reference_q[0], places[1], m2).unwrap(),
            Pose::new(&asset, &reference_q[1], places[0], m3).unwrap(),
        ];
        let start = time % 4 == 0;
        let [c0, c1] = &mut caches;
        let (mut kept0, mut kept1) = if start {
            (c0.start(&poses_now[0]), c1.start(&poses_now[1]))
        } else {
            (
                c0.follow(&asset, &references[0], &poses_now[0]).unwrap(),
                c1.follow(&asset, &references[1], &poses_now[1]).unwrap(),
            )
        };
        for tolerance in [0.0, 0.01 * size] {
            let (mut plain, mut cached): (Vec<PairContact>, Vec<PairContact>) = (vec![], vec![]);
            let (a, b) = ((&asset, &poses_now[0]), (&asset, &poses_now[1]));
            query::pair(a, b, tolerance, &mut stack, &mut plain).unwrap();
            let (a, b) = ((&asset, &mut kept0), (&asset, &mut kept1));
            query::pair(a, b, tolerance, &mut stack, &mut cached).unwrap();
            plain.sort_by_key(|c| (c.triangle1, c.triangle2));
            cached.sort_by_key(|c| (c.triangle1, c.triangle2));
            assert_eq!(plain, cached);
            touching += plain.len();
        }
        if start {
            reference_q.clone_from(&q);
        }
        for q in &mut q {
            let change = poses::random_q(&asset, 0.005, &mut rng);
            q.iter_mut()
                .zip(change)
                .for_each(|(q, change)| *q += change);
        }
    }
    assert!(touching > 100, "{touching}");
}

/// Spheres of a pose that reaches much farther than the one that follows it: pairs and their planes
/// allow for where the spheres are evaluated.
#[test]
fn pairs_follow_from_far_away() {
    let bytes = bumpy();
    let asset = Asset::open(&bytes).unwrap();
    let mut rng = poses::rng(8);
    let size = poses::diagonal(&asset) * asset.unit();
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(&asset)];
    let (mut touching, mut apart) = (0, 0);
    for share in [1.0, 10.0, 40.0] {
        for step in 0..12 {
            let far = [0, 1].map(|_| poses::random_q(&asset, share, &mut rng));
            let near = [0, 1].map(|_| poses::random_q(&asset, 0.02, &mut rng));
            let places = [0, 1].map(|k| Transform {
                translation: [
                    (0.4 + 0.03 * f64::from(step)) * size * f64::from(k),
                    0.0,
                    0.0,
                ],
                ..Transform::IDENTITY
            });
            let mut memory = [0; 4].map(|_| vec![0.0; asset.pose_len()]);
            let [m0, m1, m2, m3] = &mut memory;
            let far = [
                Pose::new(&asset, &far[0], places[0], m0).unwrap(),
                Pose::new(&asset, &far[1], places[1], m1).unwrap(),
            ];
            let near = [
                Pose::new(&asset, &near[0], places[0], m2).unwrap(),
                Pose::new(&asset, &near[1], places[1], m3).unwrap(),
            ];
            let mut caches = [cache(64, 64), cache(4096, 16)];
            let [c0, c1] = &mut caches;
            let _ = (c0.start(&far[0]), c1.start(&far[1]));
            let mut kept0 = c0.follow(&asset, &far[0], &near[0]).unwrap();
            let mut kept1 = c1.follow(&asset, &far[1], &near[1]).unwrap();
            let (mut plain, mut followed): (Vec<PairContact>, Vec<PairContact>) = (vec![], vec![]);
            let (a, b) = ((&asset, &near[0]), (&asset, &near[1]));
            query::pair(a, b, 0.0, &mut stack, &mut plain).unwrap();
            let (a, b) = ((&asset, &mut kept0), (&asset, &mut kept1));
            query::pair(a, b, 0.0, &mut stack, &mut followed).unwrap();
            plain.sort_by_key(|c| (c.triangle1, c.triangle2));
            followed.sort_by_key(|c| (c.triangle1, c.triangle2));
            assert_eq!(plain, followed, "share {share}, step {step}");
            touching += usize::from(!plain.is_empty());
            apart += usize::from(plain.is_empty());
        }
    }
    assert!(
        touching > 5 && apart > 5,
        "{touching} touching, {apart} apart"
    );
}

#[test]
fn kept_nodes_are_not_updated_again() {
    let bytes = bumpy();
    let asset = Asset::open(&bytes).unwrap();
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut cache = cache(asset.node_count(), 0);
    let mut ball = |kept: &mut bdtree_runtime::CachedPose<'_>| {
        let mut contacts: Vec<Contact> = Vec::new();
        query::ball(
            &asset,
            kept,
            [0.9, 0.1, 0.1],
            0.3,
            &mut stack,
            &mut contacts,
        )
        .unwrap()
    };
    let (mut m0, mut m1) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
    let q = vec![0.1; asset.mode_count()];
    let reference = Pose::new(&asset, &q, Transform::IDENTITY, &mut m0).unwrap();
    let mut kept = cache.start(&reference);
    let first = ball(&mut kept);
    assert_eq!(first.nodes_updated, first.nodes_visited);
    let second = ball(&mut kept);
    assert_eq!(
        (second.nodes_updated, second.nodes_visited),
        (0, first.nodes_visited)
    );

    let next: Vec<f32> = q.iter().map(|q| q + 1e-3).collect();
    let pose = Pose::new(&asset, &next, Transform::IDENTITY, &mut m1).unwrap();
    let mut kept = cache.follow(&asset, &reference, &pose).unwrap();
    let third = ball(&mut kept);
    assert!(third.nodes_visited >= 1);
    assert!(third.nodes_updated * 4 <= third.nodes_visited, "{third:?}");

    // The reference is the pose of the last start, no other.
    assert_eq!(
        cache.follow(&asset, &pose, &reference).map(|_| ()),
        Err(PoseError::Reference)
    );
    let other_bytes = bumpy();
    let other = Asset::open(&other_bytes).unwrap();
    assert_eq!(
        cache.follow(&other, &reference, &pose).map(|_| ()),
        Err(PoseError::Reference)
    );
}
