//! Branches: the subtrees below one level, refined one by one where walks come often, in as much memory as there is.
//!
//! What lies above them has boxes around the spheres of its lanes. A walk goes from those into branches that are refined and, by
//! spheres, into those that are not ([`crate::traverse`], unrefined), which count what they would have gained.

use core::ops::Range;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::branch::{Room, refine, triangles_below};
use super::by_itself::{cost_of, enough_after};
use super::record::{RefinedLeaf, RefinedNode};
use super::tops::{TOP_COST, Tops, tighten};
use super::{Counts, Refined};
use crate::pose::{Pose, identity};
use crate::traverse::UNREFINED;
use crate::view::Asset;
use crate::workspace::Memory;

/// Triangles of a branch, on average, more or less: levels differ by a factor of eight.
const BRANCH: usize = 700;

/// Meshes with fewer branches are refined as a whole or not at all.
const BRANCHES_LEAST: usize = 8;

/// A subtree that is refined by itself.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct Branch {
    /// Where its root is among the refined nodes; 0, where the asset's is, while it is not refined.
    at: u32,
    /// What refining it costs, in the unit of [`Walk::gain`](crate::traverse::Walk::gain).
    cost: u32,
    /// From how much on a step refines it.
    enough: u32,
    /// What walks would have gained in it in this step, before it was refined.
    gain: u32,
    /// How often walks have come to it in this step: before it was refined, and in all.
    unrefined: u32,
    entered: u32,
    /// What a walk that comes to it gains on average, times [`RATE`].
    rate: u32,
}

/// Parts of the unit that averages are kept in.
const RATE: u64 = 16;

impl Branch {
    /// One of which nothing is known but what it costs.
    fn new(cost: u32) -> Self {
        Self {
            at: 0,
            cost,
            enough: cost,
            gain: 0,
            unrefined: 0,
            entered: 0,
            rate: 0,
        }
    }

    /// Begins another step; what all walks of the last one would have gained.
    fn next_step(&mut self) -> u64 {
        if let Some(rate) = (RATE * u64::from(self.gain)).checked_div(self.unrefined.into()) {
            // What few walks tell of a step differs much from step to step.
            let known = u64::from(self.rate);
            let rate = if known == 0 {
                rate
            } else {
                (3 * known + rate) / 4
            };
            self.rate = rate.min(u32::MAX.into()) as u32;
        }
        let gain = u64::from(self.rate) * u64::from(self.entered) / RATE;
        self.enough = enough_after(gain, self.cost.into()).min(u32::MAX.into()) as u32;
        [self.at, self.gain, self.unrefined, self.entered] = [0; 4];
        gain
    }
}

/// The branches as a walk sees them.
#[derive(Debug)]
pub(crate) struct Branches<'r> {
    slots: &'r mut [Branch],
    first_root: u32,
    /// What walks would have gained in branches that are not refined.
    open: &'r mut u64,
    is_due: &'r mut bool,
}

impl Branches<'_> {
    /// The same for a shorter time.
    pub(crate) fn again(&mut self) -> Branches<'_> {
        Branches {
            slots: self.slots,
            first_root: self.first_root,
            open: self.open,
            is_due: self.is_due,
        }
    }

    /// A walk comes to a node above or at the root of a branch: which branch it is, if any, and where that is refined, if it is.
    #[inline]
    pub(crate) fn enter(&mut self, node: u32) -> (Option<u32>, Option<u32>) {
        let number = node.wrapping_sub(self.first_root);
        let Some(branch) = self.slots.get_mut(number as usize) else {
            return (None, None);
        };
        branch.entered = branch.entered.saturating_add(1);
        let at = Some(branch.at).filter(|at| *at > 0);
        branch.unrefined = (branch.unrefined).saturating_add(u32::from(at.is_none()));
        (Some(number), at)
    }

    /// Where the branch with this root is refined.
    #[inline]
    pub(crate) fn refined(&self, root: u32) -> Option<u32> {
        let number = root.wrapping_sub(self.first_root);
        let at = self.slots.get(number as usize)?.at;
        Some(at).filter(|at| *at > 0)
    }

    /// A walk would have gained so much in a branch.
    #[inline]
    pub(crate) fn count(&mut self, number: u32, gain: u64) {
        *self.open = self.open.saturating_add(gain);
        if let Some(branch) = self.slots.get_mut(number as usize) {
            branch.gain = (branch.gain).saturating_add(gain.min(u32::MAX.into()) as u32);
            *self.is_due |= branch.gain >= branch.enough;
        }
    }
}

/// How much there is of what memory holds.
#[derive(Debug, Clone, Copy)]
struct Layout {
    branches: usize,
    nodes: usize,
    leaves: usize,
    /// Nodes above the branches, and so the first root.
    tops: usize,
}

