//! A pose as traversals see it: spheres and leaves, kept or computed now.

use bdtree_format::{ROWS_LEADING, TriangleRecord};

use super::slots::{CHUNK, LeafChunk, LeafSlot, NodeSlot, leaf_place, place, tag};
use super::step::Kept;
use crate::bound::{WideSpheres, evaluate};
use crate::depth::DepthLimit;
use crate::epoch::Drift;
use crate::error::FormatError;
use crate::pose::Pose;
use crate::refined::{Bounds, Refined};
use crate::simd::{Lanes, Work, prefetch, prefetch_from};
use crate::view::Asset;

/// A pose to query, with what a step keeps of it and how deep it is looked into.
#[derive(Debug)]
pub(crate) struct Posed<'s> {
    pub(crate) pose: &'s Pose<'s>,
    pub(super) drift: Option<(&'s Pose<'s>, Drift)>,
    kept: Kept<'s>,
    pub(crate) limit: Option<DepthLimit<'s>>,
    /// What of the same pose is refined: all of it, not for walks that report spheres, or branches, for walks that ask boxes.
    pub(crate) refined: Bounds<'s>,
}

impl<'s> Posed<'s> {
    /// A pose with what is kept of it. `drift`: the pose at which nodes are evaluated, if it is another, and
    /// how far away that is.
    #[inline]
    pub(crate) fn new(
        pose: &'s Pose<'s>,
        drift: Option<(&'s Pose<'s>, Drift)>,
        kept: Kept<'s>,
        limit: Option<DepthLimit<'s>>,
    ) -> Self {
        Self {
            pose,
            drift,
            kept,
            limit,
            refined: Bounds::Unrefined,
        }
    }
}

/// What one query keeps for itself where the caller grants no [`StepCache`].
#[derive(Default)]
pub(crate) struct OwnCache {
    pub(super) nodes: Option<[NodeSlot; 32]>,
    pub(super) leaves: Option<[LeafSlot; 16]>,
}

impl<'s> Posed<'s> {
    /// The same for a shorter time.
    pub(crate) fn shorter<'t>(self) -> Posed<'t>
    where
        's: 't,
    {
        Posed {
            pose: self.pose,
            drift: self.drift,
            kept: self.kept,
            limit: self.limit.map(DepthLimit::shorter),
            refined: self.refined,
        }
    }

    /// The same, with room for all nodes of `asset` or N of them, which are put into `spare` if need be.
    pub(crate) fn at_least<'t, const N: usize>(
        self,
        asset: &Asset<'_>,
        spare: &'t mut Option<[NodeSlot; N]>,
    ) -> Posed<'t>
    where
        's: 't,
    {
        let mut posed = self.shorter();
        if posed.kept.nodes.len() < N.min(asset.node_count()) {
            posed.kept.nodes = spare.insert([NodeSlot::EMPTY; N]);
        }
        posed
    }

    /// The same, with `own` to keep things in if there is nothing else.
    pub(crate) fn or_keep<'t>(self, own: &'t mut OwnCache) -> Posed<'t>
    where
        's: 't,
    {
        let mut posed = self.shorter();
        if posed.kept.nodes.is_empty() && posed.kept.leaves.is_empty() {
            posed.kept.nodes = own.nodes.insert([NodeSlot::EMPTY; 32]);
            posed.kept.leaves = own.leaves.insert([LeafSlot::EMPTY; 16]);
        }
        posed
    }
}

