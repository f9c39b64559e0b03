//! The frames of an asset's animation (SPEC 7.5): q, time, and the rigid motion of each.

use bdtree_format::{FrameRecord, TIME_UNKNOWN};

use crate::math::{clamp, sqrt};
use crate::transform::Transform;
use crate::view::Asset;

/// A pose that the source showed. It plays back as
/// `asset.pose(frame.q(), frame.transform(), …)`; an instance that is placed elsewhere takes
/// `place.after(frame.transform())?`.
#[derive(Debug, Clone, Copy)]
pub struct AnimationFrame<'a> {
    record: &'a FrameRecord,
    q: &'a [f32],
}

impl<'a> AnimationFrame<'a> {
    /// One number per mode, each within the mode's limit.
    pub fn q(&self) -> &'a [f32] {
        self.q
    }

    /// When the source shows the frame, in seconds from 0; `None` when it does not say.
    pub fn time_s(&self) -> Option<f64> {
        let time = self.record.time_s.get();
        (time != TIME_UNKNOWN).then_some(time)
    }

    /// The rigid motion that a writer took out of the frame and that puts the mesh back:
    /// `x = R (origin + p') + t` (mesh units). The identity where none was.
    pub fn transform(&self) -> Transform {
        Transform {
            rotation: self.record.rotation.map(|c| c.get()),
            translation: self.record.translation.map(|c| c.get()),
            scale: 1.0,
        }
    }
}

impl<'a> Asset<'a> {
    /// Number of frames of the animation; 0 when there is none.
    pub fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// A frame of the animation, counted from 0; `None` when there is no such frame. Its numbers
    /// are the file's: where nobody has verified them, [`Asset::pose`] still checks what it
    /// takes.
    pub fn frame(&self, index: usize) -> Option<AnimationFrame<'a>> {
        let m = self.mode_count();
        let start = index.checked_mul(m)?;
        Some(AnimationFrame {
            record: self.frames.get(index)?,
            q: self.frame_q.get(start..start.checked_add(m)?)?,
        })
    }

    /// How long the animation lasts, in seconds: the time of its last frame; `None` without frames or times.
    pub fn duration_s(&self) -> Option<f64> {
        self.frame(self.frame_count().checked_sub(1)?)?.time_s()
    }

    /// The pose of the animation at a time, between its frames by linear interpolation, before the first and
    /// after the last by theirs: puts one number per mode into `q`, returns the rigid motion that goes with it.
    /// A loop is `time % duration`.
    ///
    /// # Errors
    /// No animation, one whose frames have no times, a time that is not finite, `q` of another length than the asset
    /// has modes.
    pub fn sample(&self, time_s: f64, q: &mut [f32]) -> Result<Transform, SampleError> {
        if !time_s.is_finite() {
            return Err(SampleError::Time);
        }
        let time = |record: &FrameRecord| record.time_s.get();
        // A writer gives all of them a time or none.
        if self
            .frames
            .first()
            .is_some_and(|first| time(first) == TIME_UNKNOWN)
        {
            return Err(SampleError::NoTimes);
        }
        let after = self.frames.partition_point(|record| time(record) <= time_s);
        let after = after.min(self.frames.len().saturating_sub(1));
        let before = after.saturating_sub(usize::from(
            self.frames
                .get(after)
                .is_some_and(|record| time(record) > time_s),
        ));
        let time = |frame: usize| self.frames.get(frame).map_or(0.0, time);
        let span = time(after) - time(before);
        // Equal times, and those of damaged files that fall, stay at the first.
        let share = if span > 0.0 && span.is_finite() {
            clamp((time_s - time(before)) / span, 0.0, 1.0)
        } else {
            0.0
        };
        self.sample_between([before, after], share, q)
    }

    /// The pose of the animation between two of its frames, at 0 the first's and at 1 the second's, whatever
    /// their times: what [`Asset::sample`] returns between them.
    ///
    /// # Errors
    /// A frame that is not there, a share that is not finite, `q` of another length than the asset has modes.
    pub fn sample_between(
        &self,
        frames: [usize; 2],
        share: f64,
        q: &mut [f32],
    ) -> Result<Transform, SampleError> {
        let (found, expected) = (q.len(), self.mode_count());
        if found != expected {
            return Err(SampleError::ModeCount { expected, found });
        }
        if !share.is_finite() {
            return Err(SampleError::Share);
        }
        let count = self.frame_count();
        if count == 0 {
            return Err(SampleError::NoFrames);
        }
        let frame = |index: usize| {
            let found = self.frame(index);
            found.ok_or(SampleError::NoFrame { index, count })
        };
        let [a, b] = frames;
        let (a, b) = (frame(a)?, frame(b)?);
        for (q, (a, b)) in q.iter_mut().zip(a.q.iter().zip(b.q)) {
            // Exact where the two are equal, and never beyond them.
            *q = (f64::from(*a) + (f64::from(*b) - f64::from(*a)) * share) as f32;
        }
        Ok(a.transform().towards(&b.transform(), share))
    }
}

impl Transform {
    /// Between this placement, at a share of 0, and another, at 1: translation and scale linearly, rotations along
    /// the shorter way, their quaternions linearly and then normalised.
    fn towards(&self, other: &Self, share: f64) -> Self {
        let cosine: f64 = (self.rotation.iter().zip(&other.rotation))
            .map(|(a, b)| a * b)
            .sum();
        // q and −q are the same rotation.
        let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let rotation = [0, 1, 2, 3].map(|k| mix(self.rotation[k], sign * other.rotation[k]));
        let length = sqrt(rotation.iter().map(|x| x * x).sum());
        Self {
            rotation: rotation.map(|x| x / length),
            translation: [0, 1, 2].map(|k| mix(self.translation[k], other.translation[k])),
            scale: mix(self.scale, other.scale),
        }
    }
}

/// Why an animation has no pose at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleError {
    /// The asset has no animation.
    NoFrames,
    /// Its frames have no times: play them by [`Asset::frame`].
    NoTimes,
    /// The time is NaN or infinite.
    Time,
    /// The share is NaN or infinite.
    Share,
    /// No such frame.
    NoFrame {
        /// The frame asked for.
        index: usize,
        /// Frames of the animation.
        count: usize,
    },
    /// q has another length than the asset has modes.
    ModeCount {
        /// Modes of the asset.
        expected: usize,
        /// Length of q.
        found: usize,
    },
}

impl core::fmt::Display for SampleError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoFrames => f.write_str("the asset has no animation"),
            Self::NoTimes => f.write_str("the frames of the animation have no times"),
            Self::Time => f.write_str("the time is not a finite number"),
            Self::Share => f.write_str("the share is not a finite number"),
            Self::NoFrame { index, count } => {
                write!(f, "there is no frame {index}: the animation has {count}")
            }
            Self::ModeCount { expected, found } => {
                write!(
                    f,
                    "q has {found} entries but the asset has {expected} modes"
                )
            }
        }
    }
}

impl core::error::Error for SampleError {}
