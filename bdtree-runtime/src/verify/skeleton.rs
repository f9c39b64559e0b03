//! The skeleton and its clips: parents before children, names, keys in order (SPEC 7.8, 7.9).

use bdtree_format::{
    ChannelRecord, ClipRecord, NO_PARENT, SKELETON_NODES_MAX, SectionKind, SkeletonNode,
    channel_path, local_kind,
};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::{FINITE, Report, is_stored};
use crate::error::Datum;
use crate::math::sqrt;
use crate::skeleton::Track;
use crate::view::{Asset, Skin};

pub(crate) const PARENTS: &str = "SPEC 7.8: the parent of a node stands before it";
pub(crate) const KINDS: &str = "SPEC 7.8: a local transform is parts (0) or a matrix (1)";
pub(crate) const JOINTS: &str = "SPEC 7.8: a joint is a node of the skeleton";
pub(crate) const CHANNELS: &str = "SPEC 7.9: the channels of a clip lie inside CHAN";
pub(crate) const KEYS: &str =
    "SPEC 7.9: path and interpolation are known, keys are one at least and lie inside KEYS";
pub(crate) const TARGETS: &str =
    "SPEC 7.9: a channel animates one node of parts, or modes of the file";

/// How far the length of a stored rotation may be from 1: 2⁻¹⁰.
const LENGTH_TOLERANCE: f64 = 1.0 / 1024.0;

