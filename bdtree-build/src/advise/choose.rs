//! The fewest modes that are good enough, then the leaf size.

use super::AdviceError;
use super::curve::{Bench, POINTS_MAX, Point, counts};
use super::errors::Over;
use super::samples::{Bones, Source};
use super::subject::Subject;
use super::works::Refining;
use crate::pipeline::default_leaf_size;
use crate::progress::Progress;

/// Leaf sizes that are tried unless one is asked for.
pub const LEAF_SIZES: [usize; 3] = [2, 4, 8];

/// Another leaf size than the default is advised only where it takes less than this share of its time: what
/// one run measures is not surer.
const FASTER: f64 = 0.95;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// Largest error at any vertex over the diagonal of the box, above 0.
    pub max_error_rel: f64,
    /// Modes that may be used at most.
    pub modes_max: usize,
    /// Modes other than the first ones that are good enough, too (by their numbers, ascending), and what the bake
    /// states as their error: `--modes auto` of given fields and morph targets.
    pub subset: Option<(Vec<usize>, f64)>,
    /// Leaf sizes to try besides the one that the settings have; empty where that stays.
    pub leaf_sizes: Vec<usize>,
    /// Samples at which assets are measured ([`super::samples::SAMPLES`]).
    pub samples: usize,
    /// Seconds that timing one setting beside others may take.
    pub seconds: f64,
    /// Numbers of modes to measure besides those that matter, at most [`POINTS_MAX`].
    pub curve_points: usize,
    /// Whether to measure from how many questions a step on refined poses pay.
    pub refines: bool,
}

impl Default for Goal {
    /// 1 % of the diagonal, as many modes as there are, the usual leaf sizes, no curve, refined poses.
    fn default() -> Self {
        Self {
            max_error_rel: 0.01,
            modes_max: usize::MAX,
            subset: None,
            leaf_sizes: LEAF_SIZES.to_vec(),
            samples: super::samples::SAMPLES,
            seconds: 0.4,
            curve_points: 0,
            refines: true,
        }
    }
}

/// What is advised, and all that was measured for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// What was asked for.
    pub max_error_rel: f64,
    /// Whether the advised modes keep to it.
    pub is_met: bool,
    /// The error that they keep to, against the source where there is one; 0 for a rigid asset.
    pub error_rel: f64,
    /// The error that one mode fewer would leave, where the advised modes are the first ones and are not none.
    pub error_of_fewer_rel: Option<f64>,
    /// Whether these errors are bounds, so that less may be true.
    pub are_bounds: bool,
    /// What the error is taken over.
    pub over: Over,
    /// Where the q of samples come from, and how many there are.
    pub samples: (Source, usize),
    /// Where their bones come from; `None` without a skin.
    pub bones: Option<Bones>,
    /// Number of frames of the animation; 0 without.
    pub frames: usize,
    /// Number of modes that the source has, where it is known and more may be baked than [`Advice::all`] has.
    pub available: Option<usize>,
    /// The asset as it is, with all modes.
    pub all: Point,
    /// What is advised.
    pub chosen: Point,
    /// Whether the advised modes are the first ones; else those that an error limit chooses.
    pub takes_first: bool,
    /// The advised modes with each leaf size that was tried, ascending.
    pub leaves: Vec<Point>,
    /// The leaf size that needs no option.
    pub default_leaf_size: usize,
    /// Whether that is the builder's default, too.
    pub has_default_leaves: bool,
    /// Names of all modes, where they have some.
    pub mode_names: Vec<Option<String>>,
    /// Errors, bytes and times over the number of modes, ascending: what is advised and all modes among them.
    pub curve: Vec<Point>,
    /// Whether refined poses pay with what is advised, if that was asked for.
    pub refining: Option<Refining>,
    /// What is not known: sentences.
    pub missing: Vec<String>,
}

