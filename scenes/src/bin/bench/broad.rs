//! The broad phase over many bodies.

use bdtree_runtime::BoundingSphere;
use bdtree_runtime::broad::pairs;

use crate::prelude::*;

/// A tilted, jittered lattice of deforming bodies that stand `spacing` root radii apart: their root
/// spheres, and microseconds that these took.
fn pile(
    asset: &Asset<'_>,
    count: usize,
    spacing: f64,
    seed: u64,
) -> Result<(Vec<BoundingSphere>, f64)> {
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

pub(crate) fn run(scene: &Scene, rounds: usize) -> Result<Vec<Table>> {
    let model = scene.model()?;
    let mut scenes: Vec<(String, Vec<BoundingSphere>)> = Vec::new();
    let mut roots = Vec::new();
    for count in [1000, 3600, 12000] {
        for spacing in [1.6, 2.2] {
            let (spheres, micros) = pile(model.asset(), count, spacing, scene.seed)?;
            let each = micros / count as f64;
            roots.push(row! {"root spheres" => count, "µs each, pose included" => each});
            scenes.push((format!("lattice, {count}, {spacing} radii apart"), spheres));
        }
    }
    let ball = |center: [f64; 3], radius: f64| BoundingSphere { center, radius };
    let mut giant = scenes[2].1.clone();
    giant[0].radius *= 1e6;
    let line = (0..3600).map(|i| ball([f64::from(i), 0.0, 0.0], 0.6));
    let heap = |i: i32| [0.01 * f64::from(i % 60), f64::from(i / 60), 0.0];
    let place = vec![ball([0.0; 3], 1.0); 1000];
    let heaps = (0..3600).map(|i| ball(heap(i), 0.3));
    scenes.extend([
        ("the second with a giant".into(), giant),
        ("line along an axis, 3600".into(), line.collect()),
        ("60 heaps of 60".into(), heaps.collect()),
        ("all in one place, 1000".into(), place),
    ]);

    let mut all = Vec::new();
    for (name, spheres) in &scenes {
        let mut workspace = Workspace::new();
        let mut found = Vec::new();
        let entry = Entry::new("grid", Role::Ours, Counts::Same, |_| {
            found.clear();
            frame(|| {
                let mut answer = Answer::default();
                pairs(black_box(spheres), 0.0, &mut workspace, &mut found)?;
                answer.found = found.len() as u64;
                answer.nodes.visited = workspace.stats().sphere_tests;
                Ok(answer)
            })
        });
        let measured = compare(vec![entry], 1, rounds)?;
        let about = row! {"scene" => name.as_str()};
        all.extend(rows(&about, &measured, 1, "µs"));
    }
    Ok(vec![
        table("roots", "Root spheres of deforming bodies", &roots),
        table("scenes", "Spheres that overlap, and comparisons", &all),
    ])
}