impl Posed<'_> {
    /// The same, for one of several queries.
    pub(crate) fn again(&mut self) -> Posed<'_> {
        Posed {
            pose: self.pose,
            drift: self.drift,
            kept: self.kept.again(),
            limit: self.limit.as_mut().map(DepthLimit::again),
            refined: self.refined.again(),
        }
    }

    /// Whether walks that ask boxes find some.
    pub(crate) fn has_boxes(&self) -> bool {
        !matches!(self.refined, Bounds::Unrefined)
    }

    /// No deformed vertex and no lane center is farther from the origin, not where the spheres are
    /// evaluated either; and the slack that goes with it (stored units).
    pub(crate) fn reach_and_slack(&self) -> [f64; 2] {
        let of = |pose: &Pose<'_>| [pose.reach, f64::from(pose.slack)];
        let ([reach, slack], there) = (of(self.pose), self.drift.map(|(pose, _)| of(pose)));
        there.map_or([reach, slack], |there| {
            [reach.max(there[0]), slack.max(there[1])]
        })
    }

    /// Whether leaves are kept.
    #[inline(always)]
    pub(crate) fn keeps_leaves(&self) -> bool {
        !self.kept.leaves.is_empty()
    }

    /// Whether node `index` is kept.
    #[inline(always)]
    pub(crate) fn keeps_node(&self, index: u32) -> bool {
        let slot = self
            .kept
            .nodes
            .get(place(index as usize, self.kept.nodes.len()));
        slot.is_some_and(|slot| slot.tag == tag(self.kept.epoch, index))
    }

    /// Whether the triangles from `start` on are kept.
    #[inline(always)]
    pub(crate) fn keeps_leaf(&self, start: u32) -> bool {
        let slot = self
            .kept
            .leaves
            .get(leaf_place(start, self.kept.leaves.len()));
        slot.is_some_and(|slot| slot.tag == tag(self.kept.step, start))
    }

    /// Asks for a node's record and the beginning of its rows; reading on is the processor's own habit.
    /// Also where the spheres are kept: whether they are would have to be waited for, and so would the
    /// record, so only where all modes act on all nodes, which is the usual case: there the index
    /// says where the rows are.
    #[inline(always)]
    pub(crate) fn prefetch_node(&self, asset: &Asset<'_>, index: u32) {
        /// Of 64 bytes: two rows each, or four of 16 bits. All of a node of ten modes.
        const LINES: usize = 18;
        let index = index as usize;
        let Some(node) = asset.nodes.get(index) else {
            return; // the visit says so
        };
        prefetch(node);
        if asset.row_stride > 0 {
            let start = index * asset.row_stride;
            // At rest the rows of modes are not read.
            let len = if self.pose.bounds_at_rest() {
                ROWS_LEADING
            } else {
                asset.row_stride
            };
            let Some(rows) = asset.rows.get(start..start + len) else {
                return; // as above
            };
            match rows.first_chunk::<{ 2 * LINES }>() {
                // Of a known number of lines each is one instruction.
                Some(rows) => prefetch_from(rows, 0, rows.len()),
                None => prefetch_from(rows, 0, rows.len()),
            }
        }
    }

    /// Puts the spheres of node `index` into `out`; whether they had to be evaluated. Not part of
    /// the result: a register in a place that may hold an error instead is taken apart byte by byte.
    #[inline(always)]
    pub(crate) fn spheres<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<bool, FormatError> {
        if L::IS_COMPACT {
            return self.spheres_apart(asset, index, out);
        }
        self.spheres_here(asset, index, out)
    }

    /// [`Posed::spheres`] in a function of its own, for instruction sets that everything is compiled with.
    #[inline(never)]
    fn spheres_apart<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<bool, FormatError> {
        self.spheres_here(asset, index, out)
    }

    #[inline(always)]
    fn spheres_here<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<bool, FormatError> {
        if let Some(refined) = self.refined.whole() {
            core::hint::cold_path(); // the other way is the one that must not wait
            refined.spheres(asset, index, out)?;
            return Ok(false);
        }
        let pose = self.drift.map_or(self.pose, |(reference, _)| reference);
        let evaluated = self.spheres_at::<L>(asset, index, pose, out)?;
        if let Some((_, drift)) = self.drift {
            let rows = asset.node_rows(asset.node(index)?)?;
            *out = out.grown(drift.wide(rows.steps));
        }
        Ok(evaluated)
    }

    /// [`Posed::spheres`] at the pose where nodes are evaluated.
    #[inline(always)]
    fn spheres_at<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
        pose: &Pose<'_>,
        out: &mut WideSpheres<L>,
    ) -> Result<bool, FormatError> {
        let tag = tag(self.kept.epoch, index);
        let place = place(index as usize, self.kept.nodes.len());
        if let Some(slot) = self.kept.nodes.get(place)
            && slot.tag == tag
        {
            *out = WideSpheres::load(&slot.spheres);
            return Ok(false);
        }
        let node = asset.node(index)?;
        let (rows, modes) = (asset.node_rows(node)?, asset.node_modes(node)?);
        let Some(mut spheres) = evaluate::<L>(&rows, modes, &pose.bound()) else {
            return Err(asset.unknown_mode(node.mode_list_start));
        };
        if let Some(bones) = pose.bones() {
            let mut carried = spheres.store();
            asset.carry(index, bones, &mut carried)?;
            spheres = WideSpheres::load(&carried);
        }
        if let Some(slot) = self.kept.nodes.get_mut(place) {
            slot.tag = tag;
            slot.spheres = spheres.store();
        }
        *out = spheres;
        Ok(true)
    }

    /// The first four of `records`, the triangles from `start` on, deformed: kept, or made in `spare`.
    #[inline(always)]
    pub(crate) fn leaf<'l>(
        &'l mut self,
        asset: &Asset<'_>,
        start: u32,
        records: &[TriangleRecord],
        spare: &'l mut LeafChunk,
    ) -> Result<&'l LeafChunk, FormatError> {
        let (pose, refined) = (self.pose, self.refined.whole());
        let tag = tag(self.kept.step, start);
        let len = records.len().min(CHUNK) as u32;
        let place = leaf_place(start, self.kept.leaves.len());
        let Some(slot) = self.kept.leaves.get_mut(place) else {
            deform(asset, pose, refined, records, spare)?;
            return Ok(spare);
        };
        // In a corrupt file one slot may begin leaves of several lengths.
        if slot.tag != tag || slot.leaf.len != len {
            slot.tag = 0; // until it is whole
            deform(asset, pose, refined, records, &mut slot.leaf)?;
            slot.tag = tag;
        }
        Ok(&slot.leaf)
    }
}

/// [`LeafChunk::deform`] as work of its own.
#[inline(always)]
pub(crate) fn deform(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    refined: Option<&Refined<'_>>,
    records: &[TriangleRecord],
    chunk: &mut LeafChunk,
) -> Result<(), FormatError> {
    asset.kernel.run(Deform {
        asset,
        pose,
        refined,
        records,
        chunk,
    })
}

struct Deform<'d, 'a> {
    asset: &'d Asset<'a>,
    pose: &'d Pose<'d>,
    refined: Option<&'d Refined<'d>>,
    records: &'d [TriangleRecord],
    chunk: &'d mut LeafChunk,
}

impl Work for Deform<'_, '_> {
    type Output = Result<(), FormatError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        (self.chunk).deform::<L>(self.asset, self.pose, self.refined, self.records)
    }
}
