//! Node spheres kept over steps (paper, eqs. 8–11): answers are those without, updates are saved, and a
//! reference of another step is refused.

use bdtree_fixtures::{bake, compare, poses};
use bdtree_runtime::studies::{follow, growth, next_step};
use bdtree_runtime::{
    Ball, CacheSize, Contact, HalfSpace, Model, PairContact, PairQuery, Query, QueryError, Ray,
    Shape, StepCache, Transform, VertexId, Workspace,
};
use rand::RngExt;

fn cache(nodes: usize, leaves: usize) -> StepCache<'static> {
    StepCache::new(CacheSize { nodes, leaves })
}

fn bumpy() -> Model {
    let mesh = bake::bumpy_sphere(20, 3);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 7, 4))
}

/// Ball, ray, nearest point and plane answers at a pose, with and without what is kept.
fn check(mut plain: Query<'_, '_>, mut kept: Query<'_, '_>, center: [f64; 3], size: f64) {
    let both = |plain: &mut Query<'_, '_>, kept: &mut Query<'_, '_>, shape: Shape| {
        let [mut without, mut with] = [Vec::new(), Vec::new()];
        plain.contacts(shape, &mut without).unwrap();
        kept.contacts(shape, &mut with).unwrap();
        without.sort_by_key(|c: &Contact| c.triangle);
        with.sort_by_key(|c: &Contact| c.triangle);
        assert_eq!(without, with);
        without.len()
    };
    let balls = [0.02, 0.1].map(|share| {
        let ball = Ball::new(center, share * size);
        both(&mut plain, &mut kept, ball.into())
    });
    assert!(balls[1] > 0, "the larger ball touches");
    assert_eq!(
        plain.project_point(center, f64::INFINITY),
        kept.project_point(center, f64::INFINITY)
    );
    let origin = [center[0] + 2.0 * size, center[1] - size, center[2] + size];
    let along = [0, 1, 2].map(|k| center[k] - origin[k]);
    let ray = Ray::new(origin, along);
    assert_eq!(plain.cast_ray(&ray), kept.cast_ray(&ray));
    let offset = (0..3).map(|k| along[k] * center[k]).sum::<f64>()
        / along.iter().map(|x| x * x).sum::<f64>().sqrt();
    both(&mut plain, &mut kept, HalfSpace::new(along, offset).into());
}

