//! Queries beside brute force: none missing, none too many, the same numbers to the last bit.

use bdtree_runtime::{AlignedBytes, Asset, Contact, Kernel, Pose, StackEntry, Transform, query};
use rand::RngExt;

use crate::compare_shapes::check_shapes;
use crate::pair_caches::PairCaches;
use crate::{oracle, poses};

/// Runs all single-asset queries for one pose of one asset, opened once or with several kernels, and
/// compares each with the oracle.
///
/// # Panics
/// When an answer differs.
pub fn check_pose<'s>(
    assets: impl IntoIterator<Item = Asset<'s>>,
    q: &[f32],
    transform: Transform,
    seed: u64,
    rounds: usize,
) {
    let assets: Vec<Asset<'_>> = assets.into_iter().collect();
    let mut memories: Vec<_> = assets.iter().map(|a| vec![0.0; a.pose_len()]).collect();
    let pose = |(asset, memory)| {
        let memory: &mut Vec<f32> = memory;
        (
            asset,
            Pose::new(&asset, q, transform, memory).expect("pose"),
        )
    };
    let posed: Vec<Posed<'_>> = assets.into_iter().zip(&mut memories).map(pose).collect();
    check_all(&posed, seed, rounds);
}

/// [`check_pose`] with every kernel for a pose however made.
///
/// # Panics
/// When an answer differs.
pub fn check_posed(asset: &Asset<'_>, pose: &Pose<'_>, seed: u64, rounds: usize) {
    let posed: Vec<Posed<'_>> = kernels(*asset).map(|asset| (asset, *pose)).collect();
    check_all(&posed, seed, rounds);
}

/// An asset of some kernel and a pose.
pub(crate) type Posed<'s> = (Asset<'s>, Pose<'s>);

/// Brute force answers once for all.
fn check_all(posed: &[Posed<'_>], seed: u64, rounds: usize) {
    let (first, pose) = &posed[0];
    let triangles = oracle::deformed_triangles(first, pose);
    for (asset, pose) in &posed[1..] {
        assert_eq!(*oracle::deformed_triangles(asset, pose), *triangles);
    }
    let mut stack = vec![StackEntry::default(); first.stack_len()];
    let mut rng = poses::rng(seed);
    let diagonal = extent(&triangles);
    for (asset, pose) in posed {
        let sphere = query::root_sphere(asset, pose).unwrap();
        for x in triangles.iter().flatten() {
            let v = [0, 1, 2].map(|k| x[k] - sphere.center[k]);
            let distance = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            assert!(distance <= sphere.radius, "{x:?} is outside of {sphere:?}");
        }
    }
    for round in 0..rounds {
        let target = triangles[rng.random_range(0..triangles.len())][0];
        let mut point = target;
        if round % 2 == 0 {
            for c in &mut point {
                *c += 0.1 * diagonal * rng.random_range(-1.0..1.0);
            }
        }
        let radius = diagonal * 10_f64.powf(rng.random_range(-3.0..-0.5));

        let expected: Vec<(u32, f64)> = oracle::ball(&triangles, point, radius)
            .into_iter()
            .map(|(id, distance)| (id, distance - radius))
            .collect();
        for (asset, pose) in posed {
            let mut found: Vec<Contact> = Vec::new();
            let outcome = query::ball(asset, pose, point, radius, &mut stack, &mut found).unwrap();
            assert!(!outcome.truncated);
            found.sort_by_key(|c| c.triangle);
            let found: Vec<(u32, f64)> = found.iter().map(|c| (c.triangle.0, c.dist)).collect();
            assert_eq!(found, expected, "ball at {point:?}, radius {radius}");
        }

        let limit = if round % 3 == 0 {
            f64::INFINITY
        } else {
            diagonal * rng.random_range(0.0..0.2)
        };
        let expected = oracle::closest(&triangles, point, limit);
        for (asset, pose) in posed {
            let near = query::closest(asset, pose, point, limit, &mut stack).unwrap();
            let found = near.hit.map(|h| (h.triangle.0, h.distance));
            assert_eq!(found, expected, "closest to {point:?} within {limit}");
        }

        let mut origin = point;
        let mut direction = [0.0; 3];
        for k in 0..3 {
            origin[k] += diagonal * rng.random_range(-1.0..1.0);
            direction[k] = target[k] - origin[k];
        }
        if direction == [0.0; 3] {
            // All of it lies in one point, or so far away that a step rounds to none.
            direction[round % 3] = 1.0;
        }
        let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        let unit = oracle::unit(direction);
        let limit = if round % 3 == 1 { f64::INFINITY } else { norm };
        let expected = oracle::ray(&triangles, origin, unit, limit);
        for (asset, pose) in posed {
            let hit = query::ray(asset, pose, origin, direction, limit, &mut stack).unwrap();
            assert_eq!(
                hit.hit.map(|h| (h.triangle.0, h.distance)),
                expected,
                "ray from {origin:?} along {direction:?} within {limit}"
            );
        }

        let offset = unit[0] * target[0] + unit[1] * target[1] + unit[2] * target[2];
        let expected = oracle::plane(&triangles, unit, offset);
        for (asset, pose) in posed {
            let mut found: Vec<Contact> = Vec::new();
            query::plane(asset, pose, direction, offset, &mut stack, &mut found).unwrap();
            let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
            ids.sort_unstable();
            assert_eq!(ids, expected, "plane {unit:?}, offset {offset}");
        }

        let about = (point, radius);
        check_shapes(posed, &triangles, about, round, &mut stack, &mut rng);
    }
}

/// The diagonal of the box around all corners; of a body that is a point, 2⁻³⁰ of its coordinates, or 1.
pub(crate) fn extent(triangles: &[[[f64; 3]; 3]]) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for x in triangles.iter().flatten() {
        for k in 0..3 {
            low[k] = low[k].min(x[k]);
            high[k] = high[k].max(x[k]);
        }
    }
    let squared: f64 = (0..3).map(|k| (high[k] - low[k]).powi(2)).sum();
    let farthest = high
        .iter()
        .chain(&low)
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    match (squared.sqrt(), farthest) {
        (0.0, 0.0) => 1.0,
        (0.0, far) => far * 2_f64.powi(-30),
        (diagonal, _) => diagonal,
    }
}

/// The asset once per kernel that this processor has.
pub fn kernels(asset: Asset<'_>) -> impl Iterator<Item = Asset<'_>> {
    Kernel::ALL
        .into_iter()
        .filter_map(move |k| asset.with_kernel(k))
}

/// Compares pair queries between two instances of a file, with and without caches, for random q
/// and placements up to `gap` sizes apart.
///
/// # Panics
/// When an answer differs.
pub fn check_pairs(bytes: &AlignedBytes, seed: u64, rounds: usize, gap: f64) {
    let asset = Asset::open(bytes).expect("open");
    let mut rng = poses::rng(seed);
    let mut caches = PairCaches::new(&asset);
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
                let ids = caches.pairs(&asset, [&a, &b], tolerance);
                assert_eq!(ids, expected, "round {round}, tolerance {tolerance}");
            }
        }
    }
}
