//! Advice in sentences, with its figures.

use super::choose::Advice;
use super::curve::Point;
use super::errors::Over;
use super::samples::{Bones, Source};
use super::works::{Nearby, Refining, Work};
use crate::figures::numbers;

/// Savings below this are within what one run measures.
const NOTICEABLE: f64 = 0.05;

/// Above this share of the nodes bounds exclude little: the bake's own limit (report::visits).
const USELESS_SHARE: f64 = 0.25;

/// Fewer nodes are visited quickly anyway.
const NODES_MIN: usize = 64;

impl Advice {
    /// What is advised and why, a sentence or two each: modes, what they save, leaves, what is missing.
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences = vec![self.modes()];
        sentences.extend(self.against_source());
        sentences.extend(self.savings());
        sentences.extend(self.leaf());
        sentences.extend(self.bounds());
        sentences.extend(self.refining.as_ref().map(refining));
        sentences.extend(self.posed());
        sentences.extend(self.unknown());
        sentences.extend(self.missing.iter().cloned());
        sentences
    }

    fn modes(&self) -> String {
        let (kept, all) = (self.chosen.modes.len(), self.all.modes.len());
        if all == 0 {
            let what = match self.bones {
                Some(_) => "Bones alone move the asset",
                None => "The asset is rigid",
            };
            return format!("{what}: there are no modes to choose from.");
        }
        let over = match self.over {
            Over::Source => format!("measured against all {} frames of the source", self.frames),
            Over::Frames => format!("in all {} frames of the animation", self.frames),
            Over::Ranges => "for every q within q_range".to_string(),
        };
        let goal = percent(self.max_error_rel);
        let error = percent(self.error_rel);
        let which = match (kept == all, self.available) {
            (true, Some(available)) => format!("{} of the {available} available", modes(all)),
            (true, None) if all == 1 => "The one mode".to_string(),
            (true, None) if all == 2 => "Both modes".to_string(),
            (false, None) if kept == 0 => "No mode".to_string(),
            (true, None) => format!("All {}", modes(all)),
            (false, available) => {
                let available = available.map(|count| format!("{count} available"));
                let others = (!self.takes_first).then(|| {
                    let kept = named(&self.chosen.modes, &self.mode_names);
                    let number = match self.chosen.modes.len() {
                        1 => "number",
                        _ => "numbers",
                    };
                    format!("{number} {kept}")
                });
                let notes: Vec<String> = available.into_iter().chain(others).collect();
                let notes = match notes.is_empty() {
                    true => String::new(),
                    false => format!(" ({})", notes.join(", ")),
                };
                let first = if self.takes_first { "The first " } else { "" };
                format!("{first}{kept} of {}{notes}", modes(all))
            }
        };
        if !self.is_met && self.are_bounds {
            return format!(
                "The goal of {goal} of the box diagonal cannot be promised: {} leave{} an error of at most {error}, \
                 {over}.",
                uncapitalised(&which),
                if kept == 1 { "s" } else { "" }
            );
        }
        if !self.is_met && (kept < all || self.available.is_some()) {
            return format!(
                "{} leave{} an error of {error} (goal: {goal}). Allow more with --modes.",
                modes(kept),
                if kept == 1 { "s" } else { "" }
            );
        }
        if !self.is_met {
            return format!(
                "The goal of {goal} of the box diagonal is missed: {} leave{} an error of {error}, {over}; none can \
                 be spared.",
                uncapitalised(&which),
                if kept == 1 { "s" } else { "" }
            );
        }
        // Of fields that are their own source, all leave nothing but rounding.
        let is_all = kept == all && self.available.is_none();
        let place = match self.over {
            _ if self.error_rel != 0.0 => format!("within {error} of the box diagonal"),
            Over::Source => "where the source has it".to_string(),
            Over::Frames | Over::Ranges => "where all modes put it".to_string(),
        };
        let promise = if kept == 0 && self.available.is_none() {
            format!("No mode is needed to keep every vertex {place}, {over}; the goal is {goal}")
        } else if is_all && self.over != Over::Source && !self.are_bounds {
            format!(
                "{which} {} needed to keep every vertex within {goal} of the box diagonal, {over}",
                if kept == 1 { "is" } else { "are" }
            )
        } else {
            let s = if kept == 1 { "s" } else { "" };
            format!("{which} keep{s} every vertex {place}, {over}; the goal is {goal}")
        };
        match self.error_of_fewer_rel {
            Some(fewer) if fewer > self.max_error_rel && self.are_bounds => {
                let fewer = percent(fewer);
                format!("{promise}; with one mode fewer the error can reach {fewer}.")
            }
            Some(fewer) if fewer > self.max_error_rel => {
                format!("{promise}; one mode fewer would leave {}.", percent(fewer))
            }
            _ => format!("{promise}."),
        }
    }

    /// What the errors of an animation's file rest on.
    fn against_source(&self) -> Option<String> {
        (self.over == Over::Frames && self.are_bounds).then(|| {
            "The file's own error against its source is added to what fewer modes leave out, since the source is not \
             in the file: `bdtree-build … --advise` measures both together and may find that fewer modes are enough."
                .to_string()
        })
    }

    /// Against all modes, in bytes and time.
    fn savings(&self) -> Option<String> {
        let (chosen, all) = (&self.chosen, &self.all);
        if chosen.modes.len() == all.modes.len() {
            return None;
        }
        let bytes = 1.0 - chosen.bytes as f64 / all.bytes as f64;
        let size = if bytes > 0.0 {
            format!(
                "{} of the bytes ({} instead of {})",
                percent(bytes),
                chosen.bytes,
                all.bytes
            )
        } else {
            format!("no bytes ({}, all modes {})", chosen.bytes, all.bytes)
        };
        let saved = 1.0 - chosen.time_rel;
        let whole = modes(all.modes.len());
        let against = match self.available {
            None => format!("Against all {whole} that saves {size}"),
            Some(_) => format!("Against {whole} that saves {size}"),
        };
        if saved.abs() <= NOTICEABLE || chosen.measured.visits_like(&all.measured) {
            return Some(format!("{against}; no measurable difference in time."));
        }
        let time = if saved > 0.0 {
            format!("{} of the time", saving(saved))
        } else {
            format!("no time (it takes {} more)", percent(-saved))
        };
        Some(format!("{against} and {time}: {}.", times(chosen, all)))
    }

    fn leaf(&self) -> Option<String> {
        let default = self.default_leaf_size;
        let tried: Vec<String> = self
            .leaves
            .iter()
            .filter(|point| point.leaf_size != default)
            .map(|point| point.leaf_size.to_string())
            .collect();
        let (last, before) = tried.split_last()?;
        let default_point = self
            .leaves
            .iter()
            .find(|point| point.leaf_size == default)?;
        let is_default = self.has_default_leaves;
        if self.chosen.leaf_size == default {
            let default = match is_default {
                true => format!("default leaf size of {default}"),
                false => format!("leaf size of {default}"),
            };
            let tried = if before.is_empty() {
                format!("size {last} is")
            } else {
                format!("sizes {} and {last} are", before.join(", "))
            };
            return Some(format!(
                "Keep the {default} triangles: {tried} not more than 5 % faster."
            ));
        }
        let saved = 1.0 - self.chosen.measured.time_over(&default_point.measured);
        Some(format!(
            "Leaves of at most {} triangles save {} of the time against {default}, {} ({} bytes instead of {}).",
            self.chosen.leaf_size,
            saving(saved),
            if is_default {
                "the default"
            } else {
                "as it is now"
            },
            self.chosen.bytes,
            default_point.bytes
        ))
    }

    /// Many modes that move much leave spheres that exclude little (paper, section 6).
    fn bounds(&self) -> Option<String> {
        let share = self.chosen.ball_visits_share();
        (self.chosen.nodes >= NODES_MIN && share > USELESS_SHARE).then(|| {
            format!(
                "A ball of 5 % of the diagonal on the surface still visits {} of the {} nodes: bounds exclude little \
                 at these q, and deforming every vertex may be as fast. Fewer or smoother modes, or smaller q, help.",
                percent(share),
                self.chosen.nodes
            )
        })
    }

    /// What bones did while times were taken.
    fn posed(&self) -> Option<String> {
        let count = self.samples.1;
        Some(match self.bones? {
            Bones::Clips => format!("These times are over {count} poses of the clips."),
            Bones::Turns => format!(
                "There are no clips: these times are over {count} poses whose joints are turned by up to 20°."
            ),
        })
    }

    /// What the figures rest on where that is less than an animation.
    fn unknown(&self) -> Option<String> {
        let (source, count) = self.samples;
        let text = match source {
            Source::Frames | Source::Clips => return None,
            Source::Rest if self.bones.is_some() => return None,
            Source::Ranges if self.bones.is_some() => {
                "No clip moves a mode: each pose has a mixture of all modes within q_range.".to_string()
            }
            Source::Rest if self.all.modes.is_empty() => "Times are those of the rest pose.".to_string(),
            Source::Rest => "No mode moves anything within its range and no animation says more: times are those of \
                             the rest pose."
                .to_string(),
            Source::Ranges => format!(
                "There is no animation: times are those of {count} mixtures of all modes within q_range."
            ),
        };
        Some(text)
    }
}

