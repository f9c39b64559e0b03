//! How far an instance has moved over steps, at most.

#[cfg(feature = "alloc")]
use core::sync::atomic::{AtomicUsize, Ordering};

use crate::epoch::Drift;
use crate::error::QueryError;
use crate::pose::Pose;
#[cfg(feature = "alloc")]
use crate::pose::hashed;

/// Stands where a fingerprint was not computed. One that is this by chance is computed again.
#[cfg(feature = "alloc")]
const UNTOLD: u64 = 0;

/// Upper bound on the path length of any point of the instance, world units, summed over steps. Queries with a
/// [`PairFront`](crate::PairFront) need it. Keep one per instance for the instance's lifetime;
/// [`Instance`](crate::Instance) keeps its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// World units.
    total: f64,
    /// Fingerprints of the pose that it began at and of the one that it was last advanced to.
    start: u64,
    at: u64,
}

impl Motion {
    /// A motion of length 0 that begins at `pose`. Motions that begin at equal poses are not told apart: give each pair
    /// its own front.
    pub fn new(pose: &Pose<'_>) -> Self {
        let at = pose.placed_fingerprint();
        Self {
            total: 0.0,
            start: at,
            at,
        }
    }

    /// A motion of length 0 that begins at `pose`, told apart from that of every other instance of the program.
    #[cfg(feature = "alloc")]
    pub(crate) fn of_instance(pose: &Pose<'_>) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed) as u64;
        let motion = Self::new(pose);
        Self {
            start: hashed([motion.start, number].into_iter()),
            ..motion
        }
    }

    /// Adds a step, from the pose that the motion was last advanced to (or began at) to another. A vertex moves by at
    /// most δR ‖q − q₀‖ through the deformation (paper, eq. 9; the root's δR) plus what the change of the placement
    /// does to a ball around the instance; rounding is included. A step to an equal pose adds nothing.
    ///
    /// # Errors
    /// [`QueryError::Motion`] if the motion was last advanced to another pose than `from`, or the poses are of
    /// different assets; a corrupt asset.
    pub fn advance(&mut self, from: &Pose<'_>, to: &Pose<'_>) -> Result<(), QueryError> {
        if !self.is_at(from) {
            return Err(QueryError::Motion);
        }
        self.step(from, to)
    }

    /// Begins anew, at a pose that is told by [`Motion::begin`] if it matters: a step that nobody asks about.
    #[cfg(feature = "alloc")]
    pub(crate) fn forget(&mut self) {
        (self.total, self.start, self.at) = (0.0, hashed([self.start].into_iter()), UNTOLD);
    }

    /// The pose where it begins, if it was not told.
    #[cfg(feature = "alloc")]
    pub(crate) fn begin(&mut self, at: &Pose<'_>) {
        if self.at == UNTOLD {
            self.at = at.placed_fingerprint();
        }
    }

    /// [`Motion::advance`] from the pose that the motion was last advanced to.
    pub(crate) fn step(&mut self, from: &Pose<'_>, to: &Pose<'_>) -> Result<(), QueryError> {
        let asset = to.asset;
        let drift = Drift::new(from, to).ok_or(QueryError::Motion)?;
        let at = to.placed_fingerprint();
        if at == self.at {
            return Ok(());
        }
        let root = asset.node_rows(asset.node(0)?)?;
        // The drift has the slack at `to` in it; each slack pays for the vertices of its pose.
        let added = drift.added(root.steps).into_iter().fold(0.0_f32, f32::max);
        let deformed = f64::from(added) + f64::from(from.slack);
        let deformed = deformed * to.placement.world_per_stored();
        let step = deformed + to.placement.moved(&from.placement, from.reach, to.reach);
        // NaN, of a corrupt file, must not count as no motion.
        self.total = if step >= 0.0 {
            self.total + step * (1.0 + f64::EPSILON)
        } else {
            f64::INFINITY
        };
        self.at = at;
        Ok(())
    }

    /// Upper bound on the path length of any point of the instance so far, world units.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Whether the motion was last advanced to this pose.
    pub(crate) fn is_at(&self, pose: &Pose<'_>) -> bool {
        self.at == pose.placed_fingerprint()
    }

    /// What tells this motion from that of another instance.
    pub(crate) fn start(&self) -> u64 {
        self.start
    }
}
