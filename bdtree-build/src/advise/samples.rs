//! The q at which an asset is judged, and where its bones are then.

use bdtree_runtime::{Asset, BoneMatrices, JointMatrix, SkeletonError};
use serde::Serialize;

pub use super::postures::Bones;
use super::postures::postures;
use crate::report::random::Random;

/// Samples unless told otherwise.
pub const SAMPLES: usize = 24;

/// A mode that moves no vertex farther than this share of the asset's largest position within its range is
/// still: f32 rounds off as much.
const STILL: f64 = 1.0 / (1 << 24) as f64;

/// Where the q of samples come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Frames of the asset's animation.
    Frames,
    /// Clips of the asset's skeleton.
    Clips,
    /// No animation that moves anything: mixtures of all modes, each anywhere within ±`q_range`, the same in every run.
    Ranges,
    /// No modes, or none that moves anything: all 0.
    Rest,
}

/// Reduced coordinates and bones that stand for what an asset does.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Where q come from.
    pub source: Source,
    /// Where bones come from; `None` without a skin.
    pub bones: Option<Bones>,
    /// Number of modes M.
    pub mode_count: usize,
    /// `q[s * M + j]` is q_j of sample s.
    q: Vec<f32>,
    frames: Vec<usize>,
    /// One matrix per joint, sample after sample.
    joints: Vec<JointMatrix>,
    /// Number of samples: at least 1.
    pub count: usize,
    /// Modes that move nothing: zero fields, and ranges so small that f32 rounds them off. What they would do
    /// beyond their ranges the samples do not show.
    pub still: Vec<usize>,
}

impl Samples {
    /// At most `most` (at least 1) samples of an asset: frames of its animation, evenly chosen with the first
    /// and the last among them; without one that moves anything mixtures within ±`q_range`; where no mode moves anything,
    /// the rest pose. Rigid motions of frames are left out: they change no answer.
    ///
    /// Of an asset with a skin exactly `most`: as many of each clip as of any other, in the middles of equal parts of its
    /// time; without clips, the rest pose and the joints turned by up to 20° about themselves. q is the clips' where
    /// they move a mode, else as above.
    ///
    /// Numbers of frames are the file's: where nobody has verified them, [`bdtree_runtime::Asset::pose`] still
    /// checks what it takes.
    ///
    /// # Errors
    /// A skeleton that breaks the format's rules.
    pub fn of(asset: &Asset<'_>, most: usize) -> Result<Self, SkeletonError> {
        let most = most.max(1);
        let mut samples = Self::of_modes(asset, most);
        let Some(skeleton) = asset.skeleton() else {
            return Ok(samples);
        };
        let found = postures(asset, &skeleton, most)?;
        let is_still = samples.still.len() == samples.mode_count;
        if found.q.iter().any(|q| *q != 0.0) {
            samples.source = Source::Clips;
            samples.q = found.q;
        } else if is_still {
            samples.q = found.q;
        }
        samples.count = most;
        samples.bones = Some(found.bones);
        samples.joints = found.joints;
        Ok(samples)
    }

    /// Without bones.
    fn of_modes(asset: &Asset<'_>, most: usize) -> Self {
        let mode_count = asset.mode_count();
        let still = still_modes(asset);
        let mut samples = Self {
            source: Source::Rest,
            bones: None,
            mode_count,
            q: vec![0.0; mode_count],
            frames: Vec::new(),
            joints: Vec::new(),
            count: 1,
            still,
        };
        if samples.still.len() == mode_count {
            return samples;
        }
        let frames = evenly(asset.frame_count(), most);
        let q: Vec<f32> = frames
            .iter()
            .filter_map(|&frame| asset.frame(frame))
            .flat_map(|frame| frame.q().iter().copied())
            .collect();
        // Frames that the file does not hold, contrary to what it says, are none; frames at rest (a clip that
        // moves a character's bones) say nothing of the modes.
        if q.iter().any(|q| *q != 0.0) && q.len() == frames.len() * mode_count {
            samples.source = Source::Frames;
            samples.count = frames.len();
            samples.frames = frames;
            samples.q = q;
            return samples;
        }
        let mut random = Random::new();
        let ranges: Vec<f32> = asset.modes().iter().map(|m| m.q_range.get()).collect();
        let mixtures = (0..most).flat_map(|_| ranges.iter());
        samples.source = Source::Ranges;
        samples.count = most;
        samples.q = mixtures
            .map(|range| (2.0 * random.unit() - 1.0) as f32 * range)
            .collect();
        samples
    }

    /// q of a sample: M numbers.
    ///
    /// # Panics
    /// When `sample` is not below [`Samples::count`].
    pub fn q(&self, sample: usize) -> &[f32] {
        &self.q[sample * self.mode_count..(sample + 1) * self.mode_count]
    }

    /// Where the bones of a sample are, as poses take them.
    ///
    /// # Panics
    /// When `sample` is not below [`Samples::count`].
    pub fn joints(&self, sample: usize) -> BoneMatrices<'_> {
        if self.bones.is_none() {
            return BoneMatrices::Rest;
        }
        let count = self.joints.len() / self.count;
        BoneMatrices::Joints(&self.joints[sample * count..(sample + 1) * count])
    }

    /// The frame of a sample, from 0, where it is one.
    pub fn frame(&self, sample: usize) -> Option<usize> {
        self.frames.get(sample).copied()
    }

    /// The same samples of an asset that has only the modes `modes` (each below M) of this one.
    ///
    /// # Panics
    /// When one of `modes` is not below [`Samples::mode_count`].
    pub fn select(&self, modes: &[usize]) -> Self {
        let rows = (0..self.count).map(|sample| self.q(sample));
        let place = |mode: &usize| modes.iter().position(|kept| kept == mode);
        Self {
            q: rows
                .flat_map(|q| modes.iter().map(move |&mode| q[mode]))
                .collect(),
            mode_count: modes.len(),
            still: self.still.iter().filter_map(place).collect(),
            frames: self.frames.clone(),
            joints: self.joints.clone(),
            ..*self
        }
    }
}

/// The modes that move no vertex by more than rounding at their range.
fn still_modes(asset: &Asset<'_>) -> Vec<usize> {
    let least = STILL * f64::from(asset.header().position_norm_max.get());
    let moves = |mode: &bdtree_format::ModeRecord| {
        f64::from(mode.q_range.get()) * f64::from(mode.field_norm_max.get())
    };
    let modes = asset.modes().iter().enumerate();
    modes
        .filter(|(_, mode)| !(moves(mode) > least))
        .map(|(j, _)| j)
        .collect()
}

/// At most `most` of `0..count`, evenly apart, the first and the last among them.
pub(super) fn evenly(count: usize, most: usize) -> Vec<usize> {
    let chosen = most.min(count);
    let gaps = chosen.saturating_sub(1).max(1);
    let place = |i: usize| {
        // In u128, since a file may say any number of frames.
        (i as u128 * count.saturating_sub(1) as u128 / gaps as u128) as usize
    };
    (0..chosen).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_even_and_hold_both_ends() {
        assert!(evenly(0, 24).is_empty());
        assert_eq!(evenly(1, 24), [0]);
        assert_eq!(evenly(5, 24), [0, 1, 2, 3, 4]);
        assert_eq!(evenly(9, 5), [0, 2, 4, 6, 8]);
        assert_eq!(evenly(100, 1), [0]);
        let many = evenly(1000, 24);
        assert_eq!((many.len(), many[0], many[23]), (24, 0, 999));
        assert!(
            many.windows(2)
                .all(|pair| (43..=44).contains(&(pair[1] - pair[0])))
        );
    }
}
