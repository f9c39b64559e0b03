//! Every query on a case, beside brute force.

use bdtree_runtime::{Asset, Pose, RayHit, StackEntry, Transform, query};

use super::bounded::check_bounded;
use super::front::check_front;
use super::{HardCase, placements};
use crate::body::Body;
use crate::budgets::check_budgets;
use crate::compare::{check_pose, extent, kernels};
use crate::compare_cached::check_cached;
use crate::near;
use crate::pair_caches::PairCaches;
use crate::{oracle, poses};

/// Triangles up to which bodies that are all in one place are compared pair by pair: there brute force
/// and query meet the square of their number.
const COLLAPSED_MAX: usize = 400;

/// Random questions of each kind that a short run asks.
pub const ROUNDS: usize = 3;

/// A q and where the body is.
pub type Placed = (Vec<f32>, Transform);

/// Asks everything about a case at each of its q and of its frames, in all placements for single-asset
/// queries and in one after the other for the rest, with every kernel; `rounds` random questions of
/// each kind, and with more than [`ROUNDS`] all pairs of large meshes too. Returns how many pairs of q and placement were asked about.
///
/// # Panics
/// When an answer differs from brute force, or the file is not sound.
pub fn check_case(case: &HardCase, rounds: usize) -> usize {
    let bytes = case.bake();
    let asset = Asset::open(&bytes).expect("open");
    let is_sound = asset.verify(&mut |e| {
        println!("{}: {e}", case.name);
        core::ops::ControlFlow::Continue(())
    });
    assert!(is_sound, "{}", case.name);
    let mut asked = 0;
    for (i, q) in case.poses(&asset).iter().enumerate() {
        let places = placements();
        for (k, (_, place)) in places.iter().enumerate() {
            check_pose(kernels(asset), q, *place, (7 * i + k) as u64, rounds);
            asked += 1;
        }
        let turn = |n: usize| places[(i + n) % places.len()].1;
        for n in [0, 3] {
            rays_at(&asset, q, turn(n));
            check_bounded(&asset, q, turn(n));
        }
        check_pairs_of(&asset, (q, turn(0)), i, rounds > ROUNDS);
        let steps: Vec<Placed> = vec![(q.clone(), turn(1)), (q.clone(), turn(2))];
        let any = kernels(asset).count();
        let asset = kernels(asset).nth(i % any).expect("a kernel");
        check_cached(&asset, &steps, i as u64, 1);
        check_budgets(&asset, q, turn(4), i as u64, 2);
        check_front(&asset, q, turn(5));
    }
    for t in 0..asset.frame_count() {
        let frame = asset.frame(t).expect("a frame");
        for (k, (_, place)) in placements().iter().enumerate() {
            let placed = place.after(frame.transform()).expect("a placement");
            check_pose(kernels(asset), frame.q(), placed, k as u64, rounds);
            asked += 1;
        }
        rays_at(&asset, frame.q(), frame.transform());
        check_pairs_of(&asset, (frame.q(), frame.transform()), t, rounds > ROUNDS);
    }
    asked
}

/// Rays exactly at corners, edges and along the planes of triangles, first, any, all and as a batch,
/// with every kernel.
///
/// # Panics
/// When an answer differs from brute force.
pub fn rays_at(asset: &Asset<'_>, q: &[f32], place: Transform) {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, q, place, &mut memory).expect("pose");
    let body = oracle::deformed_triangles(asset, &pose);
    let rays = aimed(&body);
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut expected = Vec::new();
    for r in &rays {
        let mut hits = oracle::ray_all(&body, r.origin, oracle::unit(r.direction), r.max_distance);
        hits.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        expected.push(hits);
    }
    let first: Vec<_> = expected.iter().map(|hits| hits.first().copied()).collect();
    for asset in kernels(*asset) {
        let ids = |hit: RayHit| (hit.triangle.0, hit.distance);
        for (r, expected) in rays.iter().zip(&expected) {
            let (o, d, limit) = (r.origin, r.direction, r.max_distance);
            let hit = query::ray(&asset, &pose, o, d, limit, &mut stack).expect("ray");
            assert_eq!(hit.hit.map(ids), expected.first().copied(), "{r:?}");
            let any = query::ray_any(&asset, &pose, o, d, limit, &mut stack).expect("ray");
            assert_eq!(any.hit, !expected.is_empty(), "{r:?}");
            let mut hits: Vec<RayHit> = Vec::new();
            query::ray_all(&asset, &pose, o, d, limit, &mut stack, &mut hits).expect("ray");
            let mut hits: Vec<_> = hits.into_iter().map(ids).collect();
            hits.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            assert_eq!(hits, *expected, "{r:?}");
        }
        let mut found = vec![None; rays.len()];
        query::rays(&asset, &pose, &rays, &mut stack, &mut found).expect("rays");
        let found: Vec<_> = found.into_iter().map(|hit| hit.map(ids)).collect();
        assert_eq!(found, first);
    }
}

