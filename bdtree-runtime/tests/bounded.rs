//! Bounded depth beside brute force: every contact is reported exactly or lies in a reported sphere,
//! with the same bits on every kernel, with and without a cache; at full depth the answer is exact.

use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::oracle::body::Body;
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_runtime::narrow::Triangle;
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, LeafSlot, NodeSlot, PairContact, PairStackEntry, Pose, Posed,
    Proxy, QueryError, SliceSink, StackEntry, StepCache, Transform, query,
};
use rand::RngExt;

/// Pairs of triangles, and the spheres of both sides.
type PairAnswer = (Vec<(u32, u32)>, Vec<Proxy>, Vec<Proxy>);

fn files() -> [AlignedBytes; 3] {
    let mesh = bake::bumpy_sphere(14, 1);
    [
        bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5)),
        bake::baked(&mesh, &bake::local_basis(&mesh, 9, 5)),
        bake::baked(&mesh, &bake::rigid(&mesh)),
    ]
}

/// Whether a sphere holds a triangle.
fn holds(proxy: &Proxy, triangle: &Triangle) -> bool {
    triangle.iter().all(|x| {
        let square: f64 = (0..3).map(|k| (x[k] - proxy.center[k]).powi(2)).sum();
        square.sqrt() <= proxy.radius
    })
}

/// What a bounded query found: ids and distances, and spheres.
#[derive(Debug, Clone, PartialEq)]
struct Found {
    exact: Vec<(u32, f64)>,
    proxies: Vec<Proxy>,
    nodes_visited: u64,
    nodes_updated: u64,
}

/// A ball (even turns) or a plane.
#[derive(Debug, Clone, Copy)]
struct Question {
    is_ball: bool,
    point: [f64; 3],
    size: f64,
}

impl Question {
    fn ask(&self, asset: &Asset<'_>, posed: Posed<'_>, level: usize) -> Found {
        let mut stack = vec![StackEntry::default(); asset.stack_len()];
        let mut contacts: Vec<Contact> = Vec::new();
        let mut proxies = Vec::new();
        let posed = posed.bounded(level, &mut proxies);
        let outcome = if self.is_ball {
            query::ball(
                asset,
                posed,
                self.point,
                self.size,
                &mut stack,
                &mut contacts,
            )
        } else {
            let offset = self.point[0] - self.size;
            query::plane(
                asset,
                posed,
                [1.0, 0.0, 0.0],
                offset,
                &mut stack,
                &mut contacts,
            )
        };
        let outcome = outcome.expect("a sound asset");
        assert!(!outcome.truncated);
        contacts.sort_by_key(|c| c.triangle);
        Found {
            exact: contacts.iter().map(|c| (c.triangle.0, c.dist)).collect(),
            proxies,
            nodes_visited: outcome.nodes_visited,
            nodes_updated: outcome.nodes_updated,
        }
    }

    fn expected(&self, triangles: &Body) -> Vec<u32> {
        if self.is_ball {
            let all = oracle::ball(triangles, self.point, self.size);
            return all.into_iter().map(|(id, _)| id).collect();
        }
        oracle::plane(triangles, [1.0, 0.0, 0.0], self.point[0] - self.size)
    }
}

