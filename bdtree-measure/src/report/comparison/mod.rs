//! Ours beside deforming all vertices and refitting a tree of boxes, over how much is asked per step: where
//! the second becomes faster (the paper's section 6: "for large M or when most spheres are queried").
//!
//! The contender is obvhs, the fastest library of docs/measured/benchmarks.md that Rust programs can refit; it gets
//! the same deformed vertices and finds the same contacts. What the two do at leaves differs: for balls and
//! pairs the contender tests triangle by triangle with the product's public scalar functions
//! ([`crate::leaf`]), where ours rejects and tests four triangles at a time; for rays it uses its
//! own test in f32, where ours rejects four at a time and measures hits in f64. So these times are of what a
//! program gets from either, not of trees alone.

mod refitted;

use crate::MeasureError;
use crate::clock::Clock;
use crate::comparison::{AMOUNTS, Comparison, LEAF_SLOTS, VISITS_MAX};
use crate::ours::{Answer, Ours};
use crate::stats::median;
use bdtree_build::progress::Progress;
use bdtree_runtime::{Asset, PairContact, RefinedPose, Workspace};

use super::REPETITIONS;
use super::content::{Curve, CurvePoint, Refit};
use crate::sample::{HERE, Sample};
use refitted::Contender;

/// Samples that are measured, of those there are.
const STEPS: usize = 4;

/// The samples that are steps here, evenly chosen.
pub(super) fn steps(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    let step = samples.len().div_ceil(STEPS).max(1);
    samples.iter().step_by(step)
}

/// All curves. `samples` are used evenly.
pub(super) fn compare(
    asset: &Asset<'_>,
    samples: &[Sample],
    progress: &dyn Progress,
) -> Result<Refit, MeasureError> {
    let steps: Vec<&Sample> = steps(samples).collect();
    let mut own = Ours::keeping(*asset, LEAF_SLOTS);
    let mut contender = Contender::new(asset)?;
    let (mut deform, mut refit, mut pose) = (Vec::new(), Vec::new(), Vec::new());
    let mut memory = vec![0.0; asset.pose_len()];
    for sample in &steps {
        for _ in 0..REPETITIONS {
            let update = contender.update(sample);
            deform.push(update.deform * 1e6);
            refit.push(update.refit * 1e6);
        }
        let cost = timed(|| {
            std::hint::black_box(sample.pose(asset, HERE, &mut memory)?);
            Ok(Cost::default())
        })?;
        pose.push(cost.micros);
    }
    let deepness: Vec<usize> = (0..steps.first().map_or(0, |s| s.places.len())).collect();
    let all = 2 * AMOUNTS.len() + deepness.len();
    progress.stage("measuring deform + refit", Some(all as u64));
    let curve = |question, unit, amounts: &[usize], at: At<'_>| {
        curve(question, unit, amounts, progress, at)
    };
    let balls = curve("ball", "balls per step", &AMOUNTS, &mut |amount| {
        let ours = mean(&steps, |sample| {
            let balls: Vec<_> = sample.balls(amount).collect();
            ours(asset, || {
                let answer = own.balls(sample.posture(), balls.iter().copied())?;
                Ok((answer, own.is_refined()))
            })
        })?;
        let theirs = mean(&steps, |sample| contender.balls(sample, amount))?;
        Ok((amount as f64, ours, theirs))
    })?;
    let rays = curve("ray", "rays per step", &AMOUNTS, &mut |amount| {
        let ours = mean(&steps, |sample| {
            let rays: Vec<_> = sample.rays(amount).collect();
            ours(asset, || {
                let answer = own.rays(sample.posture(), rays.iter().copied())?;
                Ok((answer, own.is_refined()))
            })
        })?;
        let theirs = mean(&steps, |sample| contender.rays(sample, amount))?;
        Ok((amount as f64, ours, theirs))
    })?;
    let mut other = Contender::new(asset)?;
    let pairs = curve(
        "pair",
        "touching pairs of triangles",
        &deepness,
        &mut |which| {
            let ours = mean(&steps, |sample| pair(asset, sample, which))?;
            let theirs = mean(&steps, |sample| contender.pair(&mut other, sample, which))?;
            Ok((whole(ours.amount), ours, theirs))
        },
    )?;
    Ok(Refit {
        library: "obvhs 0.4 Bvh2, refit_all".to_string(),
        deform_micros: median(&deform),
        refit_micros: median(&refit),
        pose_micros: median(&pose),
        refined_bytes: RefinedPose::bytes_for(asset)? as u64,
        curves: vec![balls, rays, pairs],
    })
}

