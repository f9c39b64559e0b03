//! Clips as stored.

use bdtree_format::{ChannelRecord, ClipRecord, channel_path, interpolation};

use super::names::Names;
use crate::error::{BakeError, Place};
use crate::input::{Animated, KeyInterpolation, Local, RawChannel, RawSkin};
use crate::wrap::StoredShape;

/// The sections of clips.
#[derive(Debug, Default)]
pub(super) struct Clips {
    pub(super) records: Vec<ClipRecord>,
    pub(super) channels: Vec<ChannelRecord>,
    pub(super) keys: Vec<f32>,
}

/// Channels that move what is there, with as many numbers as they need.
pub(super) fn check(skin: &RawSkin, mode_count: usize) -> Result<(), String> {
    for clip in &skin.clips {
        for (i, channel) in clip.channels.iter().enumerate() {
            if let Some(message) = wrong(skin, channel, mode_count) {
                return Err(format!("clip {:?}, channel {i}: {message}", clip.name));
            }
        }
    }
    Ok(())
}

/// What is wrong with a channel.
fn wrong(skin: &RawSkin, channel: &RawChannel, mode_count: usize) -> Option<String> {
    match channel.animated {
        Animated::Translation(node) | Animated::Rotation(node) | Animated::Scale(node) => {
            match skin.skeleton.get(node as usize).map(|node| node.local) {
                None => return Some(format!("there is no node {node}")),
                Some(Local::Matrix(_)) => {
                    return Some(format!("node {node} has a matrix, which nothing animates"));
                }
                Some(Local::Parts { .. }) => {}
            }
        }
        Animated::Fields { first, count } => {
            let end = first as usize + count as usize;
            if count == 0 || end > mode_count {
                return Some(format!("it moves modes {first} to {end} of {mode_count}"));
            }
        }
    }
    let times = &channel.times_s;
    let is_stored = |x: &f32| x.is_normal() || *x == 0.0;
    if times.is_empty()
        || !times.iter().all(|t| is_stored(t) && *t >= 0.0)
        || !times.windows(2).all(|pair| pair[0] < pair[1])
    {
        return Some("times are not numbers of at least 0 that ascend".to_string());
    }
    let need = channel.animated.width() * channel.interpolation.values_per_key() * times.len();
    if channel.values.len() != need || !channel.values.iter().all(is_stored) {
        let found = channel.values.len();
        return Some(format!("{found} values, not {need} finite ones"));
    }
    None
}

/// The clips of a skin that [`check`] passed.
///
/// # Errors
/// More numbers than 32 bits count.
pub(super) fn store(
    skin: &RawSkin,
    shape: &StoredShape,
    names: &mut Names,
    warnings: &mut Vec<String>,
) -> Result<Clips, BakeError> {
    let mut out = Clips::default();
    for clip in &skin.clips {
        let [name_start, name_bytes] = names.add(&clip.name)?;
        let first_channel = out.channels.len() as u32;
        let mut duration = 0.0_f32;
        for channel in &clip.channels {
            duration = channel.times_s.iter().copied().fold(duration, f32::max);
            out.add(channel)?;
            if let Some(mode) = beyond_limit(channel, shape) {
                let limit = shape.limits[mode].q_limit;
                warnings.push(format!(
                    "clip {:?}: takes mode {mode} beyond its limit {limit}: it is not shown there",
                    clip.name
                ));
            }
        }
        out.records.push(ClipRecord {
            duration_s: f64::from(duration).into(),
            name_start: name_start.into(),
            name_bytes: name_bytes.into(),
            first_channel: first_channel.into(),
            channel_count: (out.channels.len() as u32 - first_channel).into(),
        });
    }
    Ok(out)
}

impl Clips {
    fn add(&mut self, channel: &RawChannel) -> Result<(), BakeError> {
        let (path, target, target_count) = match channel.animated {
            Animated::Translation(node) => (channel_path::TRANSLATION, node, 1),
            Animated::Rotation(node) => (channel_path::ROTATION, node, 1),
            Animated::Scale(node) => (channel_path::SCALE, node, 1),
            Animated::Fields { first, count } => (channel_path::MODES, first, count),
        };
        let Ok(first_number) = u32::try_from(self.keys.len()) else {
            let message = "more than 2^32 times and values of all clips";
            return Err(BakeError::one("skin", Place::NOWHERE, message));
        };
        self.keys.extend_from_slice(&channel.times_s);
        self.keys.extend_from_slice(&channel.values);
        self.channels.push(ChannelRecord {
            target,
            target_count,
            path,
            interpolation: match channel.interpolation {
                KeyInterpolation::Linear => interpolation::LINEAR,
                KeyInterpolation::Step => interpolation::STEP,
                KeyInterpolation::Cubic => interpolation::CUBIC,
            },
            key_count: channel.times_s.len() as u32,
            first_number,
            reserved: 0,
        });
        Ok(())
    }
}

/// The first mode that a key takes beyond its limit.
fn beyond_limit(channel: &RawChannel, shape: &StoredShape) -> Option<usize> {
    let Animated::Fields { first, count } = channel.animated else {
        return None;
    };
    let per_key = channel.interpolation.values_per_key();
    let values = channel.values.chunks_exact(count as usize);
    let mut keys = values.skip(per_key / 2).step_by(per_key);
    keys.find_map(|key| {
        let limits = &shape.limits[first as usize..];
        let beyond = key
            .iter()
            .zip(limits)
            .position(|(q, limit)| q.abs() > limit.q_limit)?;
        Some(first as usize + beyond)
    })
}