#[test]
fn every_contact_is_reported_or_lies_in_a_proxy() {
    let mut rng = poses::rng(8);
    let (mut in_proxies, mut beside) = (0, 0);
    for bytes in files() {
        let asset = Asset::open(&bytes).expect("open");
        assert!(asset.depth() >= 3, "levels to stop at");
        for round in 0..12 {
            let q = poses::random_q(&asset, [0.0, 0.1, 0.5][round % 3], &mut rng);
            let place = poses::random_transform(10.0, &mut rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = Pose::new(&asset, &q, place, &mut memory).expect("pose");
            let triangles = oracle::deformed_triangles(&asset, &pose);
            let question = Question {
                is_ball: round % 2 == 0,
                point: triangles[rng.random_range(0..triangles.len())][0],
                size: place.scale * rng.random_range(0.01..0.4),
            };
            let expected = question.expected(&triangles);
            for level in 0..=asset.depth() {
                let found = question.ask(&asset, Posed::from(&pose), level);
                let exact: Vec<u32> = found.exact.iter().map(|(id, _)| *id).collect();
                for id in &expected {
                    let triangle = &triangles[*id as usize];
                    let is_exact = exact.binary_search(id).is_ok();
                    let is_below = found.proxies.iter().any(|p| holds(p, triangle));
                    assert!(is_exact || is_below, "triangle {id} at level {level}");
                    in_proxies += usize::from(!is_exact);
                    beside += usize::from(is_exact && level + 1 < asset.depth());
                }
                assert!(exact.iter().all(|id| expected.binary_search(id).is_ok()));
                assert!(found.nodes_visited <= asset.node_count_to(level) as u64);
                if level + 1 >= asset.depth() {
                    assert_eq!((exact, found.proxies.len()), (expected.clone(), 0));
                }
            }
        }
    }
    assert!(in_proxies > 1000 && beside > 100, "{in_proxies}, {beside}");
}

#[test]
fn bounded_answers_are_the_same_with_every_kernel_and_cache() {
    let mut rng = poses::rng(9);
    for bytes in files() {
        let asset = Asset::open(&bytes).expect("open");
        for level in 0..asset.depth() {
            let q = poses::random_q(&asset, 0.2, &mut rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let place = poses::random_transform(3.0, &mut rng);
            let pose = Pose::new(&asset, &q, place, &mut memory).expect("pose");
            let question = Question {
                is_ball: level % 2 == 0,
                point: place.translation,
                size: 0.9 * place.scale,
            };
            let slots = vec![NodeSlot::EMPTY; asset.node_count_to(level)];
            let mut cache = StepCache::new(slots, [LeafSlot::EMPTY; 4]);
            let first = question.ask(&asset, Posed::from(&pose), level);
            assert!(first.proxies.len() + first.exact.len() > 0);
            for asset in kernels(asset) {
                let mut cached = cache.start(&pose);
                // Fills the slots with this kernel's own spheres.
                let all = question.ask(&asset, Posed::from(&pose), usize::MAX);
                let mut stack = vec![StackEntry::default(); asset.stack_len()];
                let mut contacts: Vec<Contact> = Vec::new();
                let (point, size) = (question.point, question.size);
                query::ball(&asset, &mut cached, point, size, &mut stack, &mut contacts)
                    .expect("ball");
                assert!(!question.is_ball || contacts.len() == all.exact.len());
                let again = question.ask(&asset, Posed::from(&mut cached), level);
                assert_eq!(again.nodes_visited, first.nodes_visited);
                assert_eq!(
                    (&again.exact, &again.proxies),
                    (&first.exact, &first.proxies)
                );
                let kept = question.ask(&asset, Posed::from(&mut cached), level);
                assert_eq!(kept.nodes_updated, 0, "every node is kept");
                assert_eq!((kept.exact, kept.proxies), (again.exact, again.proxies));
            }
        }
    }
}

#[test]
fn what_is_nearest_is_found_or_lies_in_a_proxy() {
    let mut rng = poses::rng(10);
    let (mut same, mut other) = (0, 0);
    for bytes in files() {
        let asset = Asset::open(&bytes).expect("open");
        let mut stack = vec![StackEntry::default(); asset.stack_len()];
        for round in 0..10 {
            let q = poses::random_q(&asset, 0.2, &mut rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = Pose::new(&asset, &q, Transform::IDENTITY, &mut memory).expect("pose");
            let triangles = oracle::deformed_triangles(&asset, &pose);
            let point = [0; 3].map(|_| rng.random_range(-2.0..2.0));
            let toward = triangles[rng.random_range(0..triangles.len())][1];
            let direction = [0, 1, 2].map(|k| toward[k] - point[k]);
            for level in 0..=asset.depth() {
                let mut proxies = Vec::new();
                let posed = Posed::from(&pose).bounded(level, &mut proxies);
                let no_limit = f64::INFINITY;
                let (found, best) = if round % 2 == 0 {
                    let near = query::closest(&asset, posed, point, no_limit, &mut stack);
                    let best = query::closest(&asset, &pose, point, no_limit, &mut stack);
                    let id = |hit: bdtree_runtime::ClosestPoint| (hit.triangle.0, hit.distance);
                    (
                        near.expect("near").hit.map(id),
                        best.expect("best").hit.map(id),
                    )
                } else {
                    let hit = query::ray(&asset, posed, point, direction, no_limit, &mut stack);
                    let best = query::ray(&asset, &pose, point, direction, no_limit, &mut stack);
                    let id = |hit: bdtree_runtime::RayHit| (hit.triangle.0, hit.distance);
                    (
                        hit.expect("hit").hit.map(id),
                        best.expect("best").hit.map(id),
                    )
                };
                let Some((id, _)) = best else {
                    assert_eq!(found, None);
                    continue;
                };
                let is_below = proxies.iter().any(|p| holds(p, &triangles[id as usize]));
                assert!(found == best || is_below, "triangle {id} at level {level}");
                same += usize::from(found == best);
                other += usize::from(found != best);
                if level + 1 >= asset.depth() {
                    assert_eq!((found, proxies.len()), (best, 0));
                }
            }
        }
    }
    assert!(same > 20 && other > 20, "{same}, {other}");
}

/// Two bodies that touch.
fn two_poses<'m>(
    asset: &Asset<'_>,
    seed: u64,
    memory: &'m mut [Vec<f32>; 2],
) -> (Pose<'m>, Pose<'m>) {
    let mut rng = poses::rng(seed);
    let [first, second] = memory;
    let q = poses::random_q(asset, 0.2, &mut rng);
    let a = Pose::new(asset, &q, poses::random_transform(1.0, &mut rng), first).expect("a");
    let q = poses::random_q(asset, 0.2, &mut rng);
    let b = Pose::new(asset, &q, poses::random_transform(1.0, &mut rng), second).expect("b");
    (a, b)
}

#[test]
fn pairs_are_reported_or_lie_in_proxies() {
    let (mut in_proxies, mut in_leaves) = (0, 0);
    for (seed, bytes) in files().iter().enumerate() {
        let asset = Asset::open(bytes).expect("open");
        let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
        let (a, b) = two_poses(&asset, seed as u64, &mut memory);
        let triangles = [&a, &b].map(|pose| oracle::deformed_triangles(&asset, pose));
        let last = asset.depth();
        for tolerance in [0.0, 0.01] {
            let expected = oracle::pair(&triangles[0], &triangles[1], tolerance);
            for levels in [
                (0, 0),
                (0, 2),
                (1, 1),
                (1, last),
                (last, 0),
                (2, 2),
                (last, last),
            ] {
                let mut first: Option<PairAnswer> = None;
                for asset in kernels(asset) {
                    let (mut proxies_a, mut proxies_b) = (Vec::new(), Vec::new());
                    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(&asset)];
                    let mut contacts: Vec<PairContact> = Vec::new();
                    let outcome = query::pair(
                        (&asset, Posed::from(&a).bounded(levels.0, &mut proxies_a)),
                        (&asset, Posed::from(&b).bounded(levels.1, &mut proxies_b)),
                        tolerance,
                        &mut stack,
                        &mut contacts,
                    );
                    assert!(!outcome.expect("pair").truncated);
                    let mut ids: Vec<(u32, u32)> = contacts
                        .iter()
                        .map(|c| (c.triangle1.0, c.triangle2.0))
                        .collect();
                    ids.sort_unstable();
                    let found = (ids, proxies_a, proxies_b);
                    match &first {
                        Some(first) => assert_eq!(*first, found, "one answer for all kernels"),
                        None => first = Some(found),
                    }
                }
                let (ids, proxies_a, proxies_b) = first.expect("a kernel");
                assert_eq!(proxies_a.len(), proxies_b.len());
                for (p, q) in proxies_a.iter().zip(&proxies_b) {
                    let square: f64 = (0..3).map(|k| (p.center[k] - q.center[k]).powi(2)).sum();
                    let reach = p.radius + q.radius + tolerance;
                    // SKIP and the map between frames, in f32.
                    assert!(square.sqrt() <= reach * (1.0 + 1e-5), "they meet");
                }
                for (i, j) in &expected {
                    let (ti, tj) = (&triangles[0][*i as usize], &triangles[1][*j as usize]);
                    let is_exact = ids.binary_search(&(*i, *j)).is_ok();
                    let is_below = || {
                        let mut both = proxies_a.iter().zip(&proxies_b);
                        both.any(|(p, q)| holds(p, ti) && holds(q, tj))
                    };
                    assert!(is_exact || is_below(), "({i}, {j}) at levels {levels:?}");
                    in_proxies += usize::from(!is_exact);
                    in_leaves += usize::from(is_exact);
                }
                assert!(ids.iter().all(|id| expected.binary_search(id).is_ok()));
                if levels == (last, last) {
                    assert_eq!((ids, proxies_a.len()), (expected.clone(), 0));
                }
            }
        }
    }
    assert!(
        in_proxies > 1000 && in_leaves > 100,
        "{in_proxies}, {in_leaves}"
    );
}

#[test]
fn one_side_may_be_bounded_and_a_full_sink_is_said() {
    let [bytes, ..] = files();
    let asset = Asset::open(&bytes).expect("open");
    let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
    let (a, b) = two_poses(&asset, 0, &mut memory);
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(&asset)];
    let mut contacts: Vec<PairContact> = Vec::new();
    let mut all = Vec::new();
    let posed = Posed::from(&b).bounded(1, &mut all);
    query::pair(
        (&asset, &a),
        (&asset, posed),
        0.0,
        &mut stack,
        &mut contacts,
    )
    .expect("pair");
    assert!(all.len() > 2);
    for room in [0, 1, all.len() - 1, all.len()] {
        let mut room = vec![Proxy::EMPTY; room];
        let mut sink = SliceSink::new(&mut room);
        let posed = Posed::from(&b).bounded(1, &mut sink);
        let outcome = query::pair(
            (&asset, &a),
            (&asset, posed),
            0.0,
            &mut stack,
            &mut contacts,
        )
        .expect("pair");
        assert_eq!(outcome.truncated, sink.items().len() < all.len());
        assert_eq!(*sink.items(), all[..sink.items().len()]);
    }
    // The same of one tree, and its refusals.
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut sink = SliceSink::new(&mut []);
    let posed = Posed::from(&a).bounded(0, &mut sink);
    let mut none: Vec<Contact> = Vec::new();
    let center = asset
        .deformed(&a, bdtree_runtime::VertexId(0))
        .expect("vertex");
    let outcome = query::ball(&asset, posed, center, 0.1, &mut stack, &mut none).expect("ball");
    assert!(outcome.truncated);
    let mut sink = Vec::new();
    let posed = Posed::from(&a).bounded(0, &mut sink);
    let short = query::ball(&asset, posed, center, 0.1, &mut stack[1..], &mut none);
    assert!(matches!(short, Err(QueryError::Memory { .. })));
    let other = bake::baked(
        &bake::bumpy_sphere(4, 1),
        &bake::rigid(&bake::bumpy_sphere(4, 1)),
    );
    let other = Asset::open(&other).expect("open");
    let posed = Posed::from(&a).bounded(0, &mut sink);
    let wrong = query::ball(&other, posed, center, 0.1, &mut stack, &mut none);
    assert_eq!(wrong, Err(QueryError::PoseMismatch));
}
