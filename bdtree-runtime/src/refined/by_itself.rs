//! What a step refines: nothing, the whole pose, or the branches where walks come often. Decided from what it has asked so far and what
//! the step before asked.
//!
//! Refining costs what grows with the mesh alone: it deforms vertices. Then each node and each triangle that is visited
//! costs less. The first walk of a step refines what the step before would have saved as much in. Where it would not have, a step
//! refines what would have saved twice as much by now, so that steps that ask about as much as pays do not pay for both. A step among
//! its like so costs as much as the better of both ways, and one that asks unexpectedly much at most about four times as much (by
//! the rules above, not measured: twice what pays by spheres, nine tenths of the whole in branches, and the whole).
//!
//! Many rays together are asked in batches: the first few tell where the others will come, as far as they are like them.

use super::branches::{BranchCache, Branches};
use super::{Refined, RefinedPose};
use crate::pose::Pose;
use crate::traverse::Walk;
use crate::view::Asset;

/// What a ray gains, for many that are asked at once: [`Walk::gain`] of 13 nodes and 18 triangles.
const RAY_GAIN: u64 = 70;

/// Meshes of so many triangles or more do not stay in the far caches: preparing waits for memory.
const FAR: usize = 200_000;

/// Walks of a first batch, from which the gain of the others is told.
const BATCH: usize = 64;

/// After so many steps that have refined the whole pose another one looks whether branches would do.
const WHOLE_STEPS: u32 = 32;

/// What walks lose of their gain where branches alone are refined, as one part of so many: boxes above them are around spheres, and they
/// have to be entered. Walks by spheres lose as much.
const LOST: u64 = 10;

/// Branches that together cost more than this share of the whole pose, what is lost included, are not worth their while: in tenths.
const TENTHS: u64 = 9;

/// After a step in which no branch has paid they are looked at once a step asks about twice as much, or so many steps later.
const LOOK_AGAIN: u32 = 16;

/// What preparing a pose costs, in the unit of [`Walk::gain`], some 15 ns: of large meshes 4 ns per triangle and 8 per vertex, of
/// smaller ones five sixths of that (docs/measured/benchmarks.md, refined poses). Where bones carry vertices, what is visited saves more.
pub(crate) fn refining_cost(asset: &Asset<'_>) -> u64 {
    let (triangles, vertices) = (asset.triangle_count(), asset.vertex_count());
    let cost = (4 * triangles as u64 + 8 * vertices as u64) / 15;
    let cost = match (asset.has_skin(), triangles < FAR) {
        (true, _) => cost * 2 / 3,
        (false, true) => cost * 5 / 6,
        (false, false) => cost,
    };
    cost.max(1)
}

/// A part of that, for so many triangles.
pub(super) fn cost_of(asset: &Asset<'_>, triangles: usize) -> u64 {
    let all = asset.triangle_count().max(1) as u64;
    (refining_cost(asset).saturating_mul(triangles as u64) / all).max(1)
}

/// From how much on a step refines what costs so much, if the step before would have gained this.
pub(super) fn enough_after(gain: u64, cost: u64) -> u64 {
    match gain {
        0 => cost, // nothing is known
        little if little < cost => cost.saturating_mul(2),
        _ => 0,
    }
}

/// What of a pose is refined, for a query.
#[derive(Debug)]
pub(crate) enum Bounds<'r> {
    Unrefined,
    Whole(Refined<'r>),
    /// Branches, and what is above them.
    Some(Refined<'r>, Branches<'r>),
}

impl<'r> Bounds<'r> {
    /// The same for a shorter time.
    #[inline]
    pub(crate) fn again(&mut self) -> Bounds<'_> {
        match self {
            Self::Unrefined => Bounds::Unrefined,
            Self::Whole(refined) => Bounds::Whole(*refined),
            Self::Some(refined, branches) => Bounds::Some(*refined, branches.again()),
        }
    }

    /// The whole pose.
    #[inline(always)]
    pub(crate) fn whole(&self) -> Option<&Refined<'r>> {
        match self {
            Self::Whole(refined) => Some(refined),
            _ => None,
        }
    }
}

