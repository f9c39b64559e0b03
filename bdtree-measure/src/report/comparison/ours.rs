//! Ours: a pose, then questions, with a cache of the step's nodes where many are asked.

use crate::comparison::{CACHED, LEAF_SLOTS};
use bdtree_runtime::{
    Asset, CachedPose, Contact, LeafSlot, NodeSlot, PairContact, PairStackEntry, Pose, Posed,
    StackEntry, StepCache, query,
};

use super::{Cost, ReportError, Sample, timed};

/// A step of so many balls.
pub(super) fn balls(
    asset: &Asset<'_>,
    sample: &Sample,
    amount: usize,
) -> Result<Cost, ReportError> {
    let balls: Vec<_> = sample.balls(amount).collect();
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut found: Vec<Contact> = Vec::new();
    step(asset, sample, amount, |step| {
        let mut visits = 0;
        for (center, radius) in &balls {
            found.clear();
            let posed = step.posed();
            let outcome = query::ball(asset, posed, *center, *radius, &mut stack, &mut found);
            visits += outcome?.nodes_visited;
        }
        Ok(visits)
    })
}

/// A step of so many rays.
pub(super) fn rays(asset: &Asset<'_>, sample: &Sample, amount: usize) -> Result<Cost, ReportError> {
    let rays: Vec<_> = sample.rays(amount).collect();
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    step(asset, sample, amount, |step| {
        let mut visits = 0;
        for (origin, direction) in &rays {
            let (posed, far) = (step.posed(), f64::INFINITY);
            let found = query::ray(asset, posed, *origin, *direction, far, &mut stack);
            visits += found?.nodes_visited;
        }
        Ok(visits)
    })
}

/// Two instances, one at a place of the sample's.
pub(super) fn pair(asset: &Asset<'_>, sample: &Sample, which: usize) -> Result<Cost, ReportError> {
    let mut memory = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(asset)];
    let mut found: Vec<PairContact> = Vec::new();
    timed(|| {
        found.clear();
        let [a, b] = &mut memory;
        let a = sample.pose(asset, a)?;
        let b = sample.pose_at(asset, sample.places[which], b)?;
        let outcome = query::pair((asset, &a), (asset, &b), 0.0, &mut stack, &mut found);
        let visits = outcome?.nodes_visited;
        Ok(Cost {
            visited: visits as f64 / asset.node_count().max(1) as f64,
            amount: found.len() as f64,
            micros: 0.0,
        })
    })
}

/// A body in a step, with or without a cache.
enum Step<'s, 'p> {
    Plain(&'s Pose<'p>),
    Kept(&'s mut CachedPose<'p>),
}

impl Step<'_, '_> {
    fn posed(&mut self) -> Posed<'_> {
        match self {
            Self::Plain(pose) => (*pose).into(),
            Self::Kept(cached) => (&mut **cached).into(),
        }
    }
}

/// Prepares a pose, keeps nodes over the step where many ask, and counts visits.
fn step(
    asset: &Asset<'_>,
    sample: &Sample,
    amount: usize,
    mut ask: impl FnMut(&mut Step<'_, '_>) -> Result<u64, ReportError>,
) -> Result<Cost, ReportError> {
    let mut memory = vec![0.0; asset.pose_len()];
    let is_cached = amount >= CACHED;
    let slots = if is_cached { asset.node_count() } else { 0 };
    let leaves = if is_cached { LEAF_SLOTS } else { 0 };
    let mut cache = StepCache::new(vec![NodeSlot::EMPTY; slots], vec![LeafSlot::EMPTY; leaves]);
    timed(|| {
        let pose = sample.pose(asset, &mut memory)?;
        let visits = match is_cached {
            true => ask(&mut Step::Kept(&mut cache.start(&pose)))?,
            false => ask(&mut Step::Plain(&pose))?,
        };
        Ok(Cost {
            visited: visits as f64 / asset.node_count().max(1) as f64,
            ..Cost::default()
        })
    })
}
