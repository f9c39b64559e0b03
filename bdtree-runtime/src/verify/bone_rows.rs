//! Recomputes what the bone rows of every lane bound from the influences of the vertices below it (SPEC 6.10).

use bdtree_format::{
    BONE_ROW_DEFECT, BONE_ROW_SPREAD, BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY, BoneEntry, LANES,
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

    /// The entries that the lane has a bone in: index, bone, β and g.
    fn entries(&self) -> impl Iterator<Item = (usize, u16, [f32; BONE_ROWS_PER_ENTRY])> {
        let (lane, entries) = (self.lane, self.own.entries.iter().zip(self.own.weights));
        entries.enumerate().filter_map(move |(k, (entry, rows))| {
            let rows = rows.map(|row| row[lane]);
            (rows[0] != 0.0).then_some((k, entry[lane], rows))
        })
    }

    /// The middles sum to 1. Where no bone moves anything they are zero.
    fn middles(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some((first, ..)) = self.entries().next() else {
            return ControlFlow::Continue(());
        };
        let m = self.own.entries.len();
        let sum: f64 = self
            .entries()
            .map(|(.., [middle, _])| f64::from(middle))
            .sum();
        let most = (m + 4) as f64 * U32 + CHECKED_SUM * sum.abs();
        self.row(BONE_ROWS_FIXED + BONE_ROWS_PER_ENTRY * first)
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
        let sum: f64 = influences.iter().map(|own| f64::from(own.weight)).sum();
        let (mut apart, mut found) = (0.0, 0);
        for (k, bone, [middle, gap]) in self.entries() {
            let own = influences.binary_search_by_key(&bone, |own| own.bone);
            let weight = own.map_or(0.0, |i| influences[i].weight);
            found += usize::from(own.is_ok());
            apart += (f64::from(weight) - f64::from(middle)).abs();
            self.range(k, weight, [middle, gap], report)?;
        }
        // No bone is there twice, or it was reported before.
        if found < influences.len() {
            let missing = (influences.iter().map(|own| own.bone))
                .find(|bone| self.entries().all(|(_, other, _)| other != *bone));
            let start = self.skin.list_starts[self.node] as usize;
            let at = size_of::<BoneEntry>() * start + size_of::<u16>() * self.lane;
            let place = self.asset.at(SectionKind::BONE_LISTS, at);
            let rule = "SPEC 6.10: a bone that a lane leaves out moves no vertex below it";
            if let Some(bone) = missing {
                report(place.rule(rule).broken("in the lane", bone))?;
            }
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

    /// A weight of the k-th entry's bone lies in its range.
    fn range(
        &self,
        k: usize,
        weight: f32,
        [middle, gap]: [f32; BONE_ROWS_PER_ENTRY],
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let row = BONE_ROWS_FIXED + BONE_ROWS_PER_ENTRY * k + 1;
        let rule = "SPEC 6.10: g reaches from beta to the weights of every vertex below the lane";
        let apart = (f64::from(weight) - f64::from(middle)).abs();
        if apart * (1.0 - CHECKED_SUM) > f64::from(gap) || weight < middle - gap {
            report(self.row(row).rule(rule).broken(Datum::AtLeast(apart), gap))?;
        }
        ControlFlow::Continue(())
    }
}