/// From how many questions a step on memory for refined poses pays.
fn refining(refining: &Refining) -> String {
    let kinds = [("ball", refining.ball), ("ray", refining.ray)];
    let prepare = time(refining.prepare_seconds);
    let nearby =
        (refining.nearby.as_ref()).map_or(String::new(), |near| format!(" {}", nearby_words(near)));
    let (mut from, mut gains) = (Vec::new(), Vec::new());
    for (name, gain) in kinds {
        let Some(count) = gain.pays_from else {
            continue;
        };
        from.push(format!("{} {name}s", round_up(count)));
        let [without, with] = [gain.seconds, gain.refined_seconds].map(time);
        gains.push(format!("a {name} takes {with} instead of {without}"));
    }
    if from.is_empty() {
        let all_over = match refining.nearby {
            Some(_) => " all over the mesh",
            None => "",
        };
        let why = format!("preparing one takes {prepare}, and no question is faster by 5 % then.");
        return format!("Grant no memory for refined poses{all_over}: {why}{nearby}");
    }
    format!(
        "Grant {} bytes for a refined pose (StepCache::refining, which decides by itself) if steps ask more than {}: \
         preparing takes {prepare}, then {}.{nearby}",
        refining.bytes,
        from.join(" or "),
        gains.join(" and ")
    )
}

