//! Steps that change little: spheres that follow a pose (P18) and fronts of pairs that stay close
//! (P58), beside asking anew.

use std::error::Error;
use std::time::Instant;

use bdtree_measure::Place;
use bdtree_measure::machine;
use bdtree_measure::stats::median;
use bdtree_runtime::{
    Asset, Ball, CacheSize, Contact, Motion, PairFront, Pose, Query, StepCache, Transform,
    TrianglePair, VertexId, Workspace, studies,
};
use bdtree_scenes::workloads::bodies::{Bodies, MODES, bodies};
use clap::Args;

use bdtree_scenes::contenders::assets::baked;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Steps of each run
    #[arg(long, default_value_t = 200)]
    steps: usize,
    /// Steps from one frame of W2 to the next, run by run
    #[arg(long, value_delimiter = ',', default_value = "1,10,100,1000")]
    speeds: Vec<usize>,
    /// Balls asked for at each step
    #[arg(long, default_value_t = 8)]
    balls: usize,
    /// Runs of which the median counts
    #[arg(long, default_value_t = 9)]
    repeat: usize,
}

/// Pairs of leaves that a front has room for, 16 bytes each.
const FRONT_SLOTS: usize = 4096;

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    println!("{}", machine::processor());
    let work = bodies();
    let model = baked(&work.body)?;
    let asset = model.asset();
    println!(
        "A ball (radius 0.05) at {} places of W2's body",
        arguments.balls
    );
    println!("| largest motion a step, % | contender | visits | updates | µs per step |");
    println!("|---|---|---|---|---|");
    for speed in &arguments.speeds {
        balls(asset, &work, *speed, arguments)?;
    }
    println!("\nW2's two bodies");
    println!(
        "| place | largest motion a step, % | touching | visits | µs from the root | visits, front | µs, front |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (place, apart) in [("touching", 0.0), ("0.15 apart", 0.15), ("0.5 apart", 0.5)] {
        for speed in &arguments.speeds {
            pairs((asset, &work), (place, apart), *speed, arguments)?;
        }
    }
    Ok(())
}

/// q of one of the two bodies after so many steps, frames joined by straight lines.
fn at(work: &Bodies, body: usize, step: usize, per_frame: usize) -> Vec<f32> {
    let frames = work.q[body].len() / MODES;
    let (frame, part) = (step / per_frame, step % per_frame);
    let q = |frame: usize| &work.q[body][frame % frames * MODES..][..MODES];
    let share = part as f32 / per_frame as f32;
    let pairs = q(frame).iter().zip(q(frame + 1));
    pairs.map(|(a, b)| a + share * (b - a)).collect()
}

/// The way of the vertex that moves most in a step, in the mean over the steps, in per cent of the diagonal.
fn motion(poses: &[Pose<'_>]) -> Result<f64, Box<dyn Error>> {
    let (mut sum, mut low, mut high) = (0.0, [f64::MAX; 3], [f64::MIN; 3]);
    let some = &poses[..poses.len().min(20)];
    for two in some.windows(2) {
        let mut most = 0.0_f64;
        for i in 0..two[0].asset().vertex_count() as u32 {
            let [a, b] = [&two[0], &two[1]].map(|pose| pose.deformed(VertexId(i)));
            let (a, b) = (a?, b?);
            let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
            most = most.max(square);
            for k in 0..3 {
                low[k] = low[k].min(a[k]);
                high[k] = high[k].max(a[k]);
            }
        }
        sum += most.sqrt();
    }
    let square: f64 = (0..3).map(|k| (high[k] - low[k]).powi(2)).sum();
    Ok(100.0 * sum / (some.len() - 1) as f64 / square.sqrt())
}

/// Poses of a body at all steps.
fn poses<'m>(
    (asset, work): (&'m Asset<'m>, &Bodies),
    (body, place): (usize, Transform),
    per_frame: usize,
    memory: &'m mut [Vec<f32>],
) -> Result<Vec<Pose<'m>>, Box<dyn Error>> {
    let steps = memory.iter_mut().enumerate();
    steps
        .map(|(step, memory)| {
            let q = at(work, body, step, per_frame);
            memory.resize(asset.pose_len(), 0.0);
            Ok(asset.pose(&q, place, memory)?)
        })
        .collect()
}

/// What a run did.
struct Tally {
    visits: u64,
    updates: u64,
    found: u64,
}

impl Tally {
    const ZERO: Self = Self {
        visits: 0,
        updates: 0,
        found: 0,
    };
}