/// Rays that meet a dozen triangles where it is hard to say.
fn aimed(body: &[bdtree_runtime::narrow::Triangle]) -> Vec<query::Ray> {
    let size = extent(body);
    let middle = [0, 1, 2].map(|k| body.iter().map(|t| t[0][k]).sum::<f64>() / body.len() as f64);
    let mut rays = Vec::new();
    let mut add = |origin: [f64; 3], direction: [f64; 3], max_distance: f64| {
        if direction != [0.0; 3] {
            rays.push(query::Ray {
                origin,
                direction,
                max_distance,
            });
        }
    };
    for (i, [a, b, c]) in body.iter().step_by(1 + body.len() / 12).enumerate() {
        let between =
            |s: f64, p: &[f64; 3], q: &[f64; 3]| [0, 1, 2].map(|k| p[k] + s * (q[k] - p[k]));
        let edges = [between(0.5, a, b), between(0.3, b, c), between(0.125, c, a)];
        for target in [*a, *b, *c].into_iter().chain(edges) {
            add(middle, minus(target, middle), f64::INFINITY);
            // Along an axis: the target's other coordinates are the ray's to the last bit.
            let mut origin = target;
            origin[i % 3] -= 2.0 * size;
            let mut along = [0.0; 3];
            along[i % 3] = size;
            add(origin, along, f64::INFINITY);
            // Ending at the target, and beginning there.
            add(origin, along, target[i % 3] - origin[i % 3]);
            add(target, along, size);
        }
        // In the triangle's plane: along an edge, across the triangle, through a corner.
        let beyond = |p: &[f64; 3], q: &[f64; 3]| between(-1.0, p, q);
        add(beyond(a, b), minus(*b, *a), f64::INFINITY);
        add(beyond(&edges[0], c), minus(*c, edges[0]), f64::INFINITY);
        add(beyond(c, a), minus(*a, *c), size);
    }
    rays
}

/// The case beside itself: in the same place, moved along an axis by less and more than its size, at
/// another q: pairs with and without tolerance and distances, with every kernel and cache. A share of
/// these questions that `turn` picks, the smaller the more crowded the body is; all of them where
/// `is_long`; none where a body of many triangles has collapsed to a point.
///
/// # Panics
/// When an answer differs from brute force.
pub fn check_pairs_of(
    asset: &Asset<'_>,
    (q, place): (&[f32], Transform),
    turn: usize,
    is_long: bool,
) {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, q, place, &mut memory).expect("pose");
    let body = oracle::deformed_triangles(asset, &pose);
    if has_collapsed(&body) {
        return;
    }
    let size = extent(&body);
    // What brute force and query have to do with each other at least.
    let step = match oracle::pair(&body, &body, 0.0).len() {
        _ if is_long => 1,
        0..=1000 => 3,
        1001..=6000 => 7,
        _ => 16,
    };
    let other = poses::random_q(asset, 0.1, &mut poses::rng(3));
    let mut caches = PairCaches::new(asset);
    let shifts = [(0.0, q), (0.25, q), (0.5, &other[..]), (1.5, q)];
    let questions = shifts.iter().flat_map(|s| [(*s, 0.0), (*s, 1e-3 * size)]);
    for (_, ((shift, q2), tolerance)) in (0..).zip(questions).filter(|(i, _)| asked(*i, turn, step))
    {
        let mut moved = place;
        moved.translation[0] += shift * size;
        near::two(*asset, q, place, *asset, q2, moved, |two| {
            let [a, b] = two.triangles();
            let expected = oracle::pair(&a, &b, tolerance);
            for asset in kernels(*asset) {
                let found = caches.pairs(&asset, [&two.a, &two.b], tolerance);
                assert_eq!(found, expected, "shift {shift}, tolerance {tolerance}");
            }
            if tolerance == 0.0 {
                two.check_distance(&format!("shift {shift}"));
            }
        });
    }
}

/// Whether so many triangles are in one place that pairs of them are not asked for.
pub(super) fn has_collapsed(body: &Body) -> bool {
    let coordinates = body.iter().flatten().flatten();
    let far = coordinates.fold(0.0, |m: f64, x| m.max(x.abs()));
    extent(body) < far * 2_f64.powi(-32) && body.len() > COLLAPSED_MAX
}

/// Whether question `i` is one of those that are asked in this turn: each step-th, and in `step` turns all.
fn asked(i: usize, turn: usize, step: usize) -> bool {
    // No step has 5 as a factor.
    (i + 5 * turn).is_multiple_of(step)
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use super::asked;

    #[test]
    fn all_questions_come_in_turn() {
        for step in [1, 3, 7, 16] {
            for i in 0..8 {
                let turns = (0..step).filter(|turn| asked(i, *turn, step)).count();
                assert_eq!(turns, 1, "question {i}, step {step}");
            }
        }
    }
}
