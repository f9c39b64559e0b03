//! The animation that moves weights, as frames between which weights are linear.

use std::collections::{HashMap, HashSet};

use gltf::json::Animation;
use gltf::json::animation::{Channel, Property};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Purpose};
use super::curve::{Curve, Side};
use super::model::MorphNode;
use super::notes::Notes;
use super::plan::ELEMENTS_MAX;
use crate::input::RawClip;

/// An animation with the channels that move weights of nodes that are read.
struct Candidate<'a> {
    index: usize,
    name: String,
    animation: &'a Animation,
    channels: Vec<(usize, &'a Channel, MorphNode)>,
}

/// The animation called `wanted`, else the first that moves weights of `nodes`; `None` if there is
/// none. `defaults` are the weights of targets that it leaves alone.
pub(super) fn read(
    animations: &[Animation],
    accessors: &Accessors<'_>,
    nodes: &[MorphNode],
    defaults: &[f64],
    wanted: Option<&str>,
    notes: &mut Notes,
) -> Option<RawClip> {
    let candidates = candidates(animations, nodes, notes);
    let shown = |list: &[&Candidate<'_>]| {
        let names: Vec<String> = list.iter().map(|c| format!("{:?}", c.name)).collect();
        names.join(", ")
    };
    let chosen = match wanted {
        None => candidates.first()?,
        Some(wanted) => match candidates.iter().find(|c| c.name == wanted) {
            Some(chosen) => chosen,
            None => {
                let all: Vec<&Candidate<'_>> = candidates.iter().collect();
                let others = match all.as_slice() {
                    [] => "none does".to_string(),
                    _ => format!("these do: {}", shown(&all)),
                };
                let message = format!("no animation called {wanted:?} moves weights; {others}");
                notes.problem("animations", message);
                return None;
            }
        },
    };
    let others: Vec<&Candidate<'_>> = candidates
        .iter()
        .filter(|c| c.index != chosen.index)
        .collect();
    if !others.is_empty() {
        let message = format!(
            "of the animations that move weights {:?} is read, not {}",
            chosen.name,
            shown(&others)
        );
        notes.warn("animations", message);
    }
    let mut curves: Vec<(MorphNode, Curve)> = Vec::new();
    let mut moved = HashSet::new();
    for &(i, channel, node) in &chosen.channels {
        let at = format!("animations[{}].channels[{i}]", chosen.index);
        if !moved.insert(node.first) {
            notes.problem(at, "moves the weights of a node that another channel moves");
        } else if let Some(curve) = curve(chosen, channel, node.count, accessors, notes) {
            curves.push((node, curve));
        }
    }
    if !notes.is_clean() {
        return None;
    }
    let (times_s, weights) = frames(chosen, &curves, defaults, notes)?;
    Some(RawClip {
        name: chosen.name.clone(),
        times_s,
        weights,
    })
}

/// The animations that move weights; what else animations do is noted.
fn candidates<'a>(
    animations: &'a [Animation],
    nodes: &[MorphNode],
    notes: &mut Notes,
) -> Vec<Candidate<'a>> {
    let (mut moving, mut moved, mut stray) = (0, 0, 0);
    let mut candidates = Vec::new();
    let known: HashMap<Option<usize>, MorphNode> = nodes.iter().map(|n| (n.node, *n)).collect();
    for (index, animation) in animations.iter().enumerate() {
        let mut channels = Vec::new();
        let before = moved;
        for (i, channel) in animation.channels.iter().enumerate() {
            let node = channel.target.node.value();
            match channel.target.path {
                Checked::Valid(Property::MorphTargetWeights) => match known.get(&Some(node)) {
                    Some(&own) => channels.push((i, channel, own)),
                    None => stray += 1,
                },
                _ => moved += 1,
            }
        }
        moving += usize::from(moved > before);
        if !channels.is_empty() {
            let name = animation.name.clone();
            candidates.push(Candidate {
                index,
                name: name.unwrap_or_else(|| format!("animation {index}")),
                animation,
                channels,
            });
        }
    }
    if moved > 0 {
        let message =
            format!("ignored {moved} channels of {moving} animations that move nodes, not weights");
        notes.warn("animations", message);
    }
    if stray > 0 {
        let message =
            format!("ignored {stray} channels for weights of nodes without morph targets");
        notes.warn("animations", message);
    }
    candidates
}

