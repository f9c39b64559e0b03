//! Single-asset queries with what a step keeps, beside brute force: rays of every kind above all.

use bdtree_runtime::narrow::Triangle;
use bdtree_runtime::{
    Asset, CachedPose, Contact, LeafSlot, NodeSlot, Pose, RayHit, StackEntry, StepCache, Transform,
    query,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::body::Body;
use crate::{oracle, poses};

/// Runs all single-asset queries at these poses with memory for nothing, for one of each, for few
/// and for everything, the same from pose to pose, and compares each answer with the oracle.
///
/// # Panics
/// When an answer or a count differs.
pub fn check_cached(asset: &Asset<'_>, at: &[(Vec<f32>, Transform)], seed: u64, rounds: usize) {
    let everything = (asset.node_count(), asset.triangle_count());
    for (nodes, leaves) in [(0, 0), (1, 1), (5, 0), (0, 9), (13, 40), everything] {
        let mut cache = StepCache::new(vec![NodeSlot::EMPTY; nodes], vec![LeafSlot::EMPTY; leaves]);
        for (step, (q, transform)) in at.iter().enumerate() {
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = Pose::new(asset, q, *transform, &mut memory).expect("pose");
            let triangles = oracle::deformed_triangles(asset, &pose);
            let mut case = Case {
                asset,
                pose: &pose,
                triangles: &triangles,
                cached: cache.start(&pose),
                stack: vec![StackEntry::default(); asset.stack_len()],
                visited: 0,
                updated: 0,
            };
            let mut rng = poses::rng(seed + step as u64);
            for round in 0..rounds {
                case.check_ball_and_closest(&mut rng);
                case.check_rays(&rays(&triangles, round, &mut rng));
            }
            if nodes == 0 {
                assert_eq!(case.updated, case.visited);
            }
            if (nodes, leaves) == everything {
                assert!(case.updated <= asset.node_count() as u64);
                assert!(case.updated < case.visited);
            }
        }
    }
}

struct Case<'s> {
    asset: &'s Asset<'s>,
    pose: &'s Pose<'s>,
    triangles: &'s Body,
    cached: CachedPose<'s>,
    stack: Vec<StackEntry>,
    visited: u64,
    updated: u64,
}

impl Case<'_> {
    fn count(&mut self, [visited, updated]: [u64; 2], visited_alone: u64) {
        assert_eq!(visited, visited_alone, "what is kept changes no visit");
        self.visited += visited;
        self.updated += updated;
    }

    fn check_ball_and_closest(&mut self, rng: &mut Pcg64Mcg) {
        let point = near(self.triangles, rng, 0.1);
        let radius = size(self.triangles) * rng.random_range(0.0..0.1);
        let (asset, pose, stack) = (self.asset, self.pose, &mut self.stack);
        let mut found: Vec<Contact> = Vec::new();
        let mut alone: Vec<Contact> = Vec::new();
        let cached = &mut self.cached;
        let ball = query::ball(asset, cached, point, radius, stack, &mut found).unwrap();
        let same = query::ball(asset, pose, point, radius, stack, &mut alone).unwrap();
        found.sort_by_key(|c| c.triangle);
        alone.sort_by_key(|c| c.triangle);
        assert_eq!(found, alone);
        let distances: Vec<(u32, f64)> = found
            .iter()
            .map(|c| (c.triangle.0, c.dist + radius))
            .collect();
        let expected = oracle::ball(self.triangles, point, radius);
        assert_eq!(distances.len(), expected.len());
        for (found, expected) in distances.iter().zip(&expected) {
            assert_eq!(found.0, expected.0);
        }
        let near = query::closest(asset, &mut self.cached, point, radius, stack).unwrap();
        let near_alone = query::closest(asset, pose, point, radius, stack).unwrap();
        assert_eq!(near.hit, near_alone.hit);
        assert_eq!(
            near.hit.map(|h| (h.triangle.0, h.distance)),
            oracle::closest(self.triangles, point, radius)
        );
        self.count([ball.nodes_visited, ball.nodes_updated], same.nodes_visited);
        self.count(
            [near.nodes_visited, near.nodes_updated],
            near_alone.nodes_visited,
        );
    }

    /// First hits, any hits and all hits, ray by ray and as a batch.
    fn check_rays(&mut self, rays: &[query::Ray]) {
        let mut first_alone = Vec::new();
        let mut all_alone = Vec::new();
        for (i, r) in rays.iter().enumerate() {
            let (asset, pose, stack) = (self.asset, self.pose, &mut self.stack);
            let (o, d, limit) = (r.origin, r.direction, r.max_distance);
            let mut expected = oracle::ray_all(self.triangles, o, oracle::unit(d), limit);
            expected.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            let hit = query::ray(asset, &mut self.cached, o, d, limit, stack).unwrap();
            let alone = query::ray(asset, pose, o, d, limit, stack).unwrap();
            assert_eq!(
                hit.hit.map(|h| (h.triangle.0, h.distance)),
                expected.first().copied(),
                "{r:?}"
            );
            assert_eq!(hit.hit, alone.hit);
            let any = query::ray_any(asset, &mut self.cached, o, d, limit, stack).unwrap();
            let any_alone = query::ray_any(asset, pose, o, d, limit, stack).unwrap();
            assert_eq!(any.hit, !expected.is_empty(), "{r:?}");
            let mut hits: Vec<RayHit> = Vec::new();
            let cached = &mut self.cached;
            let all = query::ray_all(asset, cached, o, d, limit, stack, &mut hits).unwrap();
            let mut sorted: Vec<(u32, f64)> =
                hits.iter().map(|h| (h.triangle.0, h.distance)).collect();
            sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            assert_eq!(sorted, expected, "{r:?}");
            let mut same: Vec<RayHit> = Vec::new();
            let all_one = query::ray_all(asset, pose, o, d, limit, stack, &mut same).unwrap();
            assert_eq!(hits.len(), same.len());
            first_alone.push(hit.hit);
            all_alone.extend(hits.into_iter().map(|h| (i, h)));
            self.count([hit.nodes_visited, hit.nodes_updated], alone.nodes_visited);
            self.count(
                [any.nodes_visited, any.nodes_updated],
                any_alone.nodes_visited,
            );
            self.count(
                [all.nodes_visited, all.nodes_updated],
                all_one.nodes_visited,
            );
        }
        let (asset, cached, stack) = (self.asset, &mut self.cached, &mut self.stack);
        let mut firsts = vec![None; rays.len()];
        query::rays(asset, &mut *cached, rays, stack, &mut firsts).unwrap();
        assert_eq!(firsts, first_alone);
        let mut any = vec![false; rays.len()];
        query::rays_any(asset, &mut *cached, rays, stack, &mut any).unwrap();
        let expected: Vec<bool> = first_alone.iter().map(Option::is_some).collect();
        assert_eq!(any, expected);
        let mut all: Vec<(usize, RayHit)> = Vec::new();
        query::rays_all(asset, &mut *cached, rays, stack, &mut all).unwrap();
        assert_eq!(all, all_alone);
    }
}