/// A step cache's memory for refined poses, and when it uses it.
#[derive(Debug)]
pub(crate) struct Refining<'m> {
    pose: RefinedPose<'m>,
    branches: BranchCache,
    /// What refining the whole pose costs.
    cost: u64,
    /// Of this step, of walks of spheres ([`Walk::gain`]).
    gain: u64,
    /// Of that, what was gained in no branch: none were looked at yet, or walks asked no boxes.
    elsewhere: u64,
    /// What was open in branches after the last walk.
    open: u64,
    walks: u64,
    /// From how much on a step prepares the whole pose: 0 where the step before had enough.
    enough: u64,
    /// From how much on branches are looked at: 0 where one of the step before had enough, `None` where nothing is known.
    look_from: Option<u64>,
    /// Steps since that was found out.
    looked: u32,
    is_ready: bool,
    /// Steps that have prepared the whole pose, one after the other.
    whole_steps: u32,
    /// Meshes of so many triangles or more have found too little memory.
    too_large: usize,
}

impl<'m> Refining<'m> {
    /// For poses that cost so much ([`refining_cost`]) to begin with.
    pub(crate) fn new(memory: RefinedPose<'m>, cost: u64) -> Self {
        Self {
            pose: memory,
            branches: BranchCache::default(),
            cost,
            gain: 0,
            elsewhere: 0,
            open: 0,
            walks: 0,
            enough: cost,
            look_from: None,
            looked: 0,
            is_ready: false,
            whole_steps: 0,
            too_large: usize::MAX,
        }
    }

    /// Another pose, which costs so much.
    pub(crate) fn next_step(&mut self, cost: u64) {
        let branches = self.branches.next_step(&mut self.pose.memory);
        self.enough = enough_after(self.gain, cost);
        self.looked = self.looked.saturating_add(1);
        if self.looked == LOOK_AGAIN {
            self.look_from = None;
        }
        if let Some([of_branches, saved, open]) = branches {
            let [_, tops] = self.branches.costs(cost);
            let pays = saved >= tops + open / LOST;
            let asked = RAY_GAIN.saturating_mul(self.walks).max(self.gain);
            self.look_from = Some(if pays { 0 } else { asked.saturating_mul(2) });
            self.looked = 0;
            let lost = (self.gain / LOST).saturating_add(self.elsewhere);
            if self.enough == 0 && of_branches.saturating_add(lost) < cost / 10 * TENTHS {
                self.enough = cost.saturating_mul(2);
            }
        }
        self.whole_steps = match self.is_ready {
            true => self.whole_steps.saturating_add(1),
            false => 0,
        };
        if self.whole_steps >= WHOLE_STEPS && self.branches.are_there() {
            (self.whole_steps, self.enough, self.look_from) = (0, cost, Some(0));
        }
        self.cost = cost;
        [self.gain, self.elsewhere, self.open, self.walks] = [0; 4];
        self.is_ready = false;
    }

    pub(crate) fn is_ready(&self) -> bool {
        self.is_ready
    }

    /// Triangles that are refined now.
    pub(crate) fn triangles(&self) -> usize {
        match self.is_ready {
            true => self.pose.triangles,
            false => self.branches.triangles(),
        }
    }

