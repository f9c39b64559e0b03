//! Queries beside brute force: none missing, none too many, the same numbers to the last bit.

use bdtree_runtime::{
    AlignedBytes, Asset, Contact, Kernel, PairContact, PairStackEntry, Pose, StackEntry, Transform,
    query,
};
use rand::RngExt;

use crate::{oracle, poses};

/// Runs all single-asset queries for one pose and compares each with the oracle.
///
/// # Panics
/// When an answer differs.
pub fn check_pose(asset: &Asset<'_>, q: &[f32], transform: Transform, seed: u64, rounds: usize) {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, q, transform, &mut memory).expect("pose");
    let triangles = oracle::deformed_triangles(asset, &pose);
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut rng = poses::rng(seed);
    let (low, high) = bounds(&triangles);
    let diagonal = (0..3)
        .map(|k| (high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt();
    for round in 0..rounds {
        let target = triangles[rng.random_range(0..triangles.len())][0];
        let mut point = target;
        if round % 2 == 0 {
            for c in &mut point {
                *c += 0.1 * diagonal * rng.random_range(-1.0..1.0);
            }
        }
        let radius = diagonal * 10_f64.powf(rng.random_range(-3.0..-0.5));

        let mut found: Vec<Contact> = Vec::new();
        let outcome = query::ball(asset, &pose, point, radius, &mut stack, &mut found).unwrap();
        assert!(!outcome.truncated);
        found.sort_by_key(|c| c.triangle);
        let expected = oracle::ball(&triangles, point, radius);
        let ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
        assert_eq!(
            ids,
            expected.iter().map(|e| e.0).collect::<Vec<_>>(),
            "ball at {point:?}, radius {radius}"
        );
        for (contact, (_, distance)) in found.iter().zip(&expected) {
            assert_eq!(contact.dist, distance - radius);
        }

        let limit = if round % 3 == 0 {
            f64::INFINITY
        } else {
            diagonal * rng.random_range(0.0..0.2)
        };
        let near = query::closest(asset, &pose, point, limit, &mut stack).unwrap();
        assert_eq!(
            near.hit.map(|h| (h.triangle.0, h.distance)),
            oracle::closest(&triangles, point, limit),
            "closest to {point:?} within {limit}"
        );

        let mut origin = point;
        let mut direction = [0.0; 3];
        for k in 0..3 {
            origin[k] += diagonal * rng.random_range(-1.0..1.0);
            direction[k] = target[k] - origin[k];
        }
        let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        let unit = unit(direction);
        let limit = if round % 3 == 1 { f64::INFINITY } else { norm };
        let hit = query::ray(asset, &pose, origin, direction, limit, &mut stack).unwrap();
        assert_eq!(
            hit.hit.map(|h| (h.triangle.0, h.distance)),
            oracle::ray(&triangles, origin, unit, limit),
            "ray from {origin:?} along {direction:?} within {limit}"
        );

        let offset = unit[0] * target[0] + unit[1] * target[1] + unit[2] * target[2];
        let mut found: Vec<Contact> = Vec::new();
        query::plane(asset, &pose, direction, offset, &mut stack, &mut found).unwrap();
        let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
        ids.sort_unstable();
        assert_eq!(
            ids,
            oracle::plane(&triangles, unit, offset),
            "plane {unit:?}, offset {offset}"
        );
    }
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    // As the runtime normalises, so that the same ray is asked.
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let v = v.map(|c| c / largest);
    let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|c| c / n)
}

fn bounds(triangles: &[[[f64; 3]; 3]]) -> ([f64; 3], [f64; 3]) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for x in triangles.iter().flatten() {
        for k in 0..3 {
            low[k] = low[k].min(x[k]);
            high[k] = high[k].max(x[k]);
        }
    }
    (low, high)
}

/// The asset once per kernel that this processor has.
pub fn kernels(asset: Asset<'_>) -> impl Iterator<Item = Asset<'_>> {
    [Kernel::Scalar, Kernel::Avx2, Kernel::Neon]
        .into_iter()
        .filter_map(move |k| asset.with_kernel(k))
}

/// Compares pair queries between two instances of a file, for random q and placements up to
/// `gap` sizes apart.
///
/// # Panics
/// When an answer differs.
pub fn check_pairs(bytes: &AlignedBytes, seed: u64, rounds: usize, gap: f64) {
    let asset = Asset::open(bytes).expect("open");
    let mut rng = poses::rng(seed);
    for round in 0..rounds {
        let share = [0.0, 0.05, 0.3][round % 3];
        let qa = poses::random_q(&asset, share, &mut rng);
        let qb = poses::random_q(&asset, share, &mut rng);
        let ta = poses::random_transform(1.0, &mut rng);
        let mut tb = poses::random_transform(1.0, &mut rng);
        let size = poses::diagonal(&asset) * asset.unit();
        for k in 0..3 {
            tb.translation[k] = ta.translation[k] + gap * size * rng.random_range(-1.0..1.0);
        }
        let mut memory_a = vec![0.0; asset.pose_len()];
        let mut memory_b = memory_a.clone();
        let a = Pose::new(&asset, &qa, ta, &mut memory_a).unwrap();
        let b = Pose::new(&asset, &qb, tb, &mut memory_b).unwrap();
        let triangles_a = oracle::deformed_triangles(&asset, &a);
        let triangles_b = oracle::deformed_triangles(&asset, &b);
        for tolerance in [0.0, 0.003 * size] {
            let expected = oracle::pair(&triangles_a, &triangles_b, tolerance);
            for asset in kernels(asset) {
                let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(&asset)];
                let mut found: Vec<PairContact> = Vec::new();
                let outcome = query::pair(
                    (&asset, &a),
                    (&asset, &b),
                    tolerance,
                    &mut stack,
                    &mut found,
                )
                .unwrap();
                assert!(!outcome.truncated);
                let mut ids: Vec<(u32, u32)> = found
                    .iter()
                    .map(|c| (c.triangle1.0, c.triangle2.0))
                    .collect();
                ids.sort_unstable();
                assert_eq!(ids, expected, "round {round}, tolerance {tolerance}");
            }
        }
    }
}
