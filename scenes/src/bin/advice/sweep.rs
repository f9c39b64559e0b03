//! The sweep.

use bdtree_build::advise::curve::{Bench, Point};
use bdtree_build::advise::{Advice, AdviceError, Goal, Subject, advise};
use bdtree_build::progress::Silent;

/// Leaf sizes of the sweep.
const LEAF_SIZES: [usize; 6] = [1, 2, 3, 4, 6, 8];

/// Settings that are timed again.
const FINALISTS: usize = 4;

/// What came out.
pub(crate) struct Found {
    pub(crate) advice: Advice,
    /// The fastest of all, as timed again.
    pub(crate) best: Point,
    /// How many settings keep to the goal.
    pub(crate) settings: usize,
    /// Time of the advised setting over that of the best, in one run.
    pub(crate) ratio: f64,
}

/// Takes the advice, then tries everything.
pub(crate) fn run(subject: &Subject, goal: &Goal) -> Result<Found, AdviceError> {
    let advice = advise(subject, goal, &Silent)?;
    let bench = Bench::new(subject, goal.samples, goal.seconds, &Silent)?;
    let mut all = Vec::new();
    for modes in good_enough(subject, goal, &advice) {
        let settings = LEAF_SIZES.map(|size| (&modes[..], size));
        all.extend(bench.points(&settings, &Silent)?.1);
        eprintln!("{} modes of {} timed", modes.len(), subject.mesh.name);
    }
    let settings = all.len();
    all.sort_by(|a, b| a.time_rel.total_cmp(&b.time_rel));
    let chosen = &advice.chosen;
    let finalists = all.iter().take(FINALISTS).chain([chosen]);
    let finalists: Vec<_> = finalists
        .map(|point| (&point.modes[..], point.leaf_size))
        .collect();
    let (_, again) = bench.points(&finalists, &Silent)?;
    let Some(advised) = again.last() else {
        return Err(AdviceError::NothingMeasured);
    };
    let best = again
        .iter()
        .min_by(|a, b| a.time_rel.total_cmp(&b.time_rel))
        .unwrap_or(advised);
    Ok(Found {
        ratio: advised.measured.time_over(&best.measured),
        best: best.clone(),
        settings,
        advice: advice.clone(),
    })
}

/// Modes that keep to the goal: of the first ones every number that does, and what an error limit chooses.
/// Where nothing does, what is advised.
fn good_enough(subject: &Subject, goal: &Goal, advice: &Advice) -> Vec<Vec<usize>> {
    let count = subject.basis.mode_count();
    let mut good: Vec<Vec<usize>> = (0..=count)
        .filter(|&count| {
            let bound = subject.errors.bound_rel(count);
            bound.is_some_and(|bound| bound <= goal.max_error_rel)
        })
        .map(|count| (0..count).collect())
        .collect();
    good.extend(goal.subset.iter().map(|(modes, _)| modes.clone()));
    good.push(advice.chosen.modes.clone());
    good.sort();
    good.dedup();
    good
}

/// A setting in words.
pub(crate) fn setting(point: &Point, subject: &Subject) -> String {
    format!(
        "{} of {} modes, leaves of {}",
        point.modes.len(),
        subject.basis.mode_count(),
        point.leaf_size
    )
}

/// Bytes and time that the advice saves of all modes'.
pub(crate) fn saved(advice: &Advice) -> String {
    let bytes = 1.0 - advice.chosen.bytes as f64 / advice.all.bytes as f64;
    format!(
        "{:.0} % bytes, {:.0} % time",
        100.0 * bytes,
        100.0 * (1.0 - advice.chosen.time_rel)
    )
}
