//! The animation as the file stores it (SPEC 7.5).

use bdtree_format::{FrameRecord, ROTATION_TOLERANCE, TIME_UNKNOWN, TRANSLATION_MAX};

use super::check::none_yet;
use super::round::round_nearest;
use crate::basis::{Basis, RigidMotion};
use crate::error::{BakeError, Part, Place};

/// Times, motions and q as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredFrames {
    /// One per frame.
    pub records: Vec<FrameRecord>,
    /// `q[t * M + j]` is q_j of frame t: f32, subnormals as 0.
    pub q: Vec<f32>,
}

/// A frame that takes a mode farthest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Farthest {
    /// Which, from 0.
    pub(super) frame: usize,
    /// |q_j| there, as stored.
    pub(super) q: f64,
}

impl StoredFrames {
    /// The first frame with the largest |q_j|, for each of `mode_count` modes that any frame
    /// moves.
    pub(super) fn farthest(&self, mode_count: usize) -> Vec<Option<Farthest>> {
        let mut farthest: Vec<Option<Farthest>> = vec![None; mode_count];
        for (frame, q) in self.q.chunks_exact(mode_count.max(1)).enumerate() {
            for (most, &q) in farthest.iter_mut().zip(q) {
                let q = f64::from(q.abs());
                if q > most.map_or(0.0, |m| m.q) {
                    *most = Some(Farthest { frame, q });
                }
            }
        }
        farthest
    }
}

/// The frames of a basis, if it has an animation.
///
/// # Errors
/// No frame, lists of other lengths than the frames need; and, each with its frame and mode, times
/// that are no numbers from 0 on or descend, quaternions that are not unit, translations beyond
/// 2⁸⁰, q that is not finite or that f32 cannot hold.
pub(super) fn store_frames(basis: &Basis) -> Result<Option<StoredFrames>, BakeError> {
    let Some(animation) = &basis.animation else {
        return Ok(None);
    };
    let (t, m) = (animation.frame_count, basis.mode_count());
    let mut problems = none_yet();
    let times = animation.times_s.as_deref();
    let (q, motions) = (animation.q.len(), animation.motions.len());
    let time_count = times.map_or(t, <[f64]>::len);
    for (ok, message) in [
        (t > 0, "it has no frames".to_string()),
        (
            t.checked_mul(m) == Some(q),
            format!("{q} numbers q for {t} frames of {m} modes"),
        ),
        (
            time_count == t,
            format!("{time_count} times for {t} frames"),
        ),
        (
            motions == 0 || motions == t,
            format!("{motions} rigid motions for {t} frames"),
        ),
    ] {
        if !ok {
            problems.add(|| (Part::The("animation"), message));
        }
    }
    problems.into_result(Place::NOWHERE)?;

    let mut problems = none_yet();
    let mut records = Vec::with_capacity(t);
    let mut before = 0.0;
    for k in 0..t {
        let motion = animation.motions.get(k).unwrap_or(&RigidMotion::IDENTITY);
        if let Some(message) = broken_motion(motion) {
            problems.add(|| (Part::Frame(k), message));
        }
        let time = times.map_or(TIME_UNKNOWN, |times| times[k]);
        if times.is_some() {
            let wrong = if !(time >= 0.0 && time.is_finite()) {
                Some(format!("time {time} s is not a number from 0 on"))
            } else if time < before {
                Some(format!(
                    "time {time} s lies before {before} s of an earlier frame"
                ))
            } else {
                before = time;
                None
            };
            if let Some(message) = wrong {
                problems.add(|| (Part::Frame(k), message));
            }
        }
        records.push(FrameRecord {
            time_s: time.into(),
            rotation: motion.rotation.map(Into::into),
            translation: motion.translation.map(Into::into),
        });
    }
    let mut stored = Vec::with_capacity(animation.q.len());
    for (i, &q) in animation.q.iter().enumerate() {
        let rounded = round_nearest(q);
        if !rounded.is_finite() {
            let reason = if q.is_finite() {
                "too large for f32"
            } else {
                "not finite"
            };
            problems.add(|| (place(i / m, i % m), format!("q {q:e} is {reason}")));
        }
        stored.push(rounded);
    }
    problems.into_result(Place::NOWHERE)?;
    Ok(Some(StoredFrames { records, q: stored }))
}

/// Where a q stands, for messages.
pub(super) fn place(frame: usize, mode: usize) -> Place {
    Place::from(Part::Frame(frame)).at(Part::Mode(mode))
}

/// Why a rigid motion cannot be played back.
fn broken_motion(motion: &RigidMotion) -> Option<String> {
    let [x, y, z, w] = motion.rotation;
    let square = x * x + y * y + z * z + w * w;
    if !((square - 1.0).abs() <= ROTATION_TOLERANCE) {
        return Some(format!(
            "rotation {:?} is not a unit quaternion: its length is {}",
            motion.rotation,
            square.sqrt()
        ));
    }
    if !motion
        .translation
        .iter()
        .all(|c| c.abs() <= TRANSLATION_MAX)
    {
        return Some(format!(
            "translation {:?} is not finite or beyond 2^80",
            motion.translation
        ));
    }
    None
}
