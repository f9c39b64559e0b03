//! One mesh of a query: its pose, what is kept of it, and how deep it is looked into.

use crate::cache::{Kept, Posed, StepCache};
use crate::depth::Proxies;
use crate::epoch::Drift;
use crate::error::QueryError;
use crate::pose::Pose;
use crate::refined::{Bounds, Refine, Refined, RefinedPose};
use crate::traverse::Walk;

/// A pose and how it is looked at.
#[derive(Debug)]
pub(crate) struct Side<'q> {
    pub(super) pose: Pose<'q>,
    /// What a step keeps.
    kept: Kept<'q>,
    /// Whether that is of another pose, which the next question says.
    is_stale: bool,
    /// The pose at which nodes are evaluated, if it is another one.
    drift: Option<(&'q Pose<'q>, Drift)>,
    pub(super) limit: Option<Proxies<'q>>,
    refined: Option<Refined<'q>>,
    /// Of the step cache.
    refining: Option<&'q mut dyn Refine>,
}

impl<'q> Side<'q> {
    #[inline]
    pub(super) fn new(pose: Pose<'q>) -> Self {
        Self {
            pose,
            kept: Kept::nothing(),
            is_stale: false,
            drift: None,
            limit: None,
            refined: None,
            refining: None,
        }
    }

    #[inline]
    pub(super) fn keep(&mut self, cache: &'q mut StepCache<'_>) {
        self.is_stale |= !cache.serves(&self.pose);
        (self.kept, self.refining) = cache.parts();
    }

    /// Uses exact bounds of the whole pose.
    pub(super) fn refine(&mut self, refined: &'q RefinedPose<'_>) {
        self.is_stale |= !refined.serves(&self.pose);
        self.refined = Some(refined.view());
    }

    /// Takes spheres from those of `reference`, with which the cache was started (paper, eq. 8).
    pub(crate) fn follow(&mut self, cache: &'q mut StepCache<'_>, reference: &'q Pose<'q>) {
        self.drift = Drift::new(reference, &self.pose).map(|drift| (reference, drift));
        self.is_stale |= self.drift.is_none() || !cache.serves(reference);
        self.kept = cache.slots();
    }

    /// What following a reference has added to the radii of the root's lanes, at most (world units).
    pub(crate) fn growth(&self) -> Result<f64, QueryError> {
        let Some((_, drift)) = &self.drift else {
            return Ok(0.0);
        };
        let asset = self.pose.asset;
        let added = drift.added(asset.node_rows(asset.node(0)?)?.steps);
        let largest = added.into_iter().fold(0.0_f32, f32::max);
        Ok(f64::from(largest) * self.pose.placement.world_per_stored())
    }

    /// For one walk.
    #[inline]
    pub(super) fn posed(&mut self) -> Result<Posed<'_>, QueryError> {
        self.posed_for(1)
    }

    /// For one walk or several; for none that may use a refined pose.
    #[inline]
    pub(super) fn posed_for(&mut self, walks: usize) -> Result<Posed<'_>, QueryError> {
        if self.is_stale {
            return Err(QueryError::Cache);
        }
        let limit = self.limit.as_mut().map(Proxies::limit);
        let mut posed = Posed::new(&self.pose, self.drift, self.kept.again(), limit);
        if walks > 0 && posed.limit.is_none() && self.drift.is_none() {
            posed.refined = match (self.refined, &mut self.refining) {
                (Some(given), _) => Bounds::Whole(given),
                (None, Some(refining)) => refining.before(&self.pose, walks),
                (None, None) => Bounds::Unrefined,
            };
        }
        Ok(posed)
    }

    /// After walks of this mesh alone.
    #[inline]
    pub(super) fn note(&mut self, walk: &Walk, walks: usize) {
        if let Some(refining) = &mut self.refining {
            refining.after(walk, walks);
        }
    }

    /// Of so many walks, how many to do before the next: [`Refine::batch`].
    pub(super) fn batch(&mut self, walks: usize) -> usize {
        let is_whole =
            self.is_stale || self.refined.is_some() || self.limit.is_some() || self.drift.is_some();
        match &mut self.refining {
            Some(refining) if !is_whole => refining.batch(&self.pose, walks),
            _ => walks,
        }
    }

    /// Whether the last walk ended because there was no room for a proxy.
    pub(super) fn is_cut(&self) -> bool {
        self.limit.as_ref().is_some_and(|proxies| proxies.is_full)
    }

    /// What it is, for one walk that has no levels to end at.
    pub(super) fn posed_whole(&mut self, what: &'static str) -> Result<Posed<'_>, QueryError> {
        self.refuse_level(what)?;
        self.posed()
    }

    fn refuse_level(&self, what: &'static str) -> Result<(), QueryError> {
        match self.limit {
            Some(_) => Err(QueryError::Argument(what)),
            None => Ok(()),
        }
    }

    /// The same for a walk whose answer is spheres or depends on what they rule out.
    pub(super) fn posed_spheres(&mut self, what: &'static str) -> Result<Posed<'_>, QueryError> {
        self.refuse_level(what)?;
        self.posed_for(0)
    }
}
