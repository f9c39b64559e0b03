//! Recomputes what the bone rows of every lane bound from the influences of the vertices below it (SPEC 6.10).

use bdtree_format::{
    BONE_ROW_DEFECT, BONE_ROW_SCALE, BONE_ROW_SPREAD, BONE_ROWS_FIXED, BONE_ROWS_PER_BONE, LANES,
    SectionKind,
};
use core::mem::size_of;
use core::ops::{ControlFlow, Range};

use super::Report;
use crate::error::{Check, Datum};
use crate::rounding::{CHECKED_SUM, U32};
use crate::view::{Asset, NodeBones, Skin};

impl Asset<'_> {
    /// Recomputes what the bone rows bound. Needs a sound tree and sound influences.
    pub(super) fn bone_bounds(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some(skin) = &self.skin else {
            return ControlFlow::Continue(());
        };
        for (index, node) in self.nodes.iter().enumerate() {
            let Some(own) = skin.node_bones(index) else {
                continue; // reported before
            };
            let used = node.inner_mask | node.leaf_mask;
            for lane in (0..LANES).filter(|lane| used & (1 << lane) != 0) {
                let check = LaneBones {
                    asset: self,
                    skin,
                    node: index,
                    own: &own,
                    lane,
                };
                check.middles(report)?;
                self.slots_below(node, lane, |slots| check.triangles(slots, report))?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// One lane whose bone rows are recomputed.
struct LaneBones<'c, 'a> {
    asset: &'c Asset<'a>,
    skin: &'c Skin<'a>,
    node: usize,
    own: &'c NodeBones<'a>,
    lane: usize,
}

impl LaneBones<'_, '_> {
    /// The place of a row's number.
    fn row(&self, row: usize) -> Check {
        let start = self.skin.list_starts[self.node] as usize;
        self.asset.bone_row_place(self.node, start, row, self.lane)
    }

    /// w⁻ and w⁺ of the node's k-th bone.
    fn weights(&self, k: usize) -> [f32; BONE_ROWS_PER_BONE] {
        self.own.weights[k].map(|row| row[self.lane])
    }

    /// β of the node's k-th bone, each operation rounded to f32.
    fn middle(&self, k: usize) -> f64 {
        let [least, largest] = self.weights(k);
        f64::from(self.own.fixed[BONE_ROW_SCALE][self.lane] * (least + largest))
    }

    /// The middles sum to 1. Where no bone moves anything they are zero.
    fn middles(&self, report: Report<'_>) -> ControlFlow<()> {
        let m = self.own.bones.len();
        if (0..m).all(|k| self.weights(k) == [0.0; BONE_ROWS_PER_BONE]) {
            return ControlFlow::Continue(());
        }
        let sum: f64 = (0..m).map(|k| self.middle(k)).sum();
        let most = (m + 4) as f64 * U32 + CHECKED_SUM * sum.abs();
        self.row(BONE_ROW_SCALE)
            .rule("SPEC 6.10: the middles of the weights sum to 1 within (m + 4) u")
            .tell(report, (sum - 1.0).abs() <= most, 1.0, sum)
    }

    fn triangles(&self, slots: Range<usize>, report: Report<'_>) -> ControlFlow<()> {
        for triangle in self.asset.triangles.get(slots).unwrap_or_default() {
            for corner in triangle.corners {
                self.vertex(corner as usize, report)?;
            }
        }
        ControlFlow::Continue(())
    }

    fn vertex(&self, vertex: usize, report: Report<'_>) -> ControlFlow<()> {
        let Some(influences) = self.skin.influences_of(vertex) else {
            return ControlFlow::Continue(()); // reported before
        };
        let (mut sum, mut apart) = (0.0, 0.0);
        // The node's bones before the k-th are done.
        let mut k = 0;
        let mut bone = |k: usize, weight: f32, report: Report<'_>| {
            apart += (f64::from(weight) - self.middle(k)).abs();
            self.range(k, weight, report)
        };
        for influence in influences {
            sum += f64::from(influence.weight);
            let before = |b: &&u16| **b < influence.bone;
            let skipped = self.own.bones[k..].iter().take_while(before).count();
            for k in k..k + skipped {
                bone(k, 0.0, report)?;
            }
            k += skipped;
            if self.own.bones.get(k) == Some(&influence.bone) {
                bone(k, influence.weight, report)?;
                k += 1;
            } else {
                let start = self.skin.list_starts[self.node] as usize;
                let at = size_of::<u16>() * start;
                let place = self.asset.at(SectionKind::BONE_LISTS, at);
                let rule = "SPEC 6.10: a bone that a node leaves out moves no vertex below it";
                report(place.rule(rule).broken("in the list", influence.bone))?;
            }
        }
        for k in k..self.own.bones.len() {
            bone(k, 0.0, report)?;
        }
        let [spread, defect] =
            [BONE_ROW_SPREAD, BONE_ROW_DEFECT].map(|row| f64::from(self.own.fixed[row][self.lane]));
        if apart * (1.0 - CHECKED_SUM) > spread {
            let rule =
                "SPEC 6.10: S reaches the distances of every vertex's weights from the middles";
            report(
                self.row(BONE_ROW_SPREAD)
                    .rule(rule)
                    .broken(Datum::AtLeast(apart), spread),
            )?;
        }
        let own = (sum - 1.0_f64).abs();
        if own - CHECKED_SUM * sum > defect {
            let rule = "SPEC 6.10: epsilon reaches the distance of every sum of weights from 1";
            report(
                self.row(BONE_ROW_DEFECT)
                    .rule(rule)
                    .broken(Datum::AtLeast(own), defect),
            )?;
        }
        ControlFlow::Continue(())
    }

    /// The weight of the node's k-th bone lies in its range.
    fn range(&self, k: usize, weight: f32, report: Report<'_>) -> ControlFlow<()> {
        let [least, largest] = self.weights(k);
        let first = BONE_ROWS_FIXED + BONE_ROWS_PER_BONE * k;
        let rule = "SPEC 6.10: the ranges of weights hold those of every vertex below the lane";
        if weight < least {
            report(
                self.row(first)
                    .rule(rule)
                    .broken(Datum::at_most(weight), least),
            )?;
        }
        if weight > largest {
            report(
                self.row(first + 1)
                    .rule(rule)
                    .broken(Datum::at_least(weight), largest),
            )?;
        }
        ControlFlow::Continue(())
    }
}
