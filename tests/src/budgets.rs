//! Budgeted queries: their bounds are true, rise with the budget, and end at the plain answer.

use bdtree_runtime::query::{self, Budget, Budgeted};
use bdtree_runtime::{
    Asset, ClosestPoint, Contact, Pose, RayHit, SearchEntry, SliceSink, StackEntry, Transform,
};
use rand::RngExt;

use crate::{oracle, poses};

/// Asks with rising budgets and memory of `room` entries, and compares with the plain answer. Returns
/// the number of visits with which the answer was complete.
///
/// # Panics
/// When a bound is not true or falls, or a complete answer is another.
pub fn rising<T: Copy + PartialEq + std::fmt::Debug>(
    room: usize,
    exact: Option<T>,
    distance: impl Fn(&T) -> f64,
    limit: f64,
    ask: impl Fn(&mut Budget<'_>) -> Budgeted<Option<T>>,
) -> Option<u64> {
    let mut memory = vec![SearchEntry::default(); room];
    let (mut bound, mut best) = (0.0, f64::INFINITY);
    let truth = exact.as_ref().map_or(limit, &distance);
    for n in [
        0,
        1,
        2,
        3,
        4,
        6,
        8,
        12,
        16,
        24,
        32,
        48,
        64,
        128,
        256,
        512,
        1 << 20,
    ] {
        let answer = ask(&mut Budget::new(n, &mut memory));
        assert!(answer.nodes_visited <= n);
        let found = answer.found.as_ref().map_or(f64::INFINITY, &distance);
        assert!(answer.at_least <= truth, "{n}: {} {truth}", answer.at_least);
        assert!(answer.at_least >= bound, "{n}: {} {bound}", answer.at_least);
        assert!(found >= truth || exact.is_none(), "{n}: {found} {truth}");
        assert!(
            found <= best && found >= answer.at_least,
            "{n}: {found} {best}"
        );
        (bound, best) = (answer.at_least, found);
        if answer.complete {
            assert_eq!(answer.found, exact, "{n}");
            assert_eq!(answer.at_least, truth, "{n}");
            return Some(answer.nodes_visited);
        }
    }
    None
}

/// Nearest points, rays and balls at a pose, with and without enough memory, `rounds` of each.
///
/// # Panics
/// As [`rising`].
pub fn check_budgets(asset: &Asset<'_>, q: &[f32], transform: Transform, seed: u64, rounds: usize) {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, q, transform, &mut memory).expect("pose");
    let triangles = oracle::deformed_triangles(asset, &pose);
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut rng = poses::rng(seed);
    let size = poses::diagonal(asset) * asset.unit() * transform.scale;
    for round in 0..rounds {
        let target = triangles[rng.random_range(0..triangles.len())][0];
        let mut point = target;
        let far = [0.0, 0.1, 1.0, 1e6][round % 4];
        for c in &mut point {
            *c += far * size * rng.random_range(-1.0..1.0);
        }
        for limit in [f64::INFINITY, 0.3 * size] {
            let exact = query::closest(asset, &pose, point, limit, &mut stack).expect("closest");
            let ask = |budget: &mut Budget<'_>| {
                budget.closest(asset, &pose, point, limit).expect("closest")
            };
            let by = |hit: &ClosestPoint| hit.distance;
            let visits = rising(asset.node_count(), exact.hit, by, limit, ask);
            // Best first visits no node that the plain query spares.
            assert!(visits.expect("complete") <= exact.nodes_visited);
            rising(6, exact.hit, by, limit, ask);
            rising(0, exact.hit, by, limit, ask);
        }
        let mut direction = [0, 1, 2].map(|k| target[k] - point[k] + 0.01 * size);
        if direction == [0.0; 3] {
            direction[0] = 1.0; // all in one point
        }
        for limit in [f64::INFINITY, 0.1 * size] {
            let exact = query::ray(asset, &pose, point, direction, limit, &mut stack).expect("ray");
            let ask = |budget: &mut Budget<'_>| {
                let hit = budget.ray(asset, &pose, point, direction, limit);
                hit.expect("ray")
            };
            let by = |hit: &RayHit| hit.distance;
            let visits = rising(asset.node_count(), exact.hit, by, limit, ask);
            assert!(visits.expect("complete") <= exact.nodes_visited);
            rising(6, exact.hit, by, limit, ask);
        }
        check_ball(asset, &pose, point, size * rng.random_range(0.0..0.3));
    }
}

fn check_ball(asset: &Asset<'_>, pose: &Pose<'_>, center: [f64; 3], radius: f64) {
    let triangles = oracle::deformed_triangles(asset, pose);
    let expected = oracle::ball(&triangles, center, radius);
    for room in [asset.node_count(), 6] {
        let mut memory = vec![SearchEntry::default(); room];
        let (mut bound, mut complete) = (f64::NEG_INFINITY, false);
        for n in [0, 1, 2, 4, 8, 16, 32, 64, 1 << 20] {
            let mut found: Vec<Contact> = Vec::new();
            let answer = Budget::new(n, &mut memory).ball(asset, pose, center, radius, &mut found);
            let answer = answer.expect("ball");
            let mut left = expected.clone();
            for contact in &found {
                let at = left.iter().position(|e| e.0 == contact.triangle.0);
                let (_, distance) = left.remove(at.expect("each once, and only hits"));
                assert_eq!(contact.dist, distance - radius);
            }
            for (id, distance) in &left {
                assert!(distance - radius >= answer.at_least, "{id} was left out");
            }
            assert!(answer.found.triangles >= left.len() as u64);
            assert!(!answer.found.truncated && answer.at_least >= bound);
            bound = answer.at_least;
            complete = answer.complete;
            if complete {
                assert_eq!((left.len(), answer.found.triangles), (0, 0));
                assert_eq!(answer.at_least, 0.0);
            }
        }
        assert!(complete || room == 6);
        if expected.len() < 3 {
            continue;
        }
        // A sink that is full: what it has, and a true bound for the rest.
        let mut slots = [Contact::EMPTY; 2];
        let mut sink = SliceSink::new(&mut slots);
        let answer = Budget::new(1 << 20, &mut memory).ball(asset, pose, center, radius, &mut sink);
        let answer = answer.expect("ball");
        assert!(!answer.complete && (answer.found.truncated || room == 6));
        for (id, distance) in &expected {
            let taken = sink.items().iter().any(|c| c.triangle.0 == *id);
            assert!(taken || distance - radius >= answer.at_least);
        }
    }
}
