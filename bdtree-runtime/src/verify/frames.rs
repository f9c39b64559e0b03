//! The animation: times in order, rotations that are rotations, q that can be posed (SPEC 7.5).

use bdtree_format::{FrameRecord, ROTATION_TOLERANCE, SectionKind, TIME_UNKNOWN, TRANSLATION_MAX};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::{FINITE, Report, is_stored};
use crate::error::Datum;
use crate::view::Asset;

impl Asset<'_> {
    pub(super) fn frame_numbers(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some(first) = self.frames.first() else {
            return ControlFlow::Continue(());
        };
        let known = first.time_s.get() != TIME_UNKNOWN;
        let mut before = if known { 0.0 } else { TIME_UNKNOWN };
        for (k, frame) in self.frames.iter().enumerate() {
            let start = k * size_of::<FrameRecord>();
            let at = |offset: usize| self.at(SectionKind::FRAMES, start + offset);
            let time = frame.time_s.get();
            let in_order = time >= before && time.is_finite();
            let ok = if known {
                in_order
            } else {
                time == TIME_UNKNOWN
            };
            at(offset_of!(FrameRecord, time_s))
                .rule("SPEC 7.5: times are -1 in every frame, or finite, not negative and not descending")
                .tell(
                    report,
                    ok,
                    if known { Datum::AtLeast(before) } else { Datum::Real(TIME_UNKNOWN) },
                    time,
                )?;
            // A time out of order is one broken rule, not one for every frame behind it.
            before = if in_order { time } else { before };
            let [x, y, z, w] = frame.rotation.map(|c| c.get());
            let square = x * x + y * y + z * z + w * w;
            let ok = (square - 1.0).abs() <= ROTATION_TOLERANCE;
            at(offset_of!(FrameRecord, rotation))
                .rule("SPEC 7.5: a rotation is a quaternion of squared length within 2^-20 of 1")
                .tell(report, ok, 1.0, square)?;
            for (axis, t) in frame.translation.map(|t| t.get()).into_iter().enumerate() {
                at(offset_of!(FrameRecord, translation) + axis * size_of::<f64>())
                    .rule("SPEC 7.5: a translation is finite and at most 2^80")
                    .tell(
                        report,
                        t.abs() <= TRANSLATION_MAX,
                        Datum::Within(-TRANSLATION_MAX, TRANSLATION_MAX),
                        t,
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
            let at = || self.at(SectionKind::FRAME_Q, size_of::<f32>() * i);
            if !is_stored(*q) {
                report(at().rule(FINITE).broken("a normal number or zero", *q))?;
            } else if !(q.abs() <= limit) {
                let rule = at().rule("SPEC 7.5: q of a frame is within q_limit");
                report(rule.broken(Datum::Within((-limit).into(), limit.into()), *q))?;
            }
        }
        ControlFlow::Continue(())
    }
}