/// Rays at, along, through and beside triangles, their edges and corners; directions of any length.
fn rays(triangles: &[Triangle], round: usize, rng: &mut Pcg64Mcg) -> Vec<query::Ray> {
    let size = size(triangles);
    let [a, b, c] = triangles[rng.random_range(0..triangles.len())];
    let inside = mix([(a, 0.3), (b, 0.3), (c, 0.4)]);
    let middle = mix([(a, 0.5), (b, 0.5), (c, 0.0)]);
    let away = near(triangles, rng, 1.0);
    let within = mix([(a, 0.5), (triangles[0][0], 0.25), (triangles[0][1], 0.25)]);
    let mut all = Vec::new();
    for target in [inside, a, middle] {
        all.push((away, sub(target, away))); // at a face, a corner, an edge
        all.push((within, sub(target, within))); // from inside, or from the surface
        all.push((target, sub(target, away))); // starting there
        all.push((target, sub(away, target)));
    }
    all.push((mix([(a, 2.0), (b, -1.0), (c, 0.0)]), sub(b, a))); // along an edge
    all.push((a, sub(b, a)));
    all.push((away, sub(near(triangles, rng, 0.2), away))); // perhaps past
    all.push((away, sub(away, inside))); // away from everything
    let far = mix([(inside, 1.0), (sub(away, inside), 1e5), (a, 0.0)]);
    all.push((far, sub(inside, far)));
    all.into_iter()
        .enumerate()
        .filter(|(_, (_, direction))| direction.iter().any(|x| *x != 0.0))
        .map(|(i, (origin, direction))| {
            let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            let max_distance = match (i + round) % 5 {
                0 => length,
                1 => length * rng.random_range(0.0..2.0),
                2 if i % 2 == 0 => 0.01 * size,
                _ => f64::INFINITY,
            };
            query::Ray {
                origin,
                direction,
                max_distance,
            }
        })
        .collect()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn mix(points: [([f64; 3], f64); 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| points.iter().map(|(p, w)| p[k] * w).sum())
}

/// A corner, moved by up to `share` of the size.
fn near(triangles: &[Triangle], rng: &mut Pcg64Mcg, share: f64) -> [f64; 3] {
    let size = size(triangles);
    triangles[rng.random_range(0..triangles.len())][0]
        .map(|x| x + share * size * rng.random_range(-1.0..1.0))
}

/// The largest extent of the box around all triangles.
fn size(triangles: &[Triangle]) -> f64 {
    let extent = |k: usize| {
        let all = triangles.iter().flatten().map(|x| x[k]);
        all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
    };
    extent(0).max(extent(1)).max(extent(2))
}