fn balls(
    asset: &Asset<'_>,
    work: &Bodies,
    speed: usize,
    arguments: &Arguments,
) -> Result<(), Box<dyn Error>> {
    let mut memory = vec![Vec::new(); arguments.steps];
    let poses = poses((asset, work), (0, Transform::IDENTITY), speed, &mut memory)?;
    let moved = motion(&poses)?;
    let count = asset.vertex_count() as u32;
    let centers = (0..arguments.balls as u32)
        .map(|i| poses[0].deformed(VertexId(i * (count / arguments.balls as u32))))
        .collect::<Result<Vec<_>, _>>()?;
    let mut workspace = Workspace::new();
    let mut found: Vec<Contact> = Vec::new();
    let mut ask = |query: &mut Query<'_, '_>, tally: &mut Tally| -> Result<(), Box<dyn Error>> {
        for center in &centers {
            found.clear();
            query.contacts(Ball::new(*center, 0.05), &mut found)?;
            tally.visits += query.stats().nodes_visited;
            tally.updates += query.stats().nodes_updated;
            tally.found += found.len() as u64;
        }
        Ok(())
    };
    let limit = 0.1 * leaf_radius(&poses[0])?;
    let contenders = [
        ("anew, nothing kept", 0, false),
        ("anew, kept for the step", asset.node_count(), false),
        ("followed", asset.node_count(), true),
    ];
    let mut caches = contenders.map(|(_, nodes, _)| StepCache::new(CacheSize { nodes, leaves: 0 }));
    let mut runs = [const { Vec::new() }; 3];
    let mut tallies = [const { Tally::ZERO }; 3];
    for _ in 0..arguments.repeat.max(1) {
        for (k, (_, _, follows)) in contenders.into_iter().enumerate() {
            let cache = &mut caches[k];
            let mut tally = Tally::ZERO;
            let start = Instant::now();
            let mut reference = 0;
            for (step, pose) in poses.iter().enumerate() {
                if follows && step > reference {
                    let reference = &poses[reference];
                    studies::next_step(cache, reference);
                    let query = pose.query(&mut workspace);
                    let mut query = studies::follow(query, cache, reference);
                    if studies::growth(&mut query)? <= limit {
                        ask(&mut query, &mut tally)?;
                        continue;
                    }
                }
                reference = step;
                cache.start(pose);
                ask(&mut pose.query(&mut workspace).cached(cache), &mut tally)?;
            }
            runs[k].push(start.elapsed().as_secs_f64());
            tallies[k] = tally;
        }
    }
    if tallies.iter().any(|tally| tally.found != tallies[0].found) {
        return Err("contenders find different contacts".into());
    }
    let steps = arguments.steps as f64;
    for (k, (name, _, _)) in contenders.into_iter().enumerate() {
        println!(
            "| {moved:.5} | {name} | {:.1} | {:.1} | {:.2} |",
            tallies[k].visits as f64 / steps,
            tallies[k].updates as f64 / steps,
            1e6 * median(&runs[k]) / steps
        );
    }
    Ok(())
}

/// Mean radius of leaf lanes (world).
fn leaf_radius(pose: &Pose<'_>) -> Result<f64, Box<dyn Error>> {
    let asset = pose.asset();
    let (mut sum, mut count) = (0.0, 0.0);
    for (index, node) in (0..).zip(asset.nodes()) {
        let spheres = pose.node_spheres(index)?;
        for lane in (0..8).filter(|lane| node.leaf_mask & 1 << lane != 0) {
            sum += f64::from(spheres.radius[lane]);
            count += 1.0;
        }
    }
    Ok(sum / count * asset.unit())
}

fn pairs(
    (asset, work): (&Asset<'_>, &Bodies),
    (name, apart): (&str, f64),
    speed: usize,
    arguments: &Arguments,
) -> Result<(), Box<dyn Error>> {
    let [x, y, z] = work.places[0].translation;
    let far = 1.0 + apart / (x * x + y * y + z * z).sqrt();
    let place = Place {
        translation: [x * far, y * far, z * far],
        ..work.places[0]
    };
    let mut memory = [0; 2].map(|_| vec![Vec::new(); arguments.steps]);
    let [memory_a, memory_b] = &mut memory;
    let a = poses((asset, work), (0, Transform::IDENTITY), speed, memory_a)?;
    let b = poses((asset, work), (1, place.transform()), speed, memory_b)?;
    let moved = motion(&a)?;
    let mut workspace = Workspace::new();
    let mut found: Vec<TrianglePair> = Vec::new();
    let mut runs = [const { Vec::new() }; 2];
    let mut tallies = [const { Tally::ZERO }; 2];
    for _ in 0..arguments.repeat.max(1) {
        for k in 0..2 {
            let mut tally = Tally::ZERO;
            let mut slots = vec![0; PairFront::SLOT_BYTES * FRONT_SLOTS];
            let mut front = PairFront::in_bytes(&mut slots);
            let mut motions = [Motion::new(&a[0]), Motion::new(&b[0])];
            let start = Instant::now();
            for step in 0..arguments.steps {
                found.clear();
                if k == 1 {
                    let before = step.saturating_sub(1);
                    motions[0].advance(&a[before], &a[step])?;
                    motions[1].advance(&b[before], &b[step])?;
                    let one = a[step].moving(&motions[0])?;
                    let two = b[step].moving(&motions[1])?;
                    let pair = one.against(&two, &mut workspace);
                    pair.front(&mut front).triangle_pairs(0.0, &mut found)?;
                } else {
                    let mut pair = a[step].against(&b[step], &mut workspace);
                    pair.triangle_pairs(0.0, &mut found)?;
                }
                tally.visits += workspace.stats().nodes_visited;
                tally.found += found.len() as u64;
            }
            runs[k].push(start.elapsed().as_secs_f64());
            tallies[k] = tally;
        }
    }
    if tallies[0].found != tallies[1].found {
        return Err("the front finds other pairs".into());
    }
    let steps = arguments.steps as f64;
    let visits = |k: usize| tallies[k].visits as f64 / steps;
    let us = |k: usize| 1e6 * median(&runs[k]) / steps;
    println!(
        "| {name} | {moved:.5} | {:.0} | {:.1} | {:.2} | {:.1} | {:.2} |",
        tallies[0].found as f64 / steps,
        visits(0),
        us(0),
        visits(1),
        us(1)
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use bdtree_scenes::workloads::bodies::{MODES, bodies};

    use super::at;

    #[test]
    fn steps_join_frames() {
        let work = bodies();
        let frame = |k: usize| work.q[1][k * MODES..(k + 1) * MODES].to_vec();
        assert_eq!(at(&work, 1, 20, 10), frame(2));
        let between = at(&work, 1, 25, 10);
        for j in 0..MODES {
            let middle = 0.5 * (frame(2)[j] + frame(3)[j]);
            assert!((between[j] - middle).abs() <= 1e-6 * middle.abs().max(1e-3));
        }
    }
}