impl Layout {
    /// For so many bytes; `None` where there are too few or the mesh is too small.
    fn new(asset: &Asset<'_>, counts: Counts, bytes: usize) -> Option<Self> {
        let roots = roots(asset)?;
        let (branches, tops) = (roots.len(), roots.start);
        let fixed = (size_of::<Branch>().saturating_mul(branches))
            .saturating_add(size_of::<RefinedNode>().saturating_mul(tops));
        let [below, leaves] = [counts.nodes.checked_sub(tops)?, counts.leaves];
        let all = (size_of::<RefinedNode>().saturating_mul(below))
            .saturating_add(size_of::<RefinedLeaf>().saturating_mul(leaves));
        let room = bytes.checked_sub(fixed)?.min(all);
        let share = |count: usize| (count as u128 * room as u128 / (all as u128).max(1)) as usize;
        let layout = Self {
            branches,
            nodes: tops + share(below),
            leaves: share(leaves),
            tops,
        };
        // Room for two branches at least.
        (branches as u64 * share(leaves) as u64 >= 2 * leaves as u64).then_some(layout)
    }
}

/// The roots of branches: the nodes of the level that has about as many as there are branches of [`BRANCH`] triangles.
fn roots(asset: &Asset<'_>) -> Option<Range<usize>> {
    // Numbers of nodes and triangles, and of branches, share a word with another one each.
    if asset.triangle_count().max(asset.node_count()) >= UNREFINED as usize {
        return None;
    }
    let wanted = (asset.triangle_count() / BRANCH) as u64;
    if wanted < BRANCHES_LEAST as u64 {
        return None;
    }
    let mut tops = 1;
    for level in 1..asset.depth() {
        let end = asset.node_count_to(level);
        let [count, next] = [tops..end, end..asset.node_count_to(level + 1)].map(|of| of.len());
        // The next level is farther from what is wanted where the geometric mean of both is beyond that.
        if next <= count || count as u64 * next as u64 > wanted * wanted {
            let is_fit = (BRANCHES_LEAST..1 << 24).contains(&count);
            return is_fit.then_some(tops..end);
        }
        tops = end;
    }
    None
}

/// The branches of a cache over steps.
#[derive(Debug, Default)]
pub(super) struct BranchCache {
    layout: Option<Layout>,
    /// Of what the layout is: an asset and so many bytes.
    of: Option<((usize, u32), usize)>,
    /// Memory holds the branches, and what is known of them.
    is_known: bool,
    /// Memory holds this step's boxes of what is above them.
    is_active: bool,
    /// Nodes and leaves in use.
    used: [usize; 2],
    is_full: bool,
    open: u64,
    is_due: bool,
    /// Triangles of refined branches, and what refining them has cost.
    triangles: usize,
    spent: u64,
}

impl BranchCache {
    /// Lays them out in this memory, if that has not been done; whether there are any.
    pub(super) fn lay_out(&mut self, asset: &Asset<'_>, memory: &mut Memory<'_>) -> bool {
        let bytes = match memory.grows() {
            true => usize::MAX,
            false => memory.len(),
        };
        let of = Some((identity(asset), bytes));
        if self.of != of {
            let counts = Counts::of(asset).ok();
            *self = Self {
                layout: counts.and_then(|counts| Layout::new(asset, counts, bytes)),
                of,
                ..Self::default()
            };
        }
        self.layout.is_some()
    }

    /// What a branch costs on average, and what is above the branches.
    pub(super) fn costs(&self, whole: u64) -> [u64; 2] {
        self.layout.map_or([0; 2], |layout| {
            [
                whole / layout.branches as u64,
                TOP_COST * layout.tops as u64,
            ]
        })
    }

    /// Whether there are any.
    pub(super) fn are_there(&self) -> bool {
        self.layout.is_some()
    }

    /// What refining branches has cost in this step.
    pub(super) fn spent(&self) -> u64 {
        self.spent
    }

    pub(super) fn is_active(&self) -> bool {
        self.is_active
    }

    pub(super) fn triangles(&self) -> usize {
        self.triangles
    }

    /// What walks of this step would have gained where it is not refined.
    pub(super) fn open(&self) -> u64 {
        self.open
    }

    /// Memory is used for something else.
    pub(super) fn forget(&mut self) {
        self.is_known = false;
        self.leave();
    }

    fn leave(&mut self) {
        self.is_active = false;
        (self.triangles, self.is_due, self.open, self.spent) = (0, false, 0, 0);
    }

    /// Begins another step; what branches cost if the next step is like this one, what refining those that pay saves then, and what
    /// walks would have gained in branches that were not refined.
    pub(super) fn next_step(&mut self, memory: &mut Memory<'_>) -> Option<[u64; 3]> {
        let layout = self.layout.filter(|_| self.is_active);
        let open = self.open;
        self.leave();
        let (branches, ..) = self.carve(memory, layout?)?;
        let [mut cost, mut saved] = [0_u64; 2];
        for branch in branches {
            let gain = branch.next_step();
            let least = gain.min(branch.cost.into());
            cost = cost.saturating_add(least);
            saved = saved.saturating_add(gain - least);
        }
        Some([cost, saved, open])
    }