/// The fewest modes whose error meets the goal, or all that may be used where none does, with the leaf size that is
/// faster than the default by more than 5 %, measured twice. Counts and errors are the same in every run, times are measured.
///
/// # Errors
/// What bakes and queries of the subject refuse.
pub fn advise(
    subject: &Subject,
    goal: &Goal,
    progress: &dyn Progress,
) -> Result<Advice, AdviceError> {
    let bench = Bench::new(subject, goal.samples, goal.seconds, progress)?;
    let mode_count = subject.basis.mode_count();
    let most = mode_count.min(goal.modes_max);
    let first = subject.errors.fewest(goal.max_error_rel, most);
    let subset = goal
        .subset
        .as_ref()
        .filter(|(modes, _)| modes.len() <= most && first.is_none_or(|first| modes.len() < first));
    let modes: Vec<usize> = match subset {
        Some((modes, _)) => modes.clone(),
        None => (0..first.unwrap_or(most)).collect(),
    };
    let error_rel = match subset {
        Some((_, error)) => *error,
        None => subject.errors.bound_rel(modes.len()).unwrap_or(0.0),
    };

    let default = bench.leaf_size();
    let mut leaf_sizes = vec![default];
    leaf_sizes.extend(&goal.leaf_sizes);
    leaf_sizes.sort_unstable();
    leaf_sizes.dedup();
    let settings: Vec<_> = leaf_sizes.iter().map(|&size| (&modes[..], size)).collect();
    progress.stage("leaf sizes", Some(2 * settings.len() as u64));
    let (mut all, mut leaves) = bench.points(&settings, progress)?;
    let mut chosen = best_leaf(&leaves, default).ok_or(AdviceError::NothingMeasured)?;
    if chosen.leaf_size != default {
        // Once more, these two alone: the least of several times is partly luck.
        let two = [default, chosen.leaf_size].map(|size| (&modes[..], size));
        progress.stage("leaf sizes", Some(2 * two.len() as u64));
        let (whole, again) = bench.points(&two, progress)?;
        chosen = best_leaf(&again, default).ok_or(AdviceError::NothingMeasured)?;
        leaves.retain(|point| again.iter().all(|new| new.leaf_size != point.leaf_size));
        leaves.extend(again);
        leaves.sort_by_key(|point| point.leaf_size);
        all = whole;
    }

    let mut curve = Vec::new();
    if goal.curve_points > 0 {
        let points = goal.curve_points.min(POINTS_MAX);
        let counts = counts(mode_count, first.unwrap_or(most), points);
        progress.stage("fewer modes", Some(2 * counts.len() as u64));
        for count in counts {
            let first: Vec<usize> = (0..count).collect();
            curve.extend(bench.points(&[(&first, default)], progress)?.1);
        }
    }
    let refining = if goal.refines {
        progress.stage("refined poses", None);
        Some(bench.refining((&chosen.modes, chosen.leaf_size))?)
    } else {
        None
    };
    Ok(Advice {
        max_error_rel: goal.max_error_rel,
        is_met: subset.is_some() || first.is_some(),
        error_rel,
        error_of_fewer_rel: modes
            .len()
            .checked_sub(1)
            .filter(|_| subset.is_none())
            .and_then(|fewer| subject.errors.bound_rel(fewer)),
        are_bounds: subject.errors.are_bounds(modes.len()),
        over: subject.errors.over,
        samples: (bench.samples.source, bench.samples.count),
        bones: bench.samples.bones,
        frames: subject
            .basis
            .animation
            .as_ref()
            .map_or(0, |a| a.frame_count),
        available: subject.modes_available.filter(|&count| count > mode_count),
        all,
        takes_first: subset.is_none(),
        chosen,
        leaves,
        default_leaf_size: default,
        has_default_leaves: default == default_leaf_size(subject.mesh.triangles.len()),
        mode_names: subject
            .basis
            .modes
            .iter()
            .map(|mode| mode.name.clone())
            .collect(),
        curve,
        refining,
        missing: subject.missing.clone(),
    })
}

/// The fastest, if it is faster than the default by enough; else the default.
fn best_leaf(leaves: &[Point], default: usize) -> Option<Point> {
    let default = leaves.iter().find(|point| point.leaf_size == default)?;
    let fastest = leaves
        .iter()
        .min_by(|a, b| a.time_rel.total_cmp(&b.time_rel))?;
    let is_faster = fastest.measured.time_over(&default.measured) < FASTER
        && !fastest.measured.visits_like(&default.measured);
    Some(if is_faster { fastest } else { default }.clone())
}
