//! The broad phase over many bodies: the grid beside a sweep along an axis.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use bdtree_fixtures::poses;
use bdtree_measure::stats::median;
use bdtree_runtime::broad::pairs;
use bdtree_runtime::{Asset, BoundingSphere, Model, Transform, Workspace};
use clap::Args;
use rand::RngExt;

use crate::scene::Scene;

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: Scene,
    /// Rounds, in which both answer all scenes
    #[arg(long, default_value_t = 51)]
    rounds: usize,
}

/// A tilted, jittered lattice of deforming bodies that stand `spacing` root radii apart: their root
/// spheres, and microseconds that these took.
fn pile(
    asset: &Asset<'_>,
    count: usize,
    spacing: f64,
    seed: u64,
) -> Result<(Vec<BoundingSphere>, f64), Box<dyn Error>> {
    let mut rng = poses::rng(seed);
    let mut memory = vec![0.0; asset.pose_len()];
    let rest = vec![0.0; asset.mode_count()];
    let pose = asset.pose(&rest, Transform::IDENTITY, &mut memory)?;
    let step = spacing * pose.bounding_sphere()?.radius;
    let side = (count as f64).cbrt().ceil() as usize;
    let (sin, cos) = 0.5_f64.sin_cos();
    let mut spheres = Vec::with_capacity(count);
    let mut micros = 0.0;
    for i in 0..count {
        let [x, y, z] = [i % side, i / side % side, i / side / side]
            .map(|c| step * (c as f64 + rng.random_range(-0.05..0.05)));
        let translation = [cos * x - sin * y, sin * x + cos * y, z + 0.3 * x];
        let place = Transform {
            translation,
            scale: 1.0,
            ..poses::random_transform(0.0, &mut rng)
        };
        let q = poses::random_q(asset, 0.03, &mut rng);
        let start = Instant::now();
        let pose = asset.pose(&q, place, &mut memory)?;
        spheres.push(pose.bounding_sphere()?);
        micros += start.elapsed().as_secs_f64() * 1e6;
    }
    Ok((spheres, micros))
}

/// Sorts the spheres along the axis on which they spread most and compares those that overlap there.
/// Comparisons and pairs.
fn sweep(
    spheres: &[BoundingSphere],
    order: &mut Vec<(f64, usize)>,
    found: &mut Vec<[usize; 2]>,
) -> u64 {
    let mut spread = [0.0; 3];
    for (axis, spread) in spread.iter_mut().enumerate() {
        let mean = spheres.iter().map(|s| s.center[axis]).sum::<f64>() / spheres.len() as f64;
        *spread = spheres
            .iter()
            .map(|s| (s.center[axis] - mean).powi(2))
            .sum::<f64>();
    }
    let axis = (0..3)
        .max_by(|a, b| spread[*a].total_cmp(&spread[*b]))
        .unwrap_or(0);
    order.clear();
    order.extend(
        (0..)
            .zip(spheres)
            .map(|(i, s)| (s.center[axis] - s.radius, i)),
    );
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut tests = 0;
    for (k, &(_, i)) in order.iter().enumerate() {
        let a = &spheres[i];
        let end = a.center[axis] + a.radius;
        for &(low, j) in &order[k + 1..] {
            if low > end {
                break;
            }
            tests += 1;
            let b = &spheres[j];
            let square: f64 = (0..3).map(|k| (a.center[k] - b.center[k]).powi(2)).sum();
            if square <= (a.radius + b.radius).powi(2) {
                found.push([i.min(j), i.max(j)]);
            }
        }
    }
    tests
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let (mesh, basis) = arguments.scene.load()?;
    let model = Model::from_bytes(&arguments.scene.bake(&mesh, &basis)?.bytes)?;
    let seed = arguments.scene.seed;
    let mut scenes: Vec<(String, Vec<BoundingSphere>)> = Vec::new();
    for count in [1000, 3600, 12000] {
        for spacing in [1.6, 2.2] {
            let (spheres, micros) = pile(model.asset(), count, spacing, seed)?;
            println!(
                "{count} root spheres: {:.3} us each, pose included",
                micros / count as f64
            );
            scenes.push((format!("lattice, {count}, {spacing} radii apart"), spheres));
        }
    }
    let ball = |center: [f64; 3], radius: f64| BoundingSphere { center, radius };
    let mut giant = scenes[2].1.clone();
    giant[0].radius *= 1e6;
    scenes.push(("the second with a giant".into(), giant));
    let line = (0..3600)
        .map(|i| ball([f64::from(i), 0.0, 0.0], 0.6))
        .collect();
    scenes.push(("line along an axis, 3600".into(), line));
    let stack = (0..3600).map(|i| {
        ball(
            [0.01 * f64::from(i % 60), 1.0 * f64::from(i / 60), 0.0],
            0.3,
        )
    });
    scenes.push(("60 heaps of 60".into(), stack.collect()));
    scenes.push((
        "all in one place, 1000".into(),
        vec![ball([0.0; 3], 1.0); 1000],
    ));

    for (name, spheres) in &scenes {
        let mut workspace = Workspace::new();
        let (mut order, mut by_grid, mut by_sweep) = (Vec::new(), Vec::new(), Vec::new());
        let (mut grid_us, mut sweep_us) = (Vec::new(), Vec::new());
        let (mut grid_tests, mut sweep_tests) = (0, 0);
        for _ in 0..arguments.rounds {
            by_grid.clear();
            let start = Instant::now();
            pairs(black_box(spheres), 0.0, &mut workspace, &mut by_grid)?;
            grid_us.push(start.elapsed().as_secs_f64() * 1e6);
            grid_tests = workspace.stats().sphere_tests;
            by_sweep.clear();
            let start = Instant::now();
            sweep_tests = sweep(black_box(spheres), &mut order, &mut by_sweep);
            sweep_us.push(start.elapsed().as_secs_f64() * 1e6);
        }
        by_grid.sort_unstable();
        by_sweep.sort_unstable();
        assert_eq!(by_grid, by_sweep, "both find the same pairs");
        println!(
            "| {name} | {} | {:.0} | {grid_tests} | {:.0} | {sweep_tests} |",
            by_grid.len(),
            median(&grid_us),
            median(&sweep_us)
        );
    }
    Ok(())
}
