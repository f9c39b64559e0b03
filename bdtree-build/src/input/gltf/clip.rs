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
    let number_count = number_count(chosen, accessors);
    if number_count > ELEMENTS_MAX {
        let at = format!("animations[{}].samplers", chosen.index);
        let message = format!(
            "{number_count} times and values of all samplers; at most {ELEMENTS_MAX} are read"
        );
        notes.problem(at, message);
        return None;
    }
    let mut curves = Curves::default();
    let mut moves: Vec<(MorphNode, usize)> = Vec::new();
    let mut moved = HashSet::new();
    for &(i, channel, node) in &chosen.channels {
        let at = format!("animations[{}].channels[{i}]", chosen.index);
        if !moved.insert(node.first) {
            notes.problem(at, "moves the weights of a node that another channel moves");
        } else if let Some(curve) = curves.of(chosen, channel, node.count, accessors, notes) {
            moves.push((node, curve));
        }
    }
    if !notes.is_clean() {
        return None;
    }
    let (times_s, weights) = frames(chosen, &curves.list, &moves, defaults, notes)?;
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

/// Times and values of the samplers that move weights, never too few: many samplers can name the
/// same bytes.
fn number_count(of: &Candidate<'_>, accessors: &Accessors<'_>) -> u64 {
    let samplers: HashSet<usize> = of.channels.iter().map(|c| c.1.sampler.value()).collect();
    samplers
        .into_iter()
        .filter_map(|sampler| of.animation.samplers.get(sampler))
        .flat_map(|sampler| [sampler.input.value(), sampler.output.value()])
        .filter_map(|index| accessors.list.get(index))
        .fold(0, |sum, accessor| sum.saturating_add(accessor.count.0))
}

/// The curves of an animation; channels with one sampler share one.
#[derive(Default)]
struct Curves {
    list: Vec<Curve>,
    /// Index in `list` by sampler and number of weights; `None` if something is wrong with it.
    known: HashMap<(usize, usize), Option<usize>>,
}

impl Curves {
    /// Index of the curve of one channel for `width` weights. What is wrong with a sampler is noted
    /// once.
    fn of(
        &mut self,
        of: &Candidate<'_>,
        channel: &Channel,
        width: usize,
        accessors: &Accessors<'_>,
        notes: &mut Notes,
    ) -> Option<usize> {
        let sampler = channel.sampler.value();
        if let Some(&known) = self.known.get(&(sampler, width)) {
            return known;
        }
        let index = curve(of, sampler, width, accessors, notes).map(|curve| {
            self.list.push(curve);
            self.list.len() - 1
        });
        self.known.insert((sampler, width), index);
        index
    }
}

/// The curve of a sampler for `width` weights.
fn curve(
    of: &Candidate<'_>,
    sampler: usize,
    width: usize,
    accessors: &Accessors<'_>,
    notes: &mut Notes,
) -> Option<Curve> {
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
    curves: &[Curve],
    moves: &[(MorphNode, usize)],
    defaults: &[f64],
    notes: &mut Notes,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let at = format!("animations[{}]", of.index);
    let too_many = |notes: &mut Notes| {
        let message = format!(
            "more than {ELEMENTS_MAX} weights in all frames, with {} in each; no more are read",
            defaults.len()
        );
        notes.problem(&at, message);
    };
    // No overflow: the limit is far below 2³².
    let most = ELEMENTS_MAX as usize / defaults.len().max(1);
    let mut keys: Vec<f64> = Vec::new();
    let mut off = 0.0_f64;
    for curve in curves {
        let frames = curve.frames(most);
        keys.extend(frames.iter().flat_map(|(times, _)| times));
        // Two ascending runs, which this sort merges.
        keys.sort_by(f64::total_cmp);
        keys.dedup();
        match frames {
            Some((_, own)) if keys.len() <= most => off = off.max(own),
            _ => {
                too_many(notes);
                return None;
            }
        }
    }
    if off > 0.0 {
        notes.warn(
            &at,
            format!("bends so fast that weights between frames are off by up to {off}"),
        );
    }
    let (mut times, mut weights) = (Vec::new(), Vec::new());
    let (mut before, mut after) = (defaults.to_vec(), defaults.to_vec());
    for t in keys {
        for &(node, curve) in moves {
            let Some(curve) = curves.get(curve) else {
                continue;
            };
            let own = node.first..node.first + node.count;
            curve.weights(t, Side::Before, &mut before[own.clone()]);
            curve.weights(t, Side::After, &mut after[own]);
        }
        // A jump makes two frames of one key.
        if times.len() + 2 > most && (before != after || times.len() == most) {
            too_many(notes);
            return None;
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
