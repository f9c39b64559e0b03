//! The animations of a file with a skin: the channels that move its skeleton and its morph targets, key by key.

use std::collections::{HashMap, HashSet};

use gltf::json::Animation;
use gltf::json::animation::{Channel, Interpolation, Property};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Purpose};
use super::model::MorphNode;
use super::notes::Notes;
use super::plan::ELEMENTS_MAX;
use super::samplers;
use super::skeleton::Rig;
use crate::input::{Animated, KeyInterpolation, Local, RawChannel, RawSkinClip, RawTarget};

/// A channel that is read.
struct Wanted<'a> {
    /// Its place in its animation.
    index: usize,
    channel: &'a Channel,
    animated: Animated,
}

/// The animations that move nodes of the skeleton or weights of `nodes`.
pub(super) fn read(
    animations: &[Animation],
    accessors: &Accessors<'_>,
    rig: &Rig,
    nodes: &[MorphNode],
    notes: &mut Notes,
) -> Vec<RawSkinClip> {
    let morphing: HashMap<Option<usize>, MorphNode> = nodes.iter().map(|n| (n.node, *n)).collect();
    let mut stray = 0;
    let mut wanted = Vec::with_capacity(animations.len());
    for (index, animation) in animations.iter().enumerate() {
        wanted.push(channels(
            animation, index, rig, &morphing, &mut stray, notes,
        ));
    }
    if stray > 0 {
        let message =
            format!("ignored {stray} channels that move nothing that carries or shapes a mesh");
        notes.warn("animations", message);
    }
    if !notes.is_clean() || !is_small(animations, &wanted, accessors, notes) {
        return Vec::new();
    }
    let mut clips = Vec::new();
    for (index, (animation, wanted)) in animations.iter().zip(wanted).enumerate() {
        if wanted.is_empty() {
            continue;
        }
        let mut channels = Vec::with_capacity(wanted.len());
        // Samplers that several channels share are told of once.
        let mut told = HashSet::new();
        for wanted in wanted {
            let is_first = told.insert(wanted.channel.sampler.value());
            channels.extend(channel(
                (index, animation),
                &wanted,
                is_first,
                accessors,
                notes,
            ));
        }
        let name = animation.name.clone();
        clips.push(RawSkinClip {
            name: name.unwrap_or_else(|| format!("animation {index}")),
            channels,
        });
    }
    clips
}

/// Gives each clip a key that holds the default weights of those nodes whose weights it does not move: players of the
/// file start from weights of 0.
pub(super) fn hold_defaults(clips: &mut [RawSkinClip], nodes: &[MorphNode], targets: &[RawTarget]) {
    for node in nodes {
        let own = targets.get(node.first..node.first + node.count);
        let defaults = own.unwrap_or_default().iter().map(|t| t.default_weight);
        // Too large for f32: refused where keys are stored. Too small: files have no subnormal numbers.
        let values: Vec<f32> = defaults
            .map(|weight| weight as f32)
            .map(|weight| if weight.is_subnormal() { 0.0 } else { weight })
            .collect();
        if values.iter().all(|weight| *weight == 0.0) {
            continue;
        }
        // No loss: at most 2¹⁶ targets are read.
        let animated = Animated::Fields {
            first: node.first as u32,
            count: node.count as u32,
        };
        for clip in &mut *clips {
            if clip.channels.iter().all(|c| c.animated != animated) {
                clip.channels.push(RawChannel {
                    animated,
                    interpolation: KeyInterpolation::Step,
                    times_s: vec![0.0],
                    values: values.clone(),
                });
            }
        }
    }
}

/// The channels of one animation that are read; `stray` counts the others.
fn channels<'a>(
    animation: &'a Animation,
    index: usize,
    rig: &Rig,
    morphing: &HashMap<Option<usize>, MorphNode>,
    stray: &mut usize,
    notes: &mut Notes,
) -> Vec<Wanted<'a>> {
    let mut wanted = Vec::new();
    let mut moved = HashSet::new();
    for (i, channel) in animation.channels.iter().enumerate() {
        let at = format!("animations[{index}].channels[{i}]");
        let node = channel.target.node.value();
        let place = rig.place.get(&node).copied();
        let Checked::Valid(path) = channel.target.path else {
            *stray += 1;
            continue;
        };
        let animated = match (path, place) {
            (Property::MorphTargetWeights, _) => {
                let own = morphing.get(&Some(node));
                own.map(|own| Animated::Fields {
                    // No loss: at most 2¹⁶ targets are read.
                    first: own.first as u32,
                    count: own.count as u32,
                })
            }
            (Property::Translation, Some(place)) => Some(Animated::Translation(place)),
            (Property::Rotation, Some(place)) => Some(Animated::Rotation(place)),
            (Property::Scale, Some(place)) => Some(Animated::Scale(place)),
            _ => None,
        };
        let Some(animated) = animated else {
            *stray += 1;
            continue;
        };
        if !matches!(animated, Animated::Fields { .. }) {
            let own = place.and_then(|place| rig.skeleton.get(place as usize));
            if own.is_some_and(|own| matches!(own.local, Local::Matrix(_))) {
                let message =
                    format!("ignored: nodes[{node}] has a matrix, which nothing animates");
                notes.warn(at, message);
                continue;
            }
        }
        if moved.insert((node, path as u32)) {
            wanted.push(Wanted {
                index: i,
                channel,
                animated,
            });
        } else {
            notes.problem(at, "moves what another channel of the animation moves");
        }
    }
    wanted
}

