//! A search for the q that brings a vertex closest to the surface of a sphere above it, or through it.

use bdtree_runtime::FormatError;
use rand::RngExt;

use super::poses::HardPoses;
use super::report::{Report, Tight};
use super::trial::{Target, Trial, WATCHED};

/// Steps from one start.
const STEPS: u64 = 1000;

/// Searches for `steps` cases: first from `from`, then from places and q at random.
pub(super) fn search(
    trial: &mut Trial<'_, '_>,
    poses: &mut HardPoses<'_>,
    from: Option<Tight>,
    steps: u64,
    report: &mut Report,
) -> Result<(), FormatError> {
    let mut start = from;
    let mut left = steps;
    while left > 0 {
        let (target, q) = match start.take() {
            Some(tight) => (
                target(trial, poses, tight.node, tight.lane, Some(tight.vertex)),
                tight.q,
            ),
            None => {
                let (node, lane) = lane(trial, poses);
                let kind = poses.rng().random_range(0..8);
                (target(trial, poses, node, lane, None), poses.kind(kind))
            }
        };
        let steps = left.min(STEPS);
        left -= steps;
        climb(trial, poses, &target, q, steps, report)?;
    }
    Ok(())
}

/// Steps that are kept where they bring a vertex closer to the surface.
fn climb(
    trial: &mut Trial<'_, '_>,
    poses: &mut HardPoses<'_>,
    target: &Target,
    mut q: Vec<f32>,
    steps: u64,
    report: &mut Report,
) -> Result<(), FormatError> {
    let mut best = trial.margin(&q, target, report)?;
    for step in 1..steps {
        let mut next = q.clone();
        if !q.is_empty() {
            change(poses, &mut next, step);
        }
        let margin = trial.margin(&next, target, report)?;
        if margin < best {
            (best, q) = (margin, next);
        }
    }
    Ok(())
}

/// Changes one entry, or the size of all.
fn change(poses: &mut HardPoses<'_>, q: &mut [f32], step: u64) {
    let j = poses.rng().random_range(0..q.len());
    match step % 5 {
        0 => q[j] *= poses.rng().random_range(-2.0..2.0_f32),
        1 => q[j] = 0.0,
        // The last bits decide how rounding falls.
        2 => q[j] = f32::from_bits(q[j].to_bits() ^ poses.rng().random_range(1..64)),
        3 => q[j] = poses.kind(step / 5)[j],
        _ => {
            let factor = poses.rng().random_range(0.9..1.1_f32);
            q.iter_mut().for_each(|q| *q *= factor);
        }
    }
    poses.clamp(q);
}

/// A lane at random that holds something.
fn lane(trial: &Trial<'_, '_>, poses: &mut HardPoses<'_>) -> (u32, usize) {
    loop {
        let node = poses.rng().random_range(0..trial.asset.node_count());
        let lane = poses.rng().random_range(0..8);
        if !trial.below.lane(node, lane).is_empty() {
            return (node as u32, lane);
        }
    }
}

/// Some vertices below a lane, `vertex` among them.
fn target(
    trial: &Trial<'_, '_>,
    poses: &mut HardPoses<'_>,
    node: u32,
    lane: usize,
    vertex: Option<u32>,
) -> Target {
    let below = trial.below.lane(node as usize, lane);
    let mut watched: Vec<u32> = if below.len() <= WATCHED {
        below.to_vec()
    } else {
        let mut any = || below[poses.rng().random_range(0..below.len())];
        let some = (0..WATCHED).map(|_| any());
        some.chain(vertex).collect()
    };
    watched.sort_unstable();
    watched.dedup();
    Target {
        node,
        lane,
        watched,
    }
}