/// The curve of one channel for `width` weights.
fn curve(
    of: &Candidate<'_>,
    channel: &Channel,
    width: usize,
    accessors: &Accessors<'_>,
    notes: &mut Notes,
) -> Option<Curve> {
    let sampler = channel.sampler.value();
    let place = format!("animations[{}].samplers[{sampler}]", of.index);
    let Some(sampler) = of.animation.samplers.get(sampler) else {
        notes.problem(place, "there is no such element");
        return None;
    };
    let Checked::Valid(interpolation) = sampler.interpolation else {
        notes.problem(place, "interpolation is none of LINEAR, STEP, CUBICSPLINE");
        return None;
    };
    let (input, output) = (format!("{place}.input"), format!("{place}.output"));
    let times = accessors.read(sampler.input.value(), Purpose::Times, &input, notes);
    let values = accessors.read(sampler.output.value(), Purpose::Weights, &output, notes);
    let (times, values) = times.zip(values)?;
    let keys = times.count;
    if keys == 0 {
        notes.problem(input, "has no keys");
        return None;
    }
    if Curve::value_count(interpolation, keys, width) != Some(values.count) {
        let kind = match interpolation {
            gltf::json::animation::Interpolation::CubicSpline => " of 3 values",
            _ => "",
        };
        let message = format!(
            "{} values for {keys} keys{kind} of {width} morph targets",
            values.count
        );
        notes.problem(output, message);
        return None;
    }
    let times = times.all::<1>().into_flattened();
    let mut equal = 0;
    for (i, &t) in times.iter().enumerate() {
        let before = if i == 0 { 0.0 } else { times[i - 1] };
        if !(t.is_finite() && t >= before) {
            let message = format!("key {i} at {t} s: times are numbers of at least 0 that ascend");
            notes.problem(&input, message);
        } else if i > 0 && t == before {
            equal += 1;
        }
    }
    if equal > 0 {
        notes.warn(
            input,
            format!("{equal} keys have the time of the key before them: jumps"),
        );
    }
    let values = values.all::<1>().into_flattened();
    for (i, w) in values.iter().enumerate() {
        if !w.is_finite() {
            notes.problem(&output, format!("value {i} is {w}"));
        }
    }
    Some(Curve {
        interpolation,
        times,
        width,
        values,
    })
}

/// Times, and the weights of all targets at each. A time at which a curve jumps comes twice: with
/// the weights before and after.
fn frames(
    of: &Candidate<'_>,
    curves: &[(MorphNode, Curve)],
    defaults: &[f64],
    notes: &mut Notes,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let at = format!("animations[{}]", of.index);
    let mut keys = Vec::new();
    let mut off = 0.0_f64;
    for (_, curve) in curves {
        off = off.max(curve.add_times(&mut keys));
    }
    if off > 0.0 {
        notes.warn(
            &at,
            format!("bends so fast that weights between frames are off by up to {off}"),
        );
    }
    keys.sort_by(f64::total_cmp);
    keys.dedup();
    let weight_count = (keys.len() as u64).saturating_mul(defaults.len() as u64);
    if weight_count > ELEMENTS_MAX {
        let message =
            format!("{weight_count} weights in all frames; at most {ELEMENTS_MAX} are read");
        notes.problem(at, message);
        return None;
    }
    let (mut times, mut weights) = (Vec::new(), Vec::new());
    let (mut before, mut after) = (defaults.to_vec(), defaults.to_vec());
    for t in keys {
        for (node, curve) in curves {
            let own = node.first..node.first + node.count;
            curve.weights(t, Side::Before, &mut before[own.clone()]);
            curve.weights(t, Side::After, &mut after[own]);
        }
        if before != after {
            times.push(t);
            weights.extend_from_slice(&before);
        }
        times.push(t);
        weights.extend_from_slice(&after);
    }
    Some((times, weights))
}
