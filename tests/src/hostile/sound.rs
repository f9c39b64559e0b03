//! A file that `verify` passes, however it came about: its queries answer what brute force answers.

use bdtree_runtime::{Asset, PairStackEntry, Pose, Transform, TrianglePair, query};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::{compare, oracle, poses};

/// Coordinates up to this are compared: far below what queries take, and what placements add.
const LARGEST: f64 = (1_u128 << 90) as f64;

/// Below this share of its coordinates a mesh has collapsed: there is nothing to ask about.
const SMALLEST: f64 = 1.0 / (1_u64 << 30) as f64;

/// Compares every query of one asset and the touching pairs of two with brute force, with every kernel.
/// False where the mesh's size or place leaves nothing to compare.
///
/// # Panics
/// When an answer differs.
pub(super) fn compare(asset: &Asset<'_>, partner: &Asset<'_>, rng: &mut Pcg64Mcg) -> bool {
    let share = [0.0, 0.1, 0.5, 1e9][rng.random_range(0..4)];
    let q = poses::random_q(asset, share, rng);
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, &q, Transform::IDENTITY, &mut memory).expect("a pose");
    let body = oracle::deformed_triangles(asset, &pose);
    let (mut low, mut high, mut largest) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0_f64);
    for x in body.iter().flatten() {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(x[k]), high[k].max(x[k]));
            largest = largest.max(x[k].abs());
        }
    }
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    if !(largest < LARGEST && size > SMALLEST * largest) {
        return false;
    }
    let seed = rng.random();
    compare::check_pose(compare::kernels(*asset), &q, Transform::IDENTITY, seed, 2);

    // The partner, about as large, through one of the corners.
    let reach = poses::diagonal(partner) * partner.unit();
    let scale = 0.5 * size / reach;
    if !(1e-15..1e15).contains(&scale) {
        return true;
    }
    let place = Transform {
        translation: body[rng.random_range(0..body.len())][0],
        scale,
        ..Transform::IDENTITY
    };
    if place.translation.iter().any(|t| t.abs() > 1e24) {
        return true;
    }
    let other_q = poses::random_q(partner, 0.1, rng);
    let mut other_memory = vec![0.0; partner.pose_len()];
    let other = Pose::new(partner, &other_q, place, &mut other_memory).expect("a pose");
    let other_body = oracle::deformed_triangles(partner, &other);
    let tolerance = [0.0, 0.01 * size][rng.random_range(0..2)];
    let expected = oracle::pair(&body, &other_body, tolerance);
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(partner)];
    for asset in compare::kernels(*asset) {
        let mut ids: Vec<TrianglePair> = Vec::new();
        let (one, two) = ((&asset, &pose), (partner, &other));
        query::touching(one, two, tolerance, &mut stack, &mut ids).expect("a sound pair");
        let mut ids: Vec<(u32, u32)> = ids.iter().map(|p| (p.triangle1.0, p.triangle2.0)).collect();
        ids.sort_unstable();
        assert_eq!(ids, expected, "pairs within {tolerance}");
    }
    true
}