/// What is enough where steps ask in one place.
fn nearby_words(nearby: &Nearby) -> String {
    let [without, with] = [nearby.seconds, nearby.refined_seconds].map(time);
    format!(
        "Where steps ask in one place, {} bytes are enough: each of {} rays at {} % of the triangles takes {with} instead of \
         {without}, refining included.",
        nearby.bytes,
        nearby.rays,
        100.0 * nearby.share
    )
}

/// Times of each kind of question, and how many nodes it visits.
fn times(chosen: &Point, all: &Point) -> String {
    let works = chosen
        .measured
        .works()
        .into_iter()
        .zip(all.measured.works());
    let text: Vec<String> = works
        .map(|((name, own), (_, all))| {
            let visits = |work: Work| work.nodes_visited as f64 / work.questions.max(1) as f64;
            let nodes = match [visits(own), visits(all)].map(|n| format!("{n:.0}")) {
                [own, all] if own == all => format!("{own} nodes each"),
                [own, all] => format!("{own} instead of {all} nodes"),
            };
            let (own, all) = (time(own.seconds), time(all.seconds));
            format!("{name} {own} instead of {all} ({nodes})")
        })
        .collect();
    text.join(", ")
}

/// The most modes that are listed with their names.
const NAMED_MAX: usize = 12;

/// Modes by number and, where they are few and it is known, by name.
fn named(modes: &[usize], names: &[Option<String>]) -> String {
    let known = |mode: &usize| names.get(*mode).and_then(Option::as_deref);
    if modes.len() > NAMED_MAX || modes.iter().all(|mode| known(mode).is_none()) {
        return numbers(modes);
    }
    let name = |mode: &usize| match known(mode) {
        Some(name) => format!("{mode} \"{}\"", name.escape_debug()),
        None => mode.to_string(),
    };
    modes.iter().map(name).collect::<Vec<_>>().join(", ")
}

fn uncapitalised(text: &str) -> String {
    let mut chars = text.chars();
    let first = chars.next().map(|c| c.to_lowercase().to_string());
    first.unwrap_or_default() + chars.as_str()
}

fn modes(count: usize) -> String {
    format!("{count} mode{}", if count == 1 { "" } else { "s" })
}

/// A share in per cent, to three digits, upwards: what is promised is kept.
fn percent(share: f64) -> String {
    let x = 100.0 * share;
    if !(x > 0.0) {
        return "0 %".to_string();
    }
    if !x.is_finite() {
        return format!("{x} %");
    }
    let digits = (2 - x.log10().floor() as i32).clamp(0, 300);
    let unit = 10.0_f64.powi(digits);
    // What is a whole number of the last digit but for rounding stays.
    let up = (x * unit * (1.0 - 1e-12)).ceil() / unit;
    if up < 1e-3 {
        return format!("{up:.2e} %");
    }
    let text = format!("{up:.*}", digits as usize);
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    format!("{text} %")
}

/// A share in whole per cent, downwards: no more is claimed than was measured.
fn saving(share: f64) -> String {
    format!("{:.0} %", (100.0 * share).floor())
}

/// A count to two digits, upwards.
fn round_up(count: f64) -> u64 {
    let unit = 10.0_f64.powf((count.max(1.0).log10().floor() - 1.0).max(0.0));
    ((count / unit).ceil() * unit) as u64
}

/// Seconds to three digits.
fn time(seconds: f64) -> String {
    let (x, unit) = match seconds {
        s if s < 1e-3 => (1e6 * s, "µs"),
        s if s < 1.0 => (1e3 * s, "ms"),
        s => (s, "s"),
    };
    let digits = match x {
        x if x < 10.0 => 2,
        x if x < 100.0 => 1,
        _ => 0,
    };
    format!("{x:.digits$} {unit}")
}

#[cfg(test)]
mod tests;