/// A step of ours, which tells whether it has refined its pose.
fn ours(
    asset: &Asset<'_>,
    mut ask: impl FnMut() -> Result<(Answer, bool), MeasureError>,
) -> Result<Cost, MeasureError> {
    timed(|| {
        let (answer, is_refined) = ask()?;
        Ok(Cost {
            visited: answer.nodes.visited as f64 / asset.node_count().max(1) as f64,
            refined: if is_refined { 1.0 } else { 0.0 },
            ..Cost::default()
        })
    })
}

/// Two instances of ours, one at a place of the sample's.
fn pair(asset: &Asset<'_>, sample: &Sample, which: usize) -> Result<Cost, MeasureError> {
    let mut memory = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let mut workspace = Workspace::new();
    let mut found: Vec<PairContact> = Vec::new();
    timed(|| {
        found.clear();
        let [a, b] = &mut memory;
        let a = sample.pose(asset, HERE, a)?;
        let b = sample.pose(asset, sample.places[which], b)?;
        let mut query = a.against(&b, &mut workspace);
        query.contacts(0.0, &mut found)?;
        let visits = query.stats().nodes_visited;
        Ok(Cost {
            visited: visits as f64 / asset.node_count().max(1) as f64,
            amount: found.len() as f64,
            ..Cost::default()
        })
    })
}

/// A mean of counts as a count; 0 only where nothing was counted.
fn whole(mean: f64) -> f64 {
    if mean > 0.0 {
        mean.round().max(1.0)
    } else {
        0.0
    }
}

/// Means over steps.
#[derive(Debug, Clone, Copy, Default)]
struct Cost {
    micros: f64,
    /// Nodes visited over all nodes.
    visited: f64,
    /// Pairs that touch.
    amount: f64,
    /// 1 if the pose was refined; in means the share of steps.
    refined: f64,
}

fn mean(
    steps: &[&Sample],
    mut of: impl FnMut(&Sample) -> Result<Cost, MeasureError>,
) -> Result<Cost, MeasureError> {
    let mut sum = Cost::default();
    for sample in steps {
        let cost = of(sample)?;
        sum.micros += cost.micros;
        sum.visited += cost.visited;
        sum.amount += cost.amount;
        sum.refined += cost.refined;
    }
    let count = steps.len().max(1) as f64;
    Ok(Cost {
        micros: sum.micros / count,
        visited: sum.visited / count,
        amount: sum.amount / count,
        refined: sum.refined / count,
    })
}

/// Amount, ours and theirs of one of the amounts of a curve.
type At<'a> = &'a mut dyn FnMut(usize) -> Result<(f64, Cost, Cost), MeasureError>;

/// Follows a curve; where it ends depends on counts alone, not on times.
fn curve(
    question: &str,
    unit: &str,
    amounts: &[usize],
    progress: &dyn Progress,
    at: At<'_>,
) -> Result<Curve, MeasureError> {
    let mut points: Vec<CurvePoint> = Vec::new();
    for amount in amounts {
        let (amount, ours, theirs) = at(*amount)?;
        progress.advance(1);
        points.push(CurvePoint {
            amount,
            bdtree_micros: ours.micros,
            refit_micros: theirs.micros,
            ratio: theirs.micros / ours.micros,
            visited_rel: ours.visited,
            refined_rel: ours.refined,
        });
        if ours.visited > VISITS_MAX {
            break;
        }
    }
    progress.advance((amounts.len() - points.len()) as u64);
    points.sort_by(|a, b| a.amount.total_cmp(&b.amount));
    let same = points.chunk_by(|a, b| a.amount == b.amount);
    let points: Vec<CurvePoint> = same.map(as_one).collect();
    let ratios: Vec<(f64, f64)> = points.iter().map(|p| (p.amount, p.ratio)).collect();
    Ok(Curve {
        question: question.to_string(),
        unit: unit.to_string(),
        comparison: Comparison::of(&ratios),
        points,
    })
}