/// A walk of q with steps of `step` of the diagonal, an epoch every `epoch` steps.
fn walk(model: &Model, slots: (usize, usize), step: f64, epoch: usize, seed: u64) {
    let [mut plain, mut cached] = [Workspace::new(), Workspace::new()];
    for asset in compare::kernels(model.asset()) {
        let mut rng = poses::rng(seed);
        let mut cache = cache(slots.0, slots.1);
        let size = poses::diagonal(&asset) * asset.unit();
        let mut q = poses::random_q(&asset, 0.1, &mut rng);
        let mut reference_q = q.clone();
        for time in 0..9 {
            let place = poses::random_transform(size, &mut rng);
            let (mut memory, mut reference_memory) =
                (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
            let pose = asset.pose(&q, place, &mut memory).unwrap();
            // The reference may stand anywhere: nodes do not see placements.
            let here = Transform::IDENTITY;
            let reference = asset.pose(&reference_q, here, &mut reference_memory);
            let reference = reference.unwrap();
            let at_start = time % epoch == 0;
            let mut kept = if at_start {
                cache.start(&pose);
                pose.query(&mut cached).cached(&mut cache)
            } else {
                next_step(&mut cache, &reference);
                follow(pose.query(&mut cached), &mut cache, &reference)
            };
            let growth = growth(&mut kept).unwrap();
            assert_eq!(growth == 0.0, at_start, "growth {growth}");
            let vertex = rng.random_range(0..asset.vertex_count() as u32);
            let center = pose.deformed(VertexId(vertex)).unwrap();
            check(pose.query(&mut plain), kept, center, size * place.scale);
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
    let model = bumpy();
    for (round, slots) in [(0, 0), (1, 1), (13, 7), (4096, 4096)]
        .into_iter()
        .enumerate()
    {
        for (step, epoch) in [(0.001, 4), (0.02, 3), (0.3, 9)] {
            walk(&model, slots, step, epoch, 10 + round as u64);
        }
    }
}

#[test]
fn local_fields_follow_too() {
    let (mesh, basis) = bake::face_with_shapes();
    let model = bake::baked(&mesh, &basis);
    walk(&model, (512, 128), 0.01, 5, 3);
}

fn sorted(mut query: PairQuery<'_, '_, '_>, tolerance: f64) -> Vec<PairContact> {
    let mut contacts: Vec<PairContact> = Vec::new();
    query.contacts(tolerance, &mut contacts).unwrap();
    contacts.sort_by_key(|c| (c.triangle1, c.triangle2));
    contacts
}

#[test]
fn pairs_follow() {
    let model = bumpy();
    let asset = *model.asset();
    let mut rng = poses::rng(5);
    let size = poses::diagonal(&asset) * asset.unit();
    let mut caches = [cache(64, 64), cache(4096, 16)];
    let [mut workspace, mut second] = [Workspace::new(), Workspace::new()];
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
            asset.pose(&q[0], places[0], m0).unwrap(),
            asset.pose(&q[1], places[1], m1).unwrap(),
        ];
        let references = [
            asset.pose(&reference_q[0], places[1], m2).unwrap(),
            asset.pose(&reference_q[1], places[0], m3).unwrap(),
        ];
        let start = time % 4 == 0;
        for k in 0..2 {
            match start {
                true => caches[k].start(&poses_now[k]),
                false => next_step(&mut caches[k], &references[k]),
            }
        }
        for tolerance in [0.0, 0.01 * size] {
            let [c0, c1] = &mut caches;
            let query = poses_now[0].against(&poses_now[1], &mut workspace);
            let plain = sorted(query, tolerance);
            let cached = if start {
                let query = poses_now[0].against(&poses_now[1], &mut workspace);
                sorted(query.cached(c0, c1), tolerance)
            } else {
                let first = follow(poses_now[0].query(&mut workspace), c0, &references[0]);
                let second = follow(poses_now[1].query(&mut second), c1, &references[1]);
                sorted(first.against(second), tolerance)
            };
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
    let model = bumpy();
    let asset = *model.asset();
    let mut rng = poses::rng(8);
    let size = poses::diagonal(&asset) * asset.unit();
    let [mut workspace, mut second] = [Workspace::new(), Workspace::new()];
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
                asset.pose(&far[0], places[0], m0).unwrap(),
                asset.pose(&far[1], places[1], m1).unwrap(),
            ];
            let near = [
                asset.pose(&near[0], places[0], m2).unwrap(),
                asset.pose(&near[1], places[1], m3).unwrap(),
            ];
            let mut caches = [cache(64, 64), cache(4096, 16)];
            let [c0, c1] = &mut caches;
            c0.start(&far[0]);
            c1.start(&far[1]);
            let plain = sorted(near[0].against(&near[1], &mut workspace), 0.0);
            let kept = follow(near[0].query(&mut workspace), c0, &far[0]);
            let kept = kept.against(follow(near[1].query(&mut second), c1, &far[1]));
            let followed = sorted(kept, 0.0);
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
    let model = bumpy();
    let asset = *model.asset();
    let mut workspace = Workspace::new();
    let mut cache = cache(asset.node_count(), 0);
    let ball = |mut query: Query<'_, '_>| {
        let mut contacts: Vec<Contact> = Vec::new();
        let answer = query.contacts(Ball::new([0.9, 0.1, 0.1], 0.3), &mut contacts);
        answer.map(|_| query.stats())
    };
    let (mut m0, mut m1) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
    let q = vec![0.1; asset.mode_count()];
    let reference = asset.pose(&q, Transform::IDENTITY, &mut m0).unwrap();
    cache.start(&reference);
    let first = ball(reference.query(&mut workspace).cached(&mut cache)).unwrap();
    assert_eq!(first.nodes_updated, first.nodes_visited);
    let second = ball(reference.query(&mut workspace).cached(&mut cache)).unwrap();
    assert_eq!(
        (second.nodes_updated, second.nodes_visited),
        (0, first.nodes_visited)
    );

    let next: Vec<f32> = q.iter().map(|q| q + 1e-3).collect();
    let pose = asset.pose(&next, Transform::IDENTITY, &mut m1).unwrap();
    next_step(&mut cache, &reference);
    let third = ball(follow(pose.query(&mut workspace), &mut cache, &reference)).unwrap();
    assert!(third.nodes_visited >= 1);
    assert!(third.nodes_updated * 4 <= third.nodes_visited, "{third:?}");

    // The reference is the pose of the last start, no other, and of the same asset.
    let refused = ball(follow(reference.query(&mut workspace), &mut cache, &pose));
    assert_eq!(refused, Err(QueryError::Cache));
    let other = bumpy();
    let mut memory = vec![0.0; asset.pose_len()];
    let stranger = other.asset().pose(&next, Transform::IDENTITY, &mut memory);
    let stranger = stranger.unwrap();
    let refused = ball(follow(
        stranger.query(&mut workspace),
        &mut cache,
        &reference,
    ));
    assert_eq!(refused, Err(QueryError::Cache));
}
