//! The skin: influences of vertices, bones, and the lists of nodes (SPEC 6.10, 7.7, 7.8).

use bdtree_format::{
    BONE_COUNT_MAX, BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY, BoneEntry, BoneRecord, InfluenceRecord,
    LANES, Row, SectionKind, SkinRecord, TRANSLATION_MAX, WEIGHT_MAX, WEIGHT_MIN,
};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::{FINITE, Report, is_stored};
use crate::contact::VertexId;
use crate::error::Datum;
use crate::math::norm;
use crate::rounding::{CHECKED_NORM, CHECKED_SUM};
use crate::view::{Asset, NodeBones, Skin};

impl Asset<'_> {
    /// Everything of a skin but what its rows bound.
    pub(super) fn skin_order(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some(skin) = &self.skin else {
            return ControlFlow::Continue(());
        };
        self.skin_numbers(skin, report)?;
        self.starts(
            (SectionKind::INFLUENCE_STARTS, skin.influence_starts),
            skin.influences.len(),
            "SPEC 7.7: INFS begins with 0, does not decrease and ends with the length of INFL",
            report,
        )?;
        self.starts(
            (SectionKind::BONE_LIST_STARTS, skin.list_starts),
            skin.lists.len(),
            "SPEC 6.10: BLSS begins with 0, does not decrease and ends with the length of BLST",
            report,
        )?;
        self.vertex_influences(skin, report)?;
        self.bone_records(skin, report)?;
        self.node_bone_lists(skin, report)
    }

    /// The first number of each section that is none.
    fn skin_numbers(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        for (offset, x) in [
            (
                offset_of!(SkinRecord, weight_defect),
                skin.record.weight_defect,
            ),
            (offset_of!(SkinRecord, minor_share), skin.record.minor_share),
        ] {
            self.at(SectionKind::SKIN, offset).rule(FINITE).tell(
                report,
                is_stored(x),
                "a normal number or zero",
                x,
            )?;
        }
        for (kind, numbers) in [
            (SectionKind::BONE_FIELDS, skin.bone_fields),
            (SectionKind::BONE_ROWS, skin.rows.as_flattened()),
        ] {
            if let Some(i) = numbers.iter().position(|x| !is_stored(*x)) {
                let place = self.at(kind, size_of::<f32>() * i).rule(FINITE);
                report(place.broken("a normal number or zero", numbers[i]))?;
            }
        }
        for (b, bone) in skin.bones.iter().enumerate() {
            let at = |offset| self.at(SectionKind::BONES, b * size_of::<BoneRecord>() + offset);
            for (offset, numbers) in [
                (offset_of!(BoneRecord, rest), bone.rest.as_flattened()),
                (offset_of!(BoneRecord, low), &bone.low),
                (offset_of!(BoneRecord, high), &bone.high),
                (offset_of!(BoneRecord, core_low), &bone.core_low),
                (offset_of!(BoneRecord, core_high), &bone.core_high),
            ] {
                if let Some(i) = numbers.iter().position(|x| !is_stored(x.get())) {
                    let place = at(offset + size_of::<f32>() * i).rule(FINITE);
                    report(place.broken("a normal number or zero", numbers[i].get()))?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Running counts from 0 to the length of what they count.
    fn starts(
        &self,
        (kind, starts): (SectionKind, &[u32]),
        length: usize,
        rule: &'static str,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let at = |i: usize| self.at(kind, size_of::<u32>() * i).rule(rule);
        if let Some(first) = starts.first().filter(|first| **first != 0) {
            report(at(0).broken(0_u32, *first))?;
        }
        for (i, pair) in starts.windows(2).enumerate() {
            if pair[1] < pair[0] {
                report(at(i + 1).broken(Datum::at_least(pair[0]), pair[1]))?;
            }
        }
        match starts.last() {
            Some(last) if *last as usize != length => {
                report(at(starts.len() - 1).broken(length, *last))
            }
            _ => ControlFlow::Continue(()),
        }
    }

    /// Bones ascending, weights in range, and what SKIN says of them.
    fn vertex_influences(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        let (mut most, mut defect_max) = (0, 0.0_f64);
        for vertex in 0..self.positions.len() {
            let Some(own) = skin.influences_of(vertex) else {
                continue; // reported with the starts
            };
            let first = skin.influence_starts[vertex] as usize;
            let at = |k: usize, offset: usize| {
                let start = (first + k) * size_of::<InfluenceRecord>();
                self.at(SectionKind::INFLUENCES, start + offset)
            };
            let mut sum = 0.0;
            for (k, influence) in own.iter().enumerate() {
                let InfluenceRecord {
                    weight,
                    bone,
                    reserved,
                } = *influence;
                at(k, offset_of!(InfluenceRecord, weight))
                    .rule("SPEC 7.7: weights are 2^-32 to 2")
                    .tell(
                        report,
                        (WEIGHT_MIN..=WEIGHT_MAX).contains(&weight),
                        Datum::Within(WEIGHT_MIN.into(), WEIGHT_MAX.into()),
                        weight,
                    )?;
                let ascends = k == 0 || own[k - 1].bone < bone;
                let known = usize::from(bone) < skin.bones.len();
                at(k, offset_of!(InfluenceRecord, bone))
                    .rule("SPEC 7.7: the bones of a vertex ascend and are bones of the file")
                    .tell(
                        report,
                        ascends && known,
                        if known {
                            "a bone behind the one before".into()
                        } else {
                            Datum::Below(skin.bones.len() as u64)
                        },
                        bone,
                    )?;
                at(k, offset_of!(InfluenceRecord, reserved))
                    .rule("SPEC 7.7: reserved numbers are zero")
                    .tell(report, reserved == 0, 0_u32, reserved)?;
                sum += f64::from(weight);
            }
            at(0, 0)
                .rule("SPEC 7.7: the weights of a vertex sum to 2 at most")
                .tell(
                    report,
                    !(sum * (1.0 - CHECKED_SUM) > f64::from(WEIGHT_MAX)),
                    Datum::at_most(WEIGHT_MAX),
                    sum,
                )?;
            most = most.max(own.len());
            let defect = (sum - 1.0).abs() - CHECKED_SUM * sum;
            if defect.is_finite() {
                defect_max = defect_max.max(defect);
            }
        }
        let at = |offset| self.at(SectionKind::SKIN, offset);
        let found = skin.record.influences_max;
        at(offset_of!(SkinRecord, influences_max))
            .rule("SPEC 7.7: influences_max is the largest number of influences of a vertex")
            .tell(report, most == found as usize, most, found)?;
        let found = f64::from(skin.record.weight_defect);
        at(offset_of!(SkinRecord, weight_defect))
            .rule("SPEC 7.7: weight_defect reaches the distance of every sum of weights from 1")
            .tell(
                report,
                defect_max <= found,
                Datum::AtLeast(defect_max),
                found,
            )
    }

    /// Joints, inverse bind matrices, boxes and norms of displacements.
    fn bone_records(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        let at = |b: usize, offset: usize| {
            self.at(SectionKind::BONES, b * size_of::<BoneRecord>() + offset)
        };
        for (b, bone) in skin.bones.iter().enumerate() {
            let (joint, count) = (bone.joint.get(), skin.joints.len());
            at(b, offset_of!(BoneRecord, joint))
                .rule("SPEC 7.8: a bone's joint is one of JNTS")
                .tell(
                    report,
                    (joint as usize) < count,
                    Datum::Below(count as u64),
                    joint,
                )?;
            at(b, offset_of!(BoneRecord, reserved))
                .rule("SPEC 7.8: reserved numbers are zero")
                .tell(report, bone.reserved.get() == 0, 0_u32, bone.reserved.get())?;
            for (i, x) in bone.inverse_bind.as_flattened().iter().enumerate() {
                let start = offset_of!(BoneRecord, inverse_bind);
                at(b, start + size_of::<f64>() * i)
                    .rule("SPEC 7.8: numbers of an inverse bind matrix are at most 2^80")
                    .tell(
                        report,
                        x.get().abs() <= TRANSLATION_MAX,
                        TRANSLATION_MAX,
                        x.get(),
                    )?;
            }
        }
        // Which bones move a vertex, one bit each.
        let mut moving = [0_u64; BONE_COUNT_MAX / 64];
        let mut minor_max = 0.0_f64;
        for vertex in 0..self.positions.len() {
            for influence in skin.influences_of(vertex).unwrap_or_default() {
                let b = usize::from(influence.bone);
                if b < skin.bones.len() {
                    moving[b / 64] |= 1 << (b % 64);
                    self.moved_vertex(skin, b, vertex, report)?;
                }
            }
            minor_max = minor_max.max(self.minor_share(skin, vertex));
        }
        let found = f64::from(skin.record.minor_share);
        self.at(SectionKind::SKIN, offset_of!(SkinRecord, minor_share))
            .rule("SPEC 7.8: core boxes hold every vertex but for minor_share of its weights")
            .tell(
                report,
                minor_max * (1.0 - CHECKED_SUM) <= found,
                Datum::AtLeast(minor_max),
                found,
            )?;
        for (b, bone) in skin.bones.iter().enumerate() {
            let still = moving[b / 64] >> (b % 64) & 1 == 0;
            let whole = [bone.low, bone.high].map(|row| row.map(|x| x.get()));
            let core = [bone.core_low, bone.core_high].map(|row| row.map(|x| x.get()));
            let none = [[1.0; 3], [-1.0; 3]];
            at(b, offset_of!(BoneRecord, low))
                .rule("SPEC 7.8: a bone without vertices has a box from 1 to -1")
                .tell(report, !still || whole == none, -1.0, "another")?;
            let is_inside = (0..3).all(|k| {
                whole[0][k] <= core[0][k] && core[0][k] <= core[1][k] && core[1][k] <= whole[1][k]
            });
            at(b, offset_of!(BoneRecord, core_low))
                .rule("SPEC 7.8: a core box lies inside low and high, or is from 1 to -1")
                .tell(report, core == none || is_inside, -1.0, "another")?;
        }
        ControlFlow::Continue(())
    }

    /// The sum of the weights of those bones of a vertex whose core boxes do not hold it.
    fn minor_share(&self, skin: &Skin<'_>, vertex: usize) -> f64 {
        let position = self.positions[vertex];
        let holds = |bone: &BoneRecord| {
            (0..3)
                .all(|k| (bone.core_low[k].get()..=bone.core_high[k].get()).contains(&position[k]))
        };
        let influences = skin.influences_of(vertex).unwrap_or_default().iter();
        influences
            // A bone that does not exist is reported with the influences.
            .filter(|i| {
                skin.bones
                    .get(usize::from(i.bone))
                    .is_some_and(|b| !holds(b))
            })
            .map(|i| f64::from(i.weight))
            .sum()
    }

    /// The box and the norms of a bone against one of its vertices.
    fn moved_vertex(
        &self,
        skin: &Skin<'_>,
        b: usize,
        vertex: usize,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let (bone, position) = (&skin.bones[b], self.positions[vertex]);
        for (axis, x) in position.into_iter().enumerate() {
            let (low, high) = (bone.low[axis].get(), bone.high[axis].get());
            if x < low || x > high {
                let offset = offset_of!(BoneRecord, low) + size_of::<f32>() * axis;
                let place = self.at(SectionKind::BONES, b * size_of::<BoneRecord>() + offset);
                let rule = "SPEC 7.8: low and high hold the vertices that the bone moves";
                let (expected, found) = if x < low {
                    (Datum::at_most(x), low)
                } else {
                    (Datum::at_least(x), high)
                };
                report(place.rule(rule).broken(expected, found))?;
            }
        }
        let Ok(own) = self.displacements(VertexId(vertex as u32)) else {
            return ControlFlow::Continue(()); // reported with its record
        };
        for (mode, u) in own.iter() {
            let index = b * self.modes.len() + mode;
            let Some(most) = skin
                .bone_fields
                .get(index)
                .filter(|_| mode < self.modes.len())
            else {
                continue; // reported with its list
            };
            let (n, most) = (norm(u.map(f64::from)), f64::from(*most));
            if n * (1.0 - CHECKED_NORM) > most {
                let place = self.at(SectionKind::BONE_FIELDS, size_of::<f32>() * index);
                let rule = "SPEC 7.8: BFLD reaches every displacement of the bone's vertices";
                report(place.rule(rule).broken(Datum::AtLeast(n), most))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Bones of nodes exist, none twice in a lane; empty lanes hold zeros, others no negative bounds.
    fn node_bone_lists(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        let mut most = 0;
        for (i, node) in self.nodes.iter().enumerate() {
            let Some(own) = skin.node_bones(i) else {
                report(self.bones_of_node(i as u32))?;
                continue;
            };
            most = most.max(own.entries.len());
            let start = skin.list_starts[i] as usize;
            for lane in 0..LANES {
                self.lane_bones(skin, &own, [start, lane], report)?;
            }
            let used = node.inner_mask | node.leaf_mask;
            let rows = own.fixed.iter().chain(own.weights.as_flattened());
            for (r, row) in rows.enumerate() {
                for lane in (0..LANES).filter(|lane| used & (1 << lane) == 0) {
                    if row[lane] != 0.0 {
                        let rule = "SPEC 6.10: bone rows are zero in empty lanes";
                        let place = self.bone_row_place(i, start, r, lane).rule(rule);
                        report(place.broken(0_u32, row[lane]))?;
                    }
                }
                if let Some(lane) = row.iter().position(|x| *x < 0.0) {
                    let rule = "SPEC 6.10: bone rows are not negative";
                    let place = self.bone_row_place(i, start, r, lane).rule(rule);
                    report(place.broken(Datum::AtLeast(0.0), row[lane]))?;
                }
            }
            for (k, [middle, gap]) in own.weights.iter().enumerate() {
                for lane in (0..LANES).filter(|lane| middle[*lane] == 0.0 && gap[*lane] != 0.0) {
                    let row = BONE_ROWS_FIXED + BONE_ROWS_PER_ENTRY * k + 1;
                    let rule = "SPEC 6.10: g is zero where beta is";
                    let place = self.bone_row_place(i, start, row, lane).rule(rule);
                    report(place.broken(0_u32, gap[lane]))?;
                }
            }
        }
        let found = skin.record.node_bones_max;
        self.at(SectionKind::SKIN, offset_of!(SkinRecord, node_bones_max))
            .rule("SPEC 7.7: node_bones_max is the largest number of entries of a node")
            .tell(report, most == found as usize, most, found)
    }

    /// The bones of a lane of the node whose list begins at `start`.
    fn lane_bones(
        &self,
        skin: &Skin<'_>,
        own: &NodeBones<'_>,
        [start, lane]: [usize; 2],
        report: Report<'_>,
    ) -> ControlFlow<()> {
        // Those met with a weight, one bit each.
        let mut met = [0_u64; BONE_COUNT_MAX / 64];
        for (k, (entry, [middle, _])) in own.entries.iter().zip(own.weights).enumerate() {
            let bone = usize::from(entry[lane]);
            let at = size_of::<BoneEntry>() * (start + k) + size_of::<u16>() * lane;
            let place = self.at(SectionKind::BONE_LISTS, at);
            if bone >= skin.bones.len() {
                let rule = "SPEC 6.10: the bones of a node are bones of the file";
                report(
                    place
                        .rule(rule)
                        .broken(Datum::Below(skin.bones.len() as u64), bone),
                )?;
                continue;
            }
            let bit = 1 << (bone % 64);
            if middle[lane] != 0.0 && met[bone / 64] & bit != 0 {
                let rule = "SPEC 6.10: no bone has weights in two entries of a lane";
                report(place.rule(rule).broken("another bone", bone))?;
            }
            if middle[lane] != 0.0 {
                met[bone / 64] |= bit;
            }
        }
        ControlFlow::Continue(())
    }

    /// Where a number of a node's bone rows stands in the file; `list_start` is its entry in BLSS.
    pub(super) fn bone_row_place(
        &self,
        node: usize,
        list_start: usize,
        row: usize,
        lane: usize,
    ) -> crate::error::Check {
        let first = BONE_ROWS_FIXED * node + BONE_ROWS_PER_ENTRY * list_start;
        self.at(
            SectionKind::BONE_ROWS,
            (first + row) * size_of::<Row>() + size_of::<f32>() * lane,
        )
    }
}
