//! What a run checks of itself: the contacts of a few pairs of bodies against brute force over all their contact spheres.

use std::error::Error;

use bdtree_dynamics::BodyId;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{Scene, q};
use crate::workloads::random::Stream;

/// Bodies that are picked, each with its nearest neighbor and another one near it.
const PICKED: usize = 16;

/// Overlaps up to it (m) may be there or not: rounding.
const ROUNDING: f64 = 1e-12;

/// Two bodies before a step.
pub(crate) struct Pair {
    bodies: [usize; 2],
    /// Of their contact spheres.
    centers: [Vec<Vector3<f64>>; 2],
}

/// What a comparison has found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Compared {
    pub(crate) pairs: u64,
    /// Pairs of spheres that overlap by brute force.
    pub(crate) overlaps: u64,
    /// Those of them that the world has no contact for. A sphere can stick out of those above it where its body is
    /// deformed: such a pair is found some steps late.
    pub(crate) missed: u64,
    /// Deepest of the missed, m.
    pub(crate) missed_depth: f64,
    /// Overlaps of the world that brute force has not found.
    pub(crate) extra: u64,
}

/// Contact spheres of a body that falls, as it is now.
pub(crate) fn centers(
    scene: &impl Scene,
    body: usize,
) -> Result<Vec<Vector3<f64>>, Box<dyn Error>> {
    let state = scene.world().state(BodyId(body))?;
    let [x, y, z, w] = state.orientation;
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)).to_rotation_matrix();
    let (mut q, spheres) = (q(scene.world(), body)?, scene.spheres());
    q.resize(spheres.stride(), 0.0);
    let place = |k| Vector3::from(state.position) + turn * spheres.center(k, &q);
    Ok((0..spheres.len()).map(place).collect())
}

/// Some pairs of bodies that are near each other, as they are before a step.
pub(crate) fn pairs(scene: &impl Scene) -> Result<Vec<Pair>, Box<dyn Error>> {
    let at = scene.positions()?;
    let mut stream = Stream::new(scene.world().steps() ^ 0x5eed);
    let mut picked: Vec<[usize; 2]> = Vec::new();
    for _ in 0..PICKED.min(at.len()) {
        let one = (stream.unit() * at.len() as f64) as usize;
        let away = |other: usize| (Vector3::from(at[other]) - Vector3::from(at[one])).norm();
        let is_near = |other: &usize| *other != one && away(*other) < 2.0 * scene.extent();
        let near: Vec<usize> = (0..at.len()).filter(is_near).collect();
        let nearest = near.iter().min_by(|a, b| away(**a).total_cmp(&away(**b)));
        let another = near.get((stream.unit() * near.len() as f64) as usize);
        for other in nearest.into_iter().chain(another) {
            picked.push([one.min(*other), one.max(*other)]);
        }
    }
    picked.sort_unstable();
    picked.dedup();
    let first = scene.falling().start;
    let pair = |bodies: [usize; 2]| {
        let bodies @ [a, b] = bodies.map(|body| first + body);
        let centers = [centers(scene, a)?, centers(scene, b)?];
        Ok(Pair { bodies, centers })
    };
    picked.into_iter().map(pair).collect()
}

/// Compares the contacts of the step that began there.
pub(crate) fn compare(scene: &impl Scene, pairs: &[Pair]) -> Compared {
    let spheres = scene.spheres();
    let mut sum = Compared::default();
    for pair in pairs {
        let mut found: Vec<[usize; 2]> = Vec::new();
        let mut doubtful: Vec<[usize; 2]> = Vec::new();
        for contact in scene.world().contacts() {
            let (of, mut both) = (contact.bodies, contact.spheres);
            if of != pair.bodies.map(Some) {
                if of != [Some(pair.bodies[1]), Some(pair.bodies[0])] {
                    continue;
                }
                both.swap(0, 1);
            }
            if contact.depth > ROUNDING {
                found.push(both);
            } else if contact.depth > -ROUNDING {
                doubtful.push(both);
            }
        }
        found.sort_unstable();
        let [first, second] = &pair.centers;
        let mut known = 0;
        for (a, at) in first.iter().enumerate() {
            for (b, other) in second.iter().enumerate() {
                let depth = spheres.radius(a) + spheres.radius(b) - (at - other).norm();
                if depth <= ROUNDING {
                    continue;
                }
                sum.overlaps += 1;
                if found.binary_search(&[a, b]).is_ok() {
                    known += 1;
                } else if !doubtful.contains(&[a, b]) {
                    sum.missed += 1;
                    sum.missed_depth = sum.missed_depth.max(depth);
                }
            }
        }
        sum.extra += found.len() as u64 - known;
        sum.pairs += 1;
    }
    sum
}
