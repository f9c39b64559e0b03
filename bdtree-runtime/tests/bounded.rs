//! Bounded depth beside brute force: every contact is reported exactly or lies in a reported sphere,
//! with the same bits on every kernel, with and without a cache; at full depth the answer is exact.

use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::oracle::body::Body;
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_runtime::narrow::Triangle;
use bdtree_runtime::{
    Asset, Ball, CacheSize, Contact, ContactManifold, Coverage, Frustum, HalfSpace, Model,
    PairContact, Pose, Proxy, Query, QueryError, Ray, SliceSink, Stats, StepCache, Transform,
    VertexId, Workspace,
};
use rand::RngExt;

/// Pairs of triangles, and the spheres of both sides.
type PairAnswer = (Vec<(u32, u32)>, Vec<Proxy>, Vec<Proxy>);

fn files() -> [Model; 3] {
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
    stats: Stats,
}

/// A ball (even turns) or a plane.
#[derive(Debug, Clone, Copy)]
struct Question {
    is_ball: bool,
    point: [f64; 3],
    size: f64,
}

impl Question {
    fn ask(
        &self,
        pose: &Pose<'_>,
        cache: Option<&mut StepCache<'_>>,
        workspace: &mut Workspace<'_>,
        level: usize,
    ) -> Found {
        let mut contacts: Vec<Contact> = Vec::new();
        let mut proxies = Vec::new();
        let mut query = pose.query(workspace).max_level(level, &mut proxies);
        if let Some(cache) = cache {
            query = query.cached(cache);
        }
        let coverage = if self.is_ball {
            query.contacts(Ball::new(self.point, self.size), &mut contacts)
        } else {
            let offset = self.point[0] - self.size;
            query.contacts(HalfSpace::new([1.0, 0.0, 0.0], offset), &mut contacts)
        };
        assert_eq!(coverage, Ok(Coverage::Complete));
        let stats = query.stats();
        contacts.sort_by_key(|c| c.triangle);
        Found {
            exact: (contacts.iter().map(|c| (c.triangle.0, c.distance))).collect(),
            proxies,
            stats,
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
    let mut workspace = Workspace::new();
    let (mut in_proxies, mut beside) = (0, 0);
    for model in files() {
        let asset = *model.asset();
        assert!(asset.depth() >= 3, "levels to stop at");
        for round in 0..12 {
            let q = poses::random_q(&asset, [0.0, 0.1, 0.5][round % 3], &mut rng);
            let place = poses::random_transform(10.0, &mut rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = asset.pose(&q, place, &mut memory).expect("pose");
            let triangles = oracle::deformed_triangles(&pose);
            let question = Question {
                is_ball: round % 2 == 0,
                point: triangles[rng.random_range(0..triangles.len())][0],
                size: place.scale * rng.random_range(0.01..0.4),
            };
            let expected = question.expected(&triangles);
            for level in 0..=asset.depth() {
                let found = question.ask(&pose, None, &mut workspace, level);
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
                assert!(found.stats.nodes_visited <= asset.node_count_to(level) as u64);
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
    let mut workspace = Workspace::new();
    for model in files() {
        let asset = *model.asset();
        for level in 0..asset.depth() {
            let q = poses::random_q(&asset, 0.2, &mut rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let place = poses::random_transform(3.0, &mut rng);
            let question = Question {
                is_ball: level % 2 == 0,
                point: place.translation,
                size: 0.9 * place.scale,
            };
            let mut cache = StepCache::new(CacheSize {
                leaves: 4,
                ..CacheSize::to_level(&asset, level)
            });
            let pose = asset.pose(&q, place, &mut memory).expect("pose");
            let first = question.ask(&pose, None, &mut workspace, level);
            assert!(first.proxies.len() + first.exact.len() > 0);
            for asset in kernels(&asset) {
                let mut memory = vec![0.0; asset.pose_len()];
                let pose = asset.pose(&q, place, &mut memory).expect("pose");
                cache.start(&pose);
                // Fills the slots with this kernel's own spheres.
                let all = question.ask(&pose, None, &mut workspace, usize::MAX);
                let mut contacts: Vec<Contact> = Vec::new();
                let ball = Ball::new(question.point, question.size);
                let mut query = pose.query(&mut workspace).cached(&mut cache);
                query.contacts(ball, &mut contacts).expect("ball");
                assert!(!question.is_ball || contacts.len() == all.exact.len());
                let mut ask = || question.ask(&pose, Some(&mut cache), &mut workspace, level);
                let (again, kept) = (ask(), ask());
                assert_eq!(again.stats.nodes_visited, first.stats.nodes_visited);
                assert_eq!(
                    (&again.exact, &again.proxies),
                    (&first.exact, &first.proxies)
                );
                assert_eq!(kept.stats.nodes_updated, 0, "every node is kept");
                assert_eq!((kept.exact, kept.proxies), (again.exact, again.proxies));
            }
        }
    }
}

#[test]
fn what_is_nearest_is_found_or_lies_in_a_proxy() {
    let mut rng = poses::rng(10);
    let (mut same, mut other) = (0, 0);
    for model in files() {
        let asset = *model.asset();
        let mut workspace = Workspace::new();
        for round in 0..10 {
            let q = poses::random_q(&asset, 0.2, &mut rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = asset
                .pose(&q, Transform::IDENTITY, &mut memory)
                .expect("pose");
            let triangles = oracle::deformed_triangles(&pose);
            let point = [0; 3].map(|_| rng.random_range(-2.0..2.0));
            let toward = triangles[rng.random_range(0..triangles.len())][1];
            let direction = [0, 1, 2].map(|k| toward[k] - point[k]);
            for level in 0..=asset.depth() {
                let mut proxies = Vec::new();
                let ray = Ray::new(point, direction);
                let ask = |mut query: Query<'_, '_>| {
                    if round % 2 == 0 {
                        let near = query.project_point(point, f64::INFINITY).expect("near");
                        near.map(|near| (near.triangle.0, near.distance))
                    } else {
                        let hit = query.cast_ray(&ray).expect("hit");
                        hit.map(|hit| (hit.triangle.0, hit.distance))
                    }
                };
                let best = ask(pose.query(&mut workspace));
                let found = ask(pose.query(&mut workspace).max_level(level, &mut proxies));
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
    asset: &'m Asset<'m>,
    seed: u64,
    memory: &'m mut [Vec<f32>; 2],
) -> (Pose<'m>, Pose<'m>) {
    let mut rng = poses::rng(seed);
    let [first, second] = memory;
    let q = poses::random_q(asset, 0.2, &mut rng);
    let place = poses::random_transform(1.0, &mut rng);
    let a = asset.pose(&q, place, first).expect("a");
    let q = poses::random_q(asset, 0.2, &mut rng);
    let place = poses::random_transform(1.0, &mut rng);
    let b = asset.pose(&q, place, second).expect("b");
    (a, b)
}

#[test]
fn pairs_are_reported_or_lie_in_proxies() {
    let mut workspace = Workspace::new();
    let (mut in_proxies, mut in_leaves) = (0, 0);
    for (seed, model) in files().iter().enumerate() {
        let asset = *model.asset();
        let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
        let (a, b) = two_poses(&asset, seed as u64, &mut memory);
        let triangles = [&a, &b].map(oracle::deformed_triangles);
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
                for asset in kernels(&asset) {
                    let (mut proxies_a, mut proxies_b) = (Vec::new(), Vec::new());
                    let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
                    let (a, b) = two_poses(&asset, seed as u64, &mut memory);
                    let mut contacts: Vec<PairContact> = Vec::new();
                    let mut query = (a.against(&b, &mut workspace))
                        .max_level1(levels.0, &mut proxies_a)
                        .max_level2(levels.1, &mut proxies_b);
                    let coverage = query.contacts(tolerance, &mut contacts);
                    assert_eq!(coverage, Ok(Coverage::Complete));
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
    let [model, ..] = files();
    let asset = *model.asset();
    let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
    let (a, b) = two_poses(&asset, 0, &mut memory);
    let mut workspace = Workspace::new();
    let mut contacts: Vec<PairContact> = Vec::new();
    let mut all = Vec::new();
    let mut query = (a.against(&b, &mut workspace)).max_level2(1, &mut all);
    query.contacts(0.0, &mut contacts).expect("pair");
    assert!(all.len() > 2);
    for room in [0, 1, all.len() - 1, all.len()] {
        let mut room = vec![Proxy::EMPTY; room];
        let mut sink = SliceSink::new(&mut room);
        let mut query = (a.against(&b, &mut workspace)).max_level2(1, &mut sink);
        let coverage = query.contacts(0.0, &mut contacts).expect("pair");
        let is_short = sink.items().len() < all.len();
        assert_eq!(coverage == Coverage::Truncated, is_short);
        assert_eq!(*sink.items(), all[..sink.items().len()]);
    }
    // A full sink is no hit: what cannot say that its answer is incomplete is refused, and a hit counts.
    let mut full = SliceSink::new(&mut []);
    let mut query = a.against(&b, &mut workspace).max_level2(0, &mut full);
    assert_eq!(query.intersects(), Err(QueryError::Proxies));
    let at = a.deformed(VertexId(0)).expect("vertex");
    let ray = Ray::new(at.map(|x| 3.0 * x), at.map(|x| -x));
    let mut full = SliceSink::new(&mut []);
    let mut query = a.query(&mut workspace).max_level(0, &mut full);
    assert_eq!(
        query.intersects(Ball::new(at, 0.1)),
        Err(QueryError::Proxies)
    );
    assert_eq!(query.intersects_ray(&ray), Err(QueryError::Proxies));
    assert_eq!(query.cast_ray(&ray), Err(QueryError::Proxies));
    assert_eq!(
        query.cast_rays(&[ray], &mut [None]),
        Err(QueryError::Proxies)
    );
    assert_eq!(
        query.intersects_rays(&[ray], &mut [false]),
        Err(QueryError::Proxies)
    );
    assert_eq!(query.project_point(at, 1.0), Err(QueryError::Proxies));
    // Far from everything no sphere is reported, and at the last level none is needed.
    let far = Ball::new([1e3; 3], 0.1);
    assert_eq!(query.intersects(far), Ok(false));
    let mut full = SliceSink::new(&mut []);
    let mut query = a
        .query(&mut workspace)
        .max_level(asset.depth() - 1, &mut full);
    assert_eq!(query.intersects(Ball::new(at, 0.1)), Ok(true));
    assert_eq!(query.intersects_ray(&ray), Ok(true));
    // The same of one tree, and its refusals.
    let mut sink = SliceSink::new(&mut []);
    let mut none: Vec<Contact> = Vec::new();
    let ball = Ball::new(a.deformed(VertexId(0)).expect("vertex"), 0.1);
    let mut query = a.query(&mut workspace).max_level(0, &mut sink);
    assert_eq!(query.contacts(ball, &mut none), Ok(Coverage::Truncated));
    let mut sink = Vec::new();
    let mut small = [0; 64];
    let mut small = Workspace::in_bytes(&mut small);
    let mut query = a.query(&mut small).max_level(0, &mut sink);
    let short = query.contacts(ball, &mut none);
    assert!(matches!(short, Err(QueryError::Memory { .. })));
}

/// What has no answer down to a level says so, and says which option is in the way.
#[test]
fn questions_without_levels_refuse_one() {
    let [model, ..] = files();
    let asset = *model.asset();
    let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
    let (a, b) = two_poses(&asset, 0, &mut memory);
    let mut workspace = Workspace::new();
    let mut refused = Vec::new();
    let mut refuse = |error: Option<QueryError>| match error {
        Some(QueryError::Argument(text)) if text.starts_with("max_level: ") => refused.push(text),
        other => panic!("{other:?}"),
    };
    let mut sink = Vec::new();
    let mut contacts: Vec<Contact> = Vec::new();
    let mut manifolds: Vec<ContactManifold> = Vec::new();
    let planes = Frustum::new(&[[0.0, 0.0, 1.0, 0.0]]).expect("planes");
    let mut query = a.query(&mut workspace).max_level(1, &mut sink);
    refuse(query.frustum_state(&planes).err());
    let mut query = query.max_visits(9);
    refuse(
        query
            .contacts(Ball::new([0.0; 3], 1.0), &mut contacts)
            .err(),
    );
    refuse(query.project_point([0.0; 3], 1.0).err());
    refuse(query.cast_ray(&Ray::new([0.0; 3], [1.0; 3])).err());
    for first in [true, false] {
        let query = a.against(&b, &mut workspace);
        let mut query = if first {
            query.max_level1(1, &mut sink)
        } else {
            query.max_level2(1, &mut sink)
        };
        refuse(query.contact_manifolds(0.0, &mut manifolds).err());
        refuse(query.closest_points(1.0).err());
        refuse(query.distance(1.0).err());
        refuse(query.max_visits(9).closest_points(1.0).err());
    }
    assert_eq!(refused.len(), 12);
    assert!(sink.is_empty() && contacts.is_empty() && manifolds.is_empty());
}
