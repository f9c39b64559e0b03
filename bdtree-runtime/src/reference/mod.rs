//! Tests: the update of docs/design/node-update.md, in plain f64, beside the eight-lane kernel.

mod update;

use std::vec::Vec;

use bdtree_format::LANES;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::update::{Mode, Sphere};
use crate::rounding::{GAMMA, U32};
use crate::{Asset, Kernel, Pose, Transform};

/// Of the golden files: all modes, few modes per node, frames, a single triangle per lane.
const FILES: [&[u8]; 4] = [
    crate::include_bdt!("../../../fixtures/golden/sphere.bdt"),
    crate::include_bdt!("../../../fixtures/golden/sparse.bdt"),
    crate::include_bdt!("../../../fixtures/golden/animated.bdt"),
    crate::include_bdt!("../../../fixtures/golden/tetrahedron.bdt"),
];

#[test]
fn the_page_shows_the_update_that_is_tested() {
    let page = include_str!("../../../docs/design/node-update.md");
    assert!(page.contains(include_str!("update.rs")));
    assert!(include_str!("update.rs").lines().count() <= 50);
}

/// q as node bounds see it: in whole numbers.
fn rounded(pose: &Pose<'_>) -> Vec<f64> {
    let shares = pose.bound().quantized;
    let (scale, ratio) = (f64::from(shares.scale), f64::from(shares.ratio));
    let of_mode = |(j, mode): (usize, &bdtree_format::ModeRecord)| {
        let n = f64::from(shares.coarse.as_flattened()[j]);
        let m = shares
            .fine
            .as_flattened()
            .get(j)
            .map_or(0.0, |m| f64::from(*m));
        (n + ratio * m) * scale * f64::from(mode.q_limit.get())
    };
    pose.asset()
        .modes()
        .iter()
        .enumerate()
        .map(of_mode)
        .collect()
}

/// Calls `check` with each lane's sphere in plain numbers and its modes.
fn for_spheres(asset: &Asset<'_>, mut check: impl FnMut(u32, usize, Sphere<'_>, &[u16])) {
    for (index, node) in (0..).zip(asset.nodes()) {
        let (rows, modes) = (
            asset.node_rows(node).expect("rows"),
            asset.node_modes(node).expect("modes"),
        );
        for lane in (0..LANES).filter(|k| (node.inner_mask | node.leaf_mask) >> k & 1 == 1) {
            let mode = |(k, j): (usize, &u16)| {
                let limit = f64::from(asset.modes()[usize::from(*j)].q_limit.get());
                let numbers = rows.numbers(k, lane);
                let of = |i: usize, unit: usize| {
                    f64::from(numbers[i]) * f64::from(rows.units[unit]) / limit
                };
                Mode {
                    shift: [of(0, 0), of(1, 0), of(2, 0)],
                    growth: of(3, 1),
                    pushes: [of(4, 2), of(5, 2)],
                }
            };
            let in_plain: Vec<Mode> = modes.iter().enumerate().map(mode).collect();
            let [x, y, z, radius] = rows.leading.map(|row| f64::from(row[lane]));
            let sphere = Sphere {
                center: [x, y, z],
                radius,
                modes: &in_plain,
            };
            check(index, lane, sphere, modes);
        }
    }
}

#[test]
fn the_kernel_is_the_plain_update_within_the_slack() {
    let mut random = Pcg64Mcg::seed_from_u64(60);
    let mut compared = 0;
    for file in FILES {
        let asset = Asset::open(file).expect("a golden file");
        for round in 0..48 {
            let size = [0.0, 1e-6, 0.01, 0.3, 1.0, 4.0][round % 6];
            let of_mode = |mode: &bdtree_format::ModeRecord| {
                let limit = mode.q_limit.get();
                let q: f64 = size * random.random_range(-1.0..1.0);
                ((q * f64::from(mode.q_range.get())) as f32).clamp(-limit, limit)
            };
            let q: Vec<f32> = asset.modes().iter().map(of_mode).collect();
            for kernel in Kernel::ALL {
                let Some(asset) = asset.with_kernel(kernel) else {
                    continue;
                };
                let mut memory = std::vec![0.0; asset.pose_len()];
                let pose = (asset.pose(&q, Transform::IDENTITY, &mut memory)).expect("pose");
                let (near, slack) = (rounded(&pose), f64::from(pose.slack));
                for_spheres(&asset, |node, lane, sphere, modes| {
                    let at = |q: &dyn Fn(usize) -> f64| -> Vec<f64> {
                        modes.iter().map(|j| q(usize::from(*j))).collect()
                    };
                    let spheres = pose.node_spheres(node).expect("spheres");
                    let found = spheres.center.map(|row| f64::from(row[lane]));
                    let found_radius = f64::from(spheres.radius[lane]);
                    let (center, radius) = sphere.update(&at(&|j| near[j]));
                    let (given, _) = sphere.update(&at(&|j| f64::from(q[j])));
                    for axis in 0..3 {
                        // What q in whole numbers is off is part of the slack.
                        assert!((found[axis] - center[axis]).abs() <= slack);
                        assert!((found[axis] - given[axis]).abs() <= slack);
                    }
                    // From above: γ' of (R + s)² under the root, twice for its rounding, and the slack.
                    let growth: f64 = (sphere.modes.iter().zip(at(&|j| near[j])))
                        .map(|(mode, q)| mode.growth * q.abs())
                        .sum();
                    let total = sphere.radius + growth;
                    let most = (radius * radius + 2.0 * f64::from(GAMMA) * total * total).sqrt();
                    let most = (most + slack) * (1.0 + 2.0 * U32);
                    assert!(
                        (radius..=most).contains(&found_radius),
                        "{radius} {found_radius} {most}: node {node}, lane {lane}, {kernel:?}, {q:?}"
                    );
                    compared += 1;
                });
            }
        }
    }
    assert!(compared > 20_000, "{compared}");
}
