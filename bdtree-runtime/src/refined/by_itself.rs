//! Whether a step asks so much that preparing pays, from what it has asked so far and what the step before asked.
//!
//! Preparing costs what grows with the mesh alone: it deforms all vertices. Then each node and each triangle that is visited
//! costs less. The first walk of a step prepares if the step before would have saved that much. If it would not, a step prepares
//! when it would have saved twice as much, so that steps that ask about as much as pays do not pay for both. A step among its
//! like so costs as much as the better of both ways, and one that asks unexpectedly much at most about three times as much (by
//! the rule above, not measured).

use super::{Refined, RefinedPose};
use crate::pose::Pose;
use crate::traverse::Walk;
use crate::view::Asset;

/// What a ray gains, for many that are asked at once: [`Walk::gain`] of 13 nodes and 18 triangles.
const RAY_GAIN: u64 = 70;

/// What spheres would have gained where two were gained with boxes, which are tighter.
const OF_TWO: u64 = 3;

/// Meshes of so many triangles do not stay in the near caches, so that deforming a leaf takes longer; of more, preparing waits for
/// memory as well.
const FAR: core::ops::Range<usize> = 50_000..200_000;

/// What preparing a pose costs, in the unit of [`Walk::gain`], some 15 ns: 4 ns per triangle and 8 per vertex
/// (docs/measured/benchmarks.md, refined poses). Where bones carry vertices, what is visited saves more.
pub(crate) fn refining_cost(asset: &Asset<'_>) -> u64 {
    let (triangles, vertices) = (asset.triangle_count(), asset.vertex_count());
    let cost = (4 * triangles as u64 + 8 * vertices as u64) / 15;
    let cost = match (asset.has_skin(), FAR.contains(&triangles)) {
        (true, _) => cost * 2 / 5,
        (false, true) => cost * 2 / 3,
        (false, false) => cost,
    };
    cost.max(1)
}

/// A step cache's memory for refined poses, and when it uses it.
#[derive(Debug)]
pub(crate) struct Refining<'m> {
    pose: RefinedPose<'m>,
    /// Of this step, of walks of spheres ([`Walk::gain`]).
    gain: u64,
    /// From how much on a step prepares: 0 where the step before had enough.
    enough: u64,
    is_ready: bool,
    /// Meshes of so many triangles or more have found too little memory.
    too_large: usize,
}

impl<'m> Refining<'m> {
    /// For poses that cost so much ([`refining_cost`]) to begin with.
    pub(crate) fn new(memory: RefinedPose<'m>, cost: u64) -> Self {
        Self {
            pose: memory,
            gain: 0,
            enough: cost,
            is_ready: false,
            too_large: usize::MAX,
        }
    }

    /// Another pose, which costs so much.
    pub(crate) fn next_step(&mut self, cost: u64) {
        self.enough = match self.gain {
            0 => cost, // nothing is known
            little if little < cost => cost.saturating_mul(2),
            _ => 0,
        };
        self.gain = 0;
        self.is_ready = false;
    }

    pub(crate) fn is_ready(&self) -> bool {
        self.is_ready
    }
}

/// [`Refining`] behind a lifetime that can be shortened.
pub(crate) trait Refine: core::fmt::Debug + Send + Sync {
    /// The refined pose, if it is there or pays now, before `walks` walks.
    fn before(&mut self, pose: &Pose<'_>, walks: usize) -> Option<Refined<'_>>;

    /// Counts what was gained, or would have been.
    fn after(&mut self, walk: &Walk);
}

impl Refine for Refining<'_> {
    fn before(&mut self, pose: &Pose<'_>, walks: usize) -> Option<Refined<'_>> {
        if !self.is_ready {
            let triangles = pose.asset.triangle_count();
            let expected = self.gain.saturating_add(match walks {
                1 => 0,
                _ => RAY_GAIN.saturating_mul(walks as u64),
            });
            if expected < self.enough || triangles >= self.too_large {
                return None;
            }
            core::hint::cold_path();
            // A damaged asset is what walks tell of.
            if self.pose.prepare(pose).is_err() {
                self.too_large = triangles;
                return None;
            }
            self.is_ready = true;
        }
        Some(self.pose.view())
    }

    fn after(&mut self, walk: &Walk) {
        let mut gain = walk.gain;
        if self.is_ready {
            gain = gain.saturating_mul(OF_TWO) / 2;
        }
        self.gain = self.gain.saturating_add(gain);
    }
}
