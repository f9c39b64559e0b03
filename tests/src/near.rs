//! Distances between two assets beside brute force.

use bdtree_runtime::narrow::{self, Triangle};
use bdtree_runtime::{
    Asset, LeafSlot, NodeSlot, PairContact, Pose, SearchEntry, StepCache, Transform, query,
};
use rand::RngExt;

use crate::body::Body;
use crate::compare::kernels;
use crate::{oracle, poses};

/// The least distance of two triangles and the lowest ids that have it.
///
/// Pairs whose boxes are farther apart than the best so far are not compared; the margin is far
/// above the rounding of both.
pub fn distance(a: &[Triangle], b: &[Triangle], max_distance: f64) -> Option<(f64, u32, u32)> {
    let boxes = |t: &Triangle| {
        let low = [0, 1, 2].map(|k| t[0][k].min(t[1][k]).min(t[2][k]));
        let high = [0, 1, 2].map(|k| t[0][k].max(t[1][k]).max(t[2][k]));
        (low, high)
    };
    let boxes_b: Vec<_> = b.iter().map(boxes).collect();
    let mut best: Option<(f64, u32, u32)> = None;
    for (i, ta) in (0..).zip(a) {
        let (low, high) = boxes(ta);
        for (j, tb) in (0..).zip(b) {
            let (low_b, high_b) = boxes_b[j as usize];
            let mut squared = 0.0;
            let mut span = 0.0_f64;
            for k in 0..3 {
                let gap = (low_b[k] - high[k]).max(low[k] - high_b[k]).max(0.0);
                squared += gap * gap;
                span = span.max(high[k].max(high_b[k]) - low[k].min(low_b[k]));
            }
            let limit = best.map_or(max_distance, |b| b.0);
            if squared.sqrt() > limit * (1.0 + 1e-9) + 1e-9 * span {
                continue;
            }
            let d = narrow::triangle_distance(ta, tb).distance;
            if d <= max_distance && best.is_none_or(|best| (d, i, j) < best) {
                best = Some((d, i, j));
            }
        }
    }
    best
}

/// Two placed instances of assets, to be asked about.
pub struct Two<'s> {
    /// The first asset.
    pub asset_a: Asset<'s>,
    /// Its pose.
    pub a: Pose<'s>,
    /// The second asset.
    pub asset_b: Asset<'s>,
    /// Its pose.
    pub b: Pose<'s>,
}

impl Two<'_> {
    /// All triangles of both.
    pub fn triangles(&self) -> [Body; 2] {
        [
            oracle::deformed_triangles(&self.asset_a, &self.a),
            oracle::deformed_triangles(&self.asset_b, &self.b),
        ]
    }

    /// The answer of every kernel, without and with a cache, and with a small one; the same.
    ///
    /// # Panics
    /// When they differ, or an answer's points do not fit it.
    pub fn distance(&self, max_distance: f64) -> Option<PairContact> {
        let mut answers = Vec::new();
        for (asset_a, asset_b) in kernels(self.asset_a).zip(kernels(self.asset_b)) {
            let mut stack = vec![SearchEntry::default(); asset_a.distance_stack_len(&asset_b)];
            let ask = |stack: &mut [SearchEntry]| {
                query::distance(
                    (&asset_a, &self.a),
                    (&asset_b, &self.b),
                    max_distance,
                    stack,
                )
                .expect("distance")
                .hit
            };
            answers.push(ask(&mut stack));
            for slots in [3, 64, 4096] {
                let mut cache_a =
                    StepCache::new(vec![NodeSlot::EMPTY; slots], vec![LeafSlot::EMPTY; slots]);
                let mut cache_b =
                    StepCache::new(vec![NodeSlot::EMPTY; slots], vec![LeafSlot::EMPTY; 0]);
                let (mut a, mut b) = (cache_a.start(&self.a), cache_b.start(&self.b));
                for _ in 0..2 {
                    let found = query::distance(
                        (&asset_a, &mut a),
                        (&asset_b, &mut b),
                        max_distance,
                        &mut stack,
                    );
                    answers.push(found.expect("distance").hit);
                }
            }
        }
        let first = answers[0];
        for answer in answers {
            assert_eq!(answer, first);
        }
        if let Some(hit) = &first {
            let gap: f64 = (0..3)
                .map(|k| (hit.point1[k] - hit.point2[k]).powi(2))
                .sum::<f64>()
                .sqrt();
            let size = hit.point1.iter().fold(1e-300_f64, |m, x| m.max(x.abs()));
            assert!(
                (gap - hit.dist).abs() <= 1e-13 * (hit.dist + size),
                "{gap} {}",
                hit.dist
            );
            if hit.dist == 0.0 {
                assert_eq!(hit.point1, hit.point2);
            }
        }
        first
    }

    /// Compares distances with brute force: without limit, at the limit, just below it.
    ///
    /// # Panics
    /// When an answer differs.
    pub fn check_distance(&self, what: &str) {
        let [ta, tb] = self.triangles();
        let expected = distance(&ta, &tb, f64::INFINITY);
        let ids = |hit: Option<PairContact>| hit.map(|h| (h.dist, h.triangle1.0, h.triangle2.0));
        assert_eq!(ids(self.distance(f64::INFINITY)), expected, "{what}");
        let (least, ..) = expected.expect("there are triangles");
        assert_eq!(ids(self.distance(least)), expected, "{what}: inclusive");
        if least > 0.0 {
            assert_eq!(self.distance(least.next_down()), None, "{what}: below");
        }
        assert_eq!(ids(self.distance(2.0 * least)), expected, "{what}: within");
    }
}

/// Compares distances of two instances of files for random q and placements up to `gap` sizes
/// apart.
///
/// # Panics
/// When an answer differs.
pub fn check_distances(asset_a: Asset<'_>, asset_b: Asset<'_>, seed: u64, rounds: usize, gap: f64) {
    let mut rng = poses::rng(seed);
    for round in 0..rounds {
        let share = [0.0, 0.05, 0.3][round % 3];
        let qa = poses::random_q(&asset_a, share, &mut rng);
        let qb = poses::random_q(&asset_b, share, &mut rng);
        let ta = poses::random_transform(1.0, &mut rng);
        let mut tb = poses::random_transform(1.0, &mut rng);
        let size = poses::diagonal(&asset_a) * asset_a.unit();
        for k in 0..3 {
            tb.translation[k] = ta.translation[k] + gap * size * rng.random_range(-1.0..1.0);
        }
        two(asset_a, &qa, ta, asset_b, &qb, tb, |two| {
            two.check_distance(&format!("round {round}, {gap} sizes"));
        });
    }
}

/// Poses two assets for `f`.
///
/// # Panics
/// When a pose is refused.
pub fn two<T>(
    asset_a: Asset<'_>,
    qa: &[f32],
    ta: Transform,
    asset_b: Asset<'_>,
    qb: &[f32],
    tb: Transform,
    f: impl FnOnce(&Two<'_>) -> T,
) -> T {
    let mut memory_a = vec![0.0; asset_a.pose_len()];
    let mut memory_b = vec![0.0; asset_b.pose_len()];
    f(&Two {
        asset_a,
        a: Pose::new(&asset_a, qa, ta, &mut memory_a).expect("pose"),
        asset_b,
        b: Pose::new(&asset_b, qb, tb, &mut memory_b).expect("pose"),
    })
}
