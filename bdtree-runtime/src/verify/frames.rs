//! The animation: times in order, rotations that are rotations, q that can be posed (SPEC 7.5).

use bdtree_format::{FrameRecord, SectionKind};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::Report;
use crate::error::{Datum, FormatError};
use crate::view::Asset;

/// Squared lengths of quaternions may differ from 1 by this.
const ROTATION_TOLERANCE: f64 = 1.0 / (1_u64 << 20) as f64;

/// Placements beyond this are refused.
const TRANSLATION_MAX: f64 = (1_u128 << 80) as f64;

/// The time of frames whose source does not say.
const UNKNOWN: f64 = -1.0;

impl Asset<'_> {
    pub(super) fn frame_numbers(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some(first) = self.frames.first() else {
            return ControlFlow::Continue(());
        };
        let known = first.time_s.get() != UNKNOWN;
        let mut before = if known { 0.0 } else { UNKNOWN };
        for (k, frame) in self.frames.iter().enumerate() {
            let at =
                self.section_offset(SectionKind::FRAMES) + (k * size_of::<FrameRecord>()) as u64;
            let mut rule = |ok, offset: usize, rule, expected, found| {
                if ok {
                    return ControlFlow::Continue(());
                }
                report(FormatError {
                    section: SectionKind::FRAMES,
                    byte: at + offset as u64,
                    rule,
                    expected: Datum::Real(expected),
                    found: Datum::Real(found),
                })
            };
            let time = frame.time_s.get();
            let in_order = time >= before && time.is_finite();
            rule(
                if known { in_order } else { time == UNKNOWN },
                offset_of!(FrameRecord, time_s),
                "SPEC 7.5: times are -1 in every frame, or finite, not negative and not descending",
                before,
                time,
            )?;
            // A time out of order is one broken rule, not one for every frame behind it.
            before = if in_order { time } else { before };
            let [x, y, z, w] = frame.rotation.map(|c| c.get());
            let square = x * x + y * y + z * z + w * w;
            rule(
                (square - 1.0).abs() <= ROTATION_TOLERANCE,
                offset_of!(FrameRecord, rotation),
                "SPEC 7.5: a rotation is a quaternion of squared length within 2^-20 of 1",
                1.0,
                square,
            )?;
            for (axis, t) in frame.translation.iter().enumerate() {
                rule(
                    t.get().abs() <= TRANSLATION_MAX,
                    offset_of!(FrameRecord, translation) + axis * size_of::<f64>(),
                    "SPEC 7.5: a translation is finite and at most 2^80",
                    TRANSLATION_MAX,
                    t.get(),
                )?;
            }
        }
        self.frame_coordinates(report)
    }

    /// Every q is a number that a pose takes.
    fn frame_coordinates(&self, report: Report<'_>) -> ControlFlow<()> {
        let m = self.modes.len();
        for (i, q) in self.frame_q.iter().enumerate() {
            let limit = self.modes[i % m].q_limit.get();
            let byte = self.section_offset(SectionKind::FRAME_Q) + 4 * i as u64;
            let mut broken = |rule, expected| {
                report(FormatError {
                    section: SectionKind::FRAME_Q,
                    byte,
                    rule,
                    expected,
                    found: Datum::Real(f64::from(*q)),
                })
            };
            if !(q.is_normal() || *q == 0.0) {
                broken(
                    "SPEC 5.1: numbers are finite and not subnormal",
                    Datum::Text("a normal number or zero"),
                )?;
            } else if !(q.abs() <= limit) {
                broken(
                    "SPEC 7.5: q of a frame is within q_limit",
                    Datum::Real(f64::from(limit)),
                )?;
            }
        }
        ControlFlow::Continue(())
    }
}