    /// Refines what pays before so many walks.
    fn decide(&mut self, pose: &Pose<'_>, walks: usize) {
        let has_branches = self.branches.lay_out(pose.asset, &mut self.pose.memory);
        // Walks to come for each that has been.
        let more = match walks {
            1 => 0,
            _ => (walks as u64).checked_div(self.walks).unwrap_or(0),
        };
        let together = match walks {
            1 => 0,
            _ => RAY_GAIN.saturating_mul(walks as u64),
        };
        let is_whole = if self.enough == 0 || !has_branches {
            // Nothing else is known of those to come, or they are more of the same.
            self.gain.saturating_add(together) >= self.enough
        } else {
            let open = self.elsewhere.saturating_add(self.branches.open());
            let lost = self.gain.saturating_mul(1 + more) / LOST;
            let is_dear = |worth: u64| worth.saturating_add(lost) >= self.cost / 10 * TENTHS;
            open >= self.enough
                || is_dear(self.branches.spent())
                || more > 0 && is_dear(self.branches.worth(&mut self.pose.memory, more))
        };
        if is_whole && pose.asset.triangle_count() < self.too_large && self.prepare(pose) {
            return;
        }
        if !has_branches {
            return;
        }
        if !self.branches.is_active() {
            let [branch, tops] = self.branches.costs(self.cost);
            let expected = self.elsewhere.saturating_add(together);
            if expected < self.look_from.unwrap_or(branch + 2 * tops)
                || !self.branches.activate(pose, &mut self.pose.memory)
            {
                return;
            }
        }
        (self.branches).refine(pose, &mut self.pose.memory, more);
        self.open = self.branches.open();
    }

    /// Prepares the whole pose, if there is room for it.
    #[cold]
    fn prepare(&mut self, pose: &Pose<'_>) -> bool {
        // A damaged asset is what walks tell of.
        self.is_ready = self.pose.prepare(pose).is_ok();
        // Where it has failed it may have written all the same.
        self.branches.forget();
        if !self.is_ready {
            self.too_large = pose.asset.triangle_count();
        }
        self.is_ready
    }
}

/// [`Refining`] behind a lifetime that can be shortened.
pub(crate) trait Refine: core::fmt::Debug + Send + Sync {
    /// Of so many walks, how many are to be asked before it is decided again.
    fn batch(&mut self, pose: &Pose<'_>, walks: usize) -> usize;

    /// What is refined, or pays now, before `walks` walks.
    fn before(&mut self, pose: &Pose<'_>, walks: usize) -> Bounds<'_>;

    /// Counts what so many walks have gained, or would have.
    fn after(&mut self, walk: &Walk, walks: usize);
}

impl Refine for Refining<'_> {
    fn batch(&mut self, pose: &Pose<'_>, walks: usize) -> usize {
        let is_settled = self.is_ready
            || self.enough == 0 && pose.asset.triangle_count() < self.too_large
            || !(self.branches).lay_out(pose.asset, &mut self.pose.memory);
        match is_settled {
            true => walks,
            false => walks.min(BATCH.max(self.walks as usize)),
        }
    }

    fn before(&mut self, pose: &Pose<'_>, walks: usize) -> Bounds<'_> {
        if !self.is_ready {
            self.decide(pose, walks);
        }
        if self.is_ready {
            return Bounds::Whole(self.pose.view());
        }
        match self.branches.view(&mut self.pose.memory) {
            Some((refined, branches)) => Bounds::Some(refined, branches),
            None => Bounds::Unrefined,
        }
    }

    fn after(&mut self, walk: &Walk, walks: usize) {
        self.walks = self.walks.saturating_add(walks as u64);
        let has_boxes = walk.of_spheres > 0;
        let refined_gain = |gain: u64| gain.saturating_mul(walk.of_spheres.into()) / 4;
        let gain = if self.is_ready && has_boxes {
            refined_gain(walk.gain)
        } else if self.branches.is_active() && has_boxes {
            let open = self.branches.open();
            let unrefined = open.saturating_sub(self.open).min(walk.gain);
            self.open = open;
            unrefined + refined_gain(walk.gain - unrefined)
        } else {
            self.elsewhere = self.elsewhere.saturating_add(walk.gain);
            walk.gain
        };
        self.gain = self.gain.saturating_add(gain);
    }
}