    fn carve<'m>(&self, memory: &'m mut Memory<'_>, layout: Layout) -> Option<Parts<'m>> {
        let counts = [layout.branches, layout.nodes, layout.leaves];
        memory.three_slots(counts).ok()
    }

    /// Finds the boxes above the branches; whether that has been done.
    pub(super) fn activate(&mut self, pose: &Pose<'_>, memory: &mut Memory<'_>) -> bool {
        let Some(layout) = self.layout else {
            return false;
        };
        let Some((branches, nodes, _)) = self.carve(memory, layout) else {
            return false;
        };
        if !self.is_known {
            for (number, branch) in branches.iter_mut().enumerate() {
                let triangles = triangles_below(pose.asset, layout.tops + number);
                // Vertices are deformed for each of their triangles.
                let cost = cost_of(pose.asset, triangles).saturating_mul(5) / 2;
                let cost = cost.min(u32::MAX.into()) as u32;
                *branch = Branch::new(cost);
            }
        }
        let nodes = nodes.get_mut(..layout.tops).unwrap_or_default();
        self.is_active = pose.asset.kernel.run(Tops { pose, nodes }).is_ok();
        if !self.is_active {
            // A damaged asset is what walks tell of.
            self.layout = None;
        }
        self.is_known = true;
        self.used = [layout.tops, 0];
        self.is_full = false;
        self.is_active
    }

    /// Refines what pays: branches that have had enough, or will have after so many walks more for each one so far, if they go on like
    /// those.
    pub(super) fn refine(&mut self, pose: &Pose<'_>, memory: &mut Memory<'_>, more: u64) {
        if self.is_full || !(self.is_due || more > 0) {
            return;
        }
        self.is_due = false;
        let Some(layout) = self.layout else {
            return;
        };
        let Some((branches, nodes, leaves)) = self.carve(memory, layout) else {
            return;
        };
        for (number, branch) in branches.iter_mut().enumerate() {
            let (gain, cost) = (u64::from(branch.gain), u64::from(branch.cost));
            let is_foreseen = more > 0 && gain.saturating_mul(1 + more) >= cost;
            let is_due = gain >= branch.enough.into() || is_foreseen;
            if branch.at > 0 || gain == 0 || !is_due || branch.cost == u32::MAX {
                continue;
            }
            let [used_nodes, used_leaves] = self.used;
            let (above, nodes) = nodes.split_at_mut(used_nodes.min(nodes.len()));
            let tops = above.get_mut(..layout.tops).unwrap_or_default();
            let room = Room {
                nodes: &mut *nodes,
                first_node: used_nodes as u32,
                leaves: leaves.get_mut(used_leaves..).unwrap_or_default(),
                first_leaf: used_leaves as u32,
            };
            let root = layout.tops + number;
            match refine(pose, root, room) {
                Ok(Some([more_nodes, more_leaves])) => {
                    branch.at = used_nodes as u32;
                    self.used = [used_nodes + more_nodes, used_leaves + more_leaves];
                    self.open = self.open.saturating_sub(gain);
                    self.spent = self.spent.saturating_add(cost);
                    let triangles = triangles_below(pose.asset, root);
                    self.triangles = self.triangles.saturating_add(triangles);
                    if let Some(refined) = nodes.first() {
                        tighten(pose.asset, tops, root, refined);
                    }
                }
                Ok(None) => {
                    self.is_full = true;
                    return;
                }
                Err(_) => {
                    // Never again.
                    (branch.cost, branch.enough, branch.gain) = (u32::MAX, u32::MAX, 0);
                    self.open = self.open.saturating_sub(gain);
                }
            }
        }
    }

    /// What refining would cost, where that is less than what it would save, if each walk so far is followed by so many more.
    pub(super) fn worth(&self, memory: &mut Memory<'_>, more: u64) -> u64 {
        let layout = self.layout.filter(|_| self.is_active);
        let parts = layout.and_then(|layout| self.carve(memory, layout));
        let Some((branches, ..)) = parts else {
            return 0;
        };
        let open = branches.iter().filter(|branch| branch.at == 0);
        open.map(|branch| {
            let gain = u64::from(branch.gain).saturating_mul(1 + more);
            gain.min(branch.cost.into())
        })
        .sum()
    }

    /// What walks see.
    pub(super) fn view<'m>(
        &'m mut self,
        memory: &'m mut Memory<'_>,
    ) -> Option<(Refined<'m>, Branches<'m>)> {
        let layout = self.layout.filter(|_| self.is_active)?;
        let (slots, nodes, leaves) = self.carve(memory, layout)?;
        let refined = Refined {
            nodes,
            leaves,
            vertices: &[],
            added: 0.0,
        };
        let branches = Branches {
            slots,
            first_root: layout.tops as u32,
            open: &mut self.open,
            is_due: &mut self.is_due,
        };
        Some((refined, branches))
    }
}

type Parts<'m> = (
    &'m mut [Branch],
    &'m mut [RefinedNode],
    &'m mut [RefinedLeaf],
);