impl Asset<'_> {
    /// Nothing that a bound rests on.
    pub(super) fn skeleton_and_clips(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some(skin) = &self.skin else {
            return ControlFlow::Continue(());
        };
        self.skeleton_nodes(skin, report)?;
        self.joint_nodes(skin, report)?;
        self.clip_records(skin, report)?;
        self.channel_records(skin, report)
    }

    fn skeleton_nodes(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        for (i, node) in skin.skeleton.iter().enumerate() {
            let start = i * size_of::<SkeletonNode>();
            let at = |offset| self.at(SectionKind::SKELETON, start + offset);
            let SkeletonNode {
                parent,
                name_start,
                name_bytes,
                kind,
                local,
            } = *node;
            at(offset_of!(SkeletonNode, parent)).rule(PARENTS).tell(
                report,
                parent == NO_PARENT || (parent as usize) < i,
                Datum::Below(i as u64),
                parent,
            )?;
            self.name(
                skin,
                at(offset_of!(SkeletonNode, name_start)),
                [name_start, name_bytes],
                report,
            )?;
            let known = matches!(kind, local_kind::PARTS | local_kind::MATRIX);
            at(offset_of!(SkeletonNode, kind)).rule(KINDS).tell(
                report,
                known,
                local_kind::MATRIX,
                kind,
            )?;
            let numbers = offset_of!(SkeletonNode, local);
            if let Some(k) = local.iter().position(|x| !is_stored(*x)) {
                let place = at(numbers + size_of::<f32>() * k).rule(FINITE);
                report(place.broken("a normal number or zero", local[k]))?;
            } else if kind == local_kind::PARTS {
                let [_, _, _, x, y, z, w, .., a, b] = local.map(f64::from);
                let length = sqrt(x * x + y * y + z * z + w * w);
                at(numbers + 3 * size_of::<f32>())
                    .rule("SPEC 7.8: a rotation is a quaternion of length within 2^-10 of 1")
                    .tell(
                        report,
                        (length - 1.0).abs() <= LENGTH_TOLERANCE,
                        1.0,
                        length,
                    )?;
                at(numbers + 10 * size_of::<f32>())
                    .rule("SPEC 7.8: parts end with two zeros")
                    .tell(
                        report,
                        a == 0.0 && b == 0.0,
                        0.0,
                        if a == 0.0 { b } else { a },
                    )?;
            }
        }
        ControlFlow::Continue(())
    }

    fn name(
        &self,
        skin: &Skin<'_>,
        at: crate::error::Check,
        [start, bytes]: [u32; 2],
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let end = u64::from(start) + u64::from(bytes);
        let name =
            (skin.names).get(start as usize..(start as usize).saturating_add(bytes as usize));
        let named = name.is_some_and(|name| core::str::from_utf8(name).is_ok());
        at.rule("SPEC 7.8: names lie inside SNAM and are UTF-8")
            .tell(
                report,
                named,
                if name.is_none() {
                    Datum::at_most(skin.names.len())
                } else {
                    "UTF-8".into()
                },
                end,
            )
    }

    fn joint_nodes(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        // One bit per node.
        let mut seen = [0_u64; SKELETON_NODES_MAX / 64];
        for (j, node) in skin.joints.iter().enumerate() {
            let at = self.at(SectionKind::JOINTS, size_of::<u32>() * j);
            let (i, count) = (*node as usize, skin.skeleton.len());
            if i >= count {
                report(at.rule(JOINTS).broken(Datum::Below(count as u64), *node))?;
                continue;
            }
            let (word, bit) = (&mut seen[i / 64], 1_u64 << (i % 64));
            at.rule("SPEC 7.8: no node is a joint twice").tell(
                report,
                *word & bit == 0,
                "another node",
                *node,
            )?;
            *word |= bit;
        }
        ControlFlow::Continue(())
    }

    fn clip_records(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        for (i, clip) in skin.clips.iter().enumerate() {
            let at = |offset| self.at(SectionKind::CLIPS, i * size_of::<ClipRecord>() + offset);
            let name = [clip.name_start.get(), clip.name_bytes.get()];
            self.name(skin, at(offset_of!(ClipRecord, name_start)), name, report)?;
            let first = clip.first_channel.get() as usize;
            let end = first.saturating_add(clip.channel_count.get() as usize);
            let Some(channels) = skin.channels.get(first..end) else {
                let place = at(offset_of!(ClipRecord, first_channel)).rule(CHANNELS);
                report(place.broken(Datum::at_most(skin.channels.len()), end))?;
                continue;
            };
            let tracks = channels.iter().filter_map(|c| Track::new(c, skin.keys));
            let last = tracks.flat_map(|track| track.times().iter().copied());
            let last = f64::from(last.fold(0.0, f32::max));
            let found = clip.duration_s.get();
            at(offset_of!(ClipRecord, duration_s))
                .rule("SPEC 7.9: duration_s is the largest time of the clip's keys")
                .tell(report, found == last, last, found)?;
        }
        ControlFlow::Continue(())
    }

    fn channel_records(&self, skin: &Skin<'_>, report: Report<'_>) -> ControlFlow<()> {
        if let Some(i) = skin.keys.iter().position(|x| !is_stored(*x)) {
            let place = self
                .at(SectionKind::KEYS, size_of::<f32>() * i)
                .rule(FINITE);
            report(place.broken("a normal number or zero", skin.keys[i]))?;
        }
        for (i, channel) in skin.channels.iter().enumerate() {
            let at = |offset| {
                self.at(
                    SectionKind::CHANNELS,
                    i * size_of::<ChannelRecord>() + offset,
                )
            };
            at(offset_of!(ChannelRecord, reserved))
                .rule("SPEC 7.9: reserved numbers are zero")
                .tell(report, channel.reserved == 0, 0_u32, channel.reserved)?;
            self.channel_target(skin, i, channel, report)?;
            let Some(track) = Track::new(channel, skin.keys) else {
                let place = at(offset_of!(ChannelRecord, path)).rule(KEYS);
                report(place.broken("keys inside KEYS", "others"))?;
                continue;
            };
            let mut before = -1.0;
            for (k, time) in track.times().iter().enumerate() {
                let ok = *time > before && *time >= 0.0;
                let number = channel.first_number as usize + k;
                self.at(SectionKind::KEYS, size_of::<f32>() * number)
                    .rule("SPEC 7.9: times of keys are not negative and ascend strictly")
                    .tell(
                        report,
                        ok,
                        if k == 0 {
                            Datum::AtLeast(0.0)
                        } else {
                            "a later time than the one before".into()
                        },
                        *time,
                    )?;
                // A time out of order is one broken rule, not one for every key behind it.
                before = if ok { *time } else { before };
            }
        }
        ControlFlow::Continue(())
    }

    fn channel_target(
        &self,
        skin: &Skin<'_>,
        i: usize,
        channel: &ChannelRecord,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let (first, count) = (channel.target as usize, channel.target_count as usize);
        let start = i * size_of::<ChannelRecord>();
        let at = |field| self.at(SectionKind::CHANNELS, start + field).rule(TARGETS);
        if channel.path == channel_path::MODES {
            let all = self.modes.len();
            return match all.checked_sub(count) {
                Some(_) if count == 0 => {
                    let at = at(offset_of!(ChannelRecord, target_count));
                    at.tell(report, false, "at least 1 mode", count)
                }
                Some(last) => at(offset_of!(ChannelRecord, target)).tell(
                    report,
                    first <= last,
                    Datum::at_most(last),
                    first,
                ),
                None => at(offset_of!(ChannelRecord, target_count)).tell(
                    report,
                    false,
                    Datum::at_most(all),
                    count,
                ),
            };
        }
        let node = skin.skeleton.get(first);
        let is_parts = node.is_some_and(|node| node.kind == local_kind::PARTS);
        let known = is_parts && count == 1;
        let expected = "one node of parts";
        at(offset_of!(ChannelRecord, target)).tell(report, known, expected, first)
    }
}
