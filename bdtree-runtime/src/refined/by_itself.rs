//! Whether a step asks so much that preparing pays, from what it has visited so far and what the step before visited.
//!
//! Preparing costs as much as it saves in a number of visits that grows with the mesh alone: it deforms all vertices, and then
//! each node and each triangle that is visited costs less. The first walk of a step prepares if the step before has visited that
//! many. If it has not, a step prepares when it has visited twice as many, so that steps that ask about as much as pays do
//! not pay for both. A step among its like so costs as much as the better of both ways, and one that asks unexpectedly much at
//! most about three times as much (by the rule above, not measured).

use super::{Refined, RefinedPose};
use crate::pose::Pose;
use crate::traverse::Walk;

/// Preparing costs as much per triangle of the mesh as a third of what it saves per node and per triangle that a walk of
/// spheres visits (docs/measured/benchmarks.md, refined poses).
const PER_VISIT: u64 = 3;

/// Nodes and triangles that a ray visits, for many that are asked at once.
const RAY_VISITS: u64 = 20;

/// Visits of spheres that stand for two of boxes, which are tighter.
const OF_TWO: u64 = 3;

/// A step cache's memory for refined poses, and when it uses it.
#[derive(Debug)]
pub(crate) struct Refining<'m> {
    pose: RefinedPose<'m>,
    /// Nodes and triangles of this step, as walks of spheres visit them.
    visits: u64,
    /// From how many on a step prepares: 0 where the step before had enough.
    enough: u64,
    is_ready: bool,
    /// Meshes of so many triangles or more have found too little memory.
    too_large: usize,
}

impl<'m> Refining<'m> {
    /// For poses of a mesh of so many triangles to begin with.
    pub(crate) fn new(memory: RefinedPose<'m>, triangles: usize) -> Self {
        Self {
            pose: memory,
            visits: 0,
            enough: enough(triangles),
            is_ready: false,
            too_large: usize::MAX,
        }
    }

    /// Another pose.
    pub(crate) fn next_step(&mut self, triangles: usize) {
        let enough = enough(triangles);
        self.enough = match self.visits {
            0 => enough, // nothing is known
            few if few < enough => enough.saturating_mul(2),
            _ => 0,
        };
        self.visits = 0;
        self.is_ready = false;
    }

    pub(crate) fn is_ready(&self) -> bool {
        self.is_ready
    }
}

/// Nodes and triangles whose visits cost as much without as preparing and they do.
fn enough(triangles: usize) -> u64 {
    (triangles as u64 / PER_VISIT).max(1)
}

/// [`Refining`] behind a lifetime that can be shortened.
pub(crate) trait Refine: core::fmt::Debug + Send + Sync {
    /// The refined pose, if it is there or pays now, before `walks` walks.
    fn before(&mut self, pose: &Pose<'_>, walks: usize) -> Option<Refined<'_>>;

    /// Counts what was visited.
    fn after(&mut self, walk: &Walk);
}

impl Refine for Refining<'_> {
    fn before(&mut self, pose: &Pose<'_>, walks: usize) -> Option<Refined<'_>> {
        if !self.is_ready {
            let triangles = pose.asset.triangle_count();
            let expected = self.visits.saturating_add(match walks {
                1 => 0,
                _ => RAY_VISITS.saturating_mul(walks as u64),
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
        let mut visits = walk.nodes_visited.saturating_add(walk.triangles);
        if self.is_ready {
            visits = visits.saturating_mul(OF_TWO) / 2;
        }
        self.visits = self.visits.saturating_add(visits);
    }
}
