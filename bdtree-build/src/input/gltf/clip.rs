//! The animation that moves weights, as frames between which weights are linear.

use std::collections::{HashMap, HashSet};

use gltf::json::Animation;
use gltf::json::animation::{Channel, Property};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::curve::{Curve, Side};
use super::model::MorphNode;
use super::notes::Notes;
use super::plan::ELEMENTS_MAX;
use super::samplers::Curves;
use crate::figures::counted;
use crate::input::RawClip;

/// Names of animations that a message lists.
const NAMES_SHOWN: usize = 20;

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
        let names = list.iter().take(NAMES_SHOWN);
        let mut names: Vec<String> = names.map(|c| format!("{:?}", c.name)).collect();
        if names.len() < list.len() {
            names.push("…".to_string());
        }
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
                return notes.refuse("animations", message);
            }
        },
    };
    let others: Vec<&Candidate<'_>> = candidates
        .iter()
        .filter(|c| c.index != chosen.index)
        .collect();
    // Who names one knows that there are others.
    if !others.is_empty() && wanted.is_none() {
        let message = format!(
            "{} animations move weights; {:?}, the first, is stored. Choose another with --clip NAME: {}",
            candidates.len(),
            chosen.name,
            shown(&others)
        );
        notes.warn("", message);
    }
    let mut curves = Curves::of(chosen.index, chosen.animation);
    let used = chosen
        .channels
        .iter()
        .map(|c| c.1.sampler.value())
        .collect();
    if !curves.check_size(used, accessors, notes) {
        return None;
    }
    let mut moves: Vec<(MorphNode, usize)> = Vec::new();
    let mut moved = HashSet::new();
    for &(i, channel, node) in &chosen.channels {
        let at = format!("animations[{}].channels[{i}]", chosen.index);
        if !moved.insert(node.first) {
            notes.problem(at, "moves the weights of a node that another channel moves");
        } else if let Some(curve) =
            curves.add(channel.sampler.value(), node.count, accessors, notes)
        {
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
        let (channels, animations) = (counted(moved, "channel"), counted(moving, "animation"));
        let verb = if moved == 1 { "moves" } else { "move" };
        let message = format!("ignored {channels} of {animations} that {verb} nodes, not weights");
        notes.warn("animations", message);
    }
    if stray > 0 {
        let channels = counted(stray, "channel");
        let message = format!("ignored {channels} for weights of nodes without morph targets");
        notes.warn("animations", message);
    }
    candidates
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