/// Points of one amount as one: geometric means of their times, since those may differ by much (pairs that do not touch
/// stand anywhere from far apart to almost touching).
fn as_one(same: &[CurvePoint]) -> CurvePoint {
    let count = same.len() as f64;
    let mean = |of: &dyn Fn(&CurvePoint) -> f64| same.iter().map(of).sum::<f64>() / count;
    let bdtree_micros = mean(&|p| p.bdtree_micros.ln()).exp();
    let refit_micros = mean(&|p| p.refit_micros.ln()).exp();
    match same {
        [one] => one.clone(),
        _ => CurvePoint {
            amount: mean(&|p| p.amount),
            bdtree_micros,
            refit_micros,
            ratio: refit_micros / bdtree_micros,
            visited_rel: mean(&|p| p.visited_rel),
            refined_rel: mean(&|p| p.refined_rel),
        },
    }
}

/// Long steps are repeated less often: until this much time is spent, s.
const LONG: f64 = 0.3;

/// Short steps are repeated within a span of the clock until it lasts so long, s …
const SPAN: f64 = 50e-6;

/// … or so many are in it.
const SPAN_STEPS: usize = 256;

/// Runs a step some times; the median, µs. Nothing but the step lies between two looks at the clock.
fn timed(mut step: impl FnMut() -> Result<Cost, MeasureError>) -> Result<Cost, MeasureError> {
    let mut span = |steps: usize| -> Result<(f64, Cost), MeasureError> {
        let clock = Clock::start();
        let mut cost = step()?;
        for _ in 1..steps {
            cost = step()?;
        }
        Ok((clock.seconds(), cost))
    };
    let mut steps = 1;
    let (mut seconds, mut cost) = span(steps)?;
    while seconds < SPAN && steps < SPAN_STEPS {
        steps *= 2;
        (seconds, cost) = span(steps)?;
    }
    let mut spans = vec![seconds];
    while spans.len() < REPETITIONS && spans.iter().sum::<f64>() < LONG {
        (seconds, cost) = span(steps)?;
        spans.push(seconds);
    }
    Ok(Cost {
        micros: median(&spans) * 1e6 / steps as f64,
        ..cost
    })
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use bdtree_build::progress::Silent;

    use super::{Cost, SPAN_STEPS, curve, timed};

    #[test]
    fn short_steps_are_told_apart() {
        let cost = |work: u64| {
            let mut runs = 0;
            let cost = timed(|| {
                runs += 1;
                let sum: u64 = (0..work).map(black_box).sum();
                black_box(sum);
                Ok(Cost {
                    amount: work as f64,
                    ..Cost::default()
                })
            });
            (cost.expect("nothing fails"), runs)
        };
        let ((short, many), (long, few)) = (cost(100), cost(10_000));
        assert_eq!((short.amount, long.amount), (100.0, 10_000.0));
        assert!(short.micros > 0.0 && many > few && many > SPAN_STEPS / 2);
        // A hundred times the work, whatever the clock takes to read: with much room, since other work interrupts.
        let ratio = long.micros / short.micros;
        assert!((10.0..1000.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_curve_ends_where_every_node_is_visited_a_hundred_times() {
        let mut at = |amount: usize| {
            let cost = |micros| Cost {
                micros,
                visited: amount as f64,
                ..Cost::default()
            };
            Ok((amount as f64, cost(amount as f64), cost(20.0)))
        };
        let curve = curve(
            "ball",
            "balls per step",
            &[4, 40, 101, 400],
            &Silent,
            &mut at,
        );
        let curve = curve.expect("a curve");
        let amounts: Vec<f64> = curve.points.iter().map(|p| p.amount).collect();
        assert_eq!(amounts, [4.0, 40.0, 101.0]);
        assert_eq!(curve.points[0].ratio, 5.0);
        assert_eq!(curve.comparison.break_even, Some(20.0));
    }

    #[test]
    fn points_of_one_amount_are_one() {
        let mut at = |which: usize| {
            let cost = |micros| Cost {
                micros,
                visited: which as f64,
                ..Cost::default()
            };
            let ours = [1.0, 4.0, 5.0][which];
            Ok((if which < 2 { 0.0 } else { 9.0 }, cost(ours), cost(8.0)))
        };
        let curve = curve(
            "pair",
            "touching pairs of triangles",
            &[0, 1, 2],
            &Silent,
            &mut at,
        );
        let points = curve.expect("a curve").points;
        assert_eq!(
            points.iter().map(|p| p.amount).collect::<Vec<_>>(),
            [0.0, 9.0]
        );
        let first = &points[0];
        assert!((first.bdtree_micros - 2.0).abs() < 1e-12 && (first.ratio - 4.0).abs() < 1e-12);
        assert_eq!(first.visited_rel, 0.5);
    }
}