/// True if the keys of all channels are not too many; otherwise that is noted. Many channels can name the same bytes.
fn is_small(
    animations: &[Animation],
    wanted: &[Vec<Wanted<'_>>],
    accessors: &Accessors<'_>,
    notes: &mut Notes,
) -> bool {
    let mut count = 0_u64;
    for (animation, wanted) in animations.iter().zip(wanted) {
        for wanted in wanted {
            let Some(sampler) = animation.samplers.get(wanted.channel.sampler.value()) else {
                continue;
            };
            let width = match wanted.animated {
                Animated::Fields { .. } => 1,
                other => other.width() as u64,
            };
            for (accessor, width) in [(sampler.input.value(), 1), (sampler.output.value(), width)] {
                let elements = accessors.list.get(accessor).map_or(0, |a| a.count.0);
                count = count.saturating_add(elements.saturating_mul(width));
            }
        }
    }
    if count > ELEMENTS_MAX {
        let message =
            format!("{count} times and values of all channels; at most {ELEMENTS_MAX} are read");
        notes.problem("animations", message);
    }
    count <= ELEMENTS_MAX
}

/// The keys of a channel.
fn channel(
    (index, animation): (usize, &Animation),
    wanted: &Wanted<'_>,
    is_first: bool,
    accessors: &Accessors<'_>,
    notes: &mut Notes,
) -> Option<RawChannel> {
    let number = wanted.channel.sampler.value();
    let place = format!("animations[{index}].samplers[{number}]");
    let Some(sampler) = animation.samplers.get(number) else {
        let at = format!("animations[{index}].channels[{}].sampler", wanted.index);
        return notes.refuse(at, format!("there is no {place}"));
    };
    let interpolation = match sampler.interpolation {
        Checked::Valid(Interpolation::Linear) => KeyInterpolation::Linear,
        Checked::Valid(Interpolation::Step) => KeyInterpolation::Step,
        Checked::Valid(Interpolation::CubicSpline) => KeyInterpolation::Cubic,
        Checked::Invalid => {
            return notes.refuse(place, "interpolation is none of LINEAR, STEP, CUBICSPLINE");
        }
    };
    let (input, output) = (format!("{place}.input"), format!("{place}.output"));
    let times = samplers::times(sampler.input.value(), accessors, &input, is_first, notes)?;
    let accessor = sampler.output.value();
    let (values, width) = match wanted.animated {
        Animated::Fields { count, .. } => {
            let values = accessors.read(accessor, Purpose::Weights, &output, notes)?;
            (values.all::<1>().into_flattened(), count as usize)
        }
        Animated::Rotation(_) => {
            let values = accessors.read(accessor, Purpose::Rotations, &output, notes)?;
            (values.all::<4>().into_flattened(), 4)
        }
        Animated::Translation(_) | Animated::Scale(_) => {
            let values = accessors.read(accessor, Purpose::Vectors, &output, notes)?;
            (values.all::<3>().into_flattened(), 3)
        }
    };
    let per_key = width * interpolation.values_per_key();
    if times.len().checked_mul(per_key) != Some(values.len()) {
        let message = format!(
            "{} numbers for {} keys of {per_key}",
            values.len(),
            times.len()
        );
        return notes.refuse(output, message);
    }
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        return notes.refuse(output, format!("number {i} is {}", values[i]));
    }
    // No loss: f32, or shares of integers that f32 holds to half a unit. Subnormals are no stored numbers.
    let values: Vec<f32> = values
        .iter()
        .map(|&x| crate::wrap::round::round_nearest(x))
        .collect();
    if let Animated::Rotation(_) = wanted.animated {
        let middle = interpolation.values_per_key() / 2;
        let mut keys = values
            .chunks_exact(per_key)
            .map(|key| &key[4 * middle..4 * middle + 4]);
        if let Some(key) = keys.position(|q| q.iter().all(|&x| x == 0.0)) {
            return notes.refuse(output, format!("the rotation of key {key} is zero"));
        }
    }
    let (times_s, values) = ascending(&times, values, per_key);
    Some(RawChannel {
        animated: wanted.animated,
        interpolation,
        times_s,
        values,
    })
}

/// Keys with times that ascend strictly. Of several keys at one time, a jump, the last keeps it, the first moves to the
/// number below, and those between them, which never show, go.
fn ascending(times: &[f64], values: Vec<f32>, per_key: usize) -> (Vec<f32>, Vec<f32>) {
    // No loss: the file's times are f32.
    let times: Vec<f32> = times
        .iter()
        .map(|&t| crate::wrap::round::round_nearest(t))
        .collect();
    if times.windows(2).all(|pair| pair[0] < pair[1]) {
        return (times, values);
    }
    let mut out = (Vec::new(), Vec::new());
    let mut start = 0;
    for run in times.chunk_by(|a, b| a == b) {
        let time = run[0];
        let mut keep = |key: usize, time: f32| {
            out.0.push(time);
            out.1
                .extend_from_slice(&values[key * per_key..(key + 1) * per_key]);
        };
        let before = time.next_down();
        if run.len() > 1 && before >= f32::MIN_POSITIVE && (start == 0 || times[start - 1] < before)
        {
            keep(start, before);
        }
        start += run.len();
        keep(start - 1, time);
    }
    out
}
