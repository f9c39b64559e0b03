//! Ours beside deforming all vertices and refitting a tree of boxes, over how much is asked per step: where
//! the second becomes faster (the paper's section 6: "for large M or when most spheres are queried").
//!
//! The contender is obvhs, the fastest library of docs/benchmarks.md that Rust programs can refit; it gets
//! the same deformed vertices and, for balls and pairs, the same exact tests.

use bdtree_baselines::Body;
use bdtree_baselines::clock::Clock;
use bdtree_baselines::deform::Deformer;
use bdtree_baselines::peers::{Obvhs, PairPeer, Peer};
use bdtree_baselines::place::Place;
use bdtree_baselines::stats::median;
use bdtree_runtime::{
    Asset, CachedPose, Contact, LeafSlot, NodeSlot, PairContact, PairStackEntry, Pose, Posed,
    StackEntry, StepCache, Transform, query,
};

use super::content::{Curve, CurvePoint, Refit};
use super::sample::Sample;
use super::{REPETITIONS, depth::HERE, problem, refused};
use crate::error::ToolError;

/// Questions per step.
const AMOUNTS: [usize; 7] = [1, 4, 16, 64, 256, 1024, 4096];

/// Samples that are measured, of those there are.
const STEPS: usize = 4;

/// A curve ends where questions visit every node this many times: long past where refitting pays.
const VISITS_MAX: f64 = 100.0;

/// Slots for leaves of a step's cache: those of all questions.
const LEAF_SLOTS: usize = 1 << 12;

/// From how many questions on a cache of the step's nodes is used.
const CACHED: usize = 4;

/// Deforms, refits and asks.
struct Contender {
    deformer: Deformer,
    tree: Obvhs,
    scratch: Vec<f32>,
    origin: [f64; 3],
    unit: f64,
}

impl Contender {
    fn new(asset: &Asset<'_>) -> Result<Self, ToolError> {
        let body = Body::of_asset(asset).map_err(problem)?;
        Ok(Self {
            deformer: Deformer::new(&body),
            tree: Obvhs::new(&body),
            scratch: Vec::new(),
            origin: asset.origin(),
            unit: asset.unit(),
        })
    }

    /// A point of the mesh in the contender's coordinates.
    fn point(&self, x: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (x[k] - self.origin[k]) / self.unit)
    }

    /// A placement (mesh units, scale 1) in its coordinates.
    fn place(&self, transform: &Transform) -> Place {
        let moved = Transform {
            translation: transform.translation,
            ..*transform
        };
        let of_origin = rotated(moved.rotation, self.origin);
        let t = [0, 1, 2].map(|k| of_origin[k] + moved.translation[k] - self.origin[k]);
        Place::new(moved.rotation, t.map(|x| x / self.unit))
    }
}

fn rotated([x, y, z, w]: [f64; 4], p: [f64; 3]) -> [f64; 3] {
    let rows = bdtree_baselines::place::matrix([x, y, z, w]);
    rows.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2])
}

/// The samples that are steps here, evenly chosen.
pub(super) fn steps(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    let step = samples.len().div_ceil(STEPS).max(1);
    samples.iter().step_by(step)
}

/// All curves. `samples` are used evenly.
pub(super) fn contest(asset: &Asset<'_>, samples: &[Sample]) -> Result<Refit, ToolError> {
    let steps: Vec<&Sample> = steps(samples).collect();
    let mut contender = Contender::new(asset)?;
    let (mut deform, mut refit, mut pose) = (Vec::new(), Vec::new(), Vec::new());
    let mut memory = vec![0.0; asset.pose_len()];
    for sample in &steps {
        for _ in 0..REPETITIONS {
            let update = update(&mut contender, sample, &HERE);
            deform.push(update.deform * 1e6);
            refit.push(update.refit * 1e6);
            let clock = Clock::start();
            std::hint::black_box(sample.pose(asset, &mut memory)?);
            pose.push(clock.seconds() * 1e6);
        }
    }
    let ball = curve("ball", "balls per step", &AMOUNTS, |amount| {
        let ours = mean(&steps, |sample| our_balls(asset, sample, amount))?;
        let theirs = mean(&steps, |sample| their_balls(&mut contender, sample, amount))?;
        Ok((amount as f64, ours, theirs))
    })?;
    let ray = curve("ray", "rays per step", &AMOUNTS, |amount| {
        let ours = mean(&steps, |sample| our_rays(asset, sample, amount))?;
        let theirs = mean(&steps, |sample| their_rays(&mut contender, sample, amount))?;
        Ok((amount as f64, ours, theirs))
    })?;
    let mut other = Contender::new(asset)?;
    let deepness: Vec<usize> = (0..steps.first().map_or(0, |s| s.places.len())).collect();
    let pair = curve("pair", "touching pairs of triangles", &deepness, |which| {
        let ours = mean(&steps, |sample| our_pair(asset, sample, which))?;
        let theirs = mean(&steps, |sample| {
            their_pair(&mut contender, &mut other, sample, which)
        })?;
        Ok((ours.amount, ours, theirs))
    })?;
    Ok(Refit {
        library: "obvhs 0.4 Bvh2, refit_all".to_string(),
        deform_micros: median(&deform),
        refit_micros: median(&refit),
        pose_micros: median(&pose),
        curves: vec![ball, ray, pair],
    })
}

/// Means over steps.
#[derive(Debug, Clone, Copy, Default)]
struct Cost {
    micros: f64,
    /// Nodes visited over all nodes.
    visited: f64,
    /// Pairs that touch.
    amount: f64,
}

fn mean(
    steps: &[&Sample],
    mut of: impl FnMut(&Sample) -> Result<Cost, ToolError>,
) -> Result<Cost, ToolError> {
    let mut sum = Cost::default();
    for sample in steps {
        let cost = of(sample)?;
        sum.micros += cost.micros;
        sum.visited += cost.visited;
        sum.amount += cost.amount;
    }
    let count = steps.len().max(1) as f64;
    Ok(Cost {
        micros: sum.micros / count,
        visited: sum.visited / count,
        amount: sum.amount / count,
    })
}

/// Follows a curve; where it ends depends on counts alone, not on times.
fn curve(
    question: &str,
    unit: &str,
    amounts: &[usize],
    mut at: impl FnMut(usize) -> Result<(f64, Cost, Cost), ToolError>,
) -> Result<Curve, ToolError> {
    let mut points: Vec<CurvePoint> = Vec::new();
    for amount in amounts {
        let (amount, ours, theirs) = at(*amount)?;
        points.push(CurvePoint {
            amount,
            ours_micros: ours.micros,
            refit_micros: theirs.micros,
            ratio: theirs.micros / ours.micros,
            visited_rel: ours.visited,
        });
        if ours.visited > VISITS_MAX {
            break;
        }
    }
    points.sort_by(|a, b| a.amount.total_cmp(&b.amount));
    Ok(Curve {
        question: question.to_string(),
        unit: unit.to_string(),
        break_even: break_even(&points),
        points,
    })
}

/// Where the last crossing is from ours below to ours above, between points as powers are; the first
/// amount where ours was never below.
fn break_even(points: &[CurvePoint]) -> Option<f64> {
    let last = points.last()?;
    if last.ours_micros <= last.refit_micros {
        return None;
    }
    let ahead = |p: &CurvePoint| (p.refit_micros / p.ours_micros).ln();
    let Some(k) = points.iter().rposition(|p| p.ours_micros <= p.refit_micros) else {
        return points.first().map(|p| p.amount);
    };
    let (a, b) = (&points[k], &points[k + 1]);
    let share = ahead(a) / (ahead(a) - ahead(b));
    let (low, high) = (a.amount.max(1.0).ln(), b.amount.max(1.0).ln());
    Some((low + share * (high - low)).exp())
}

fn update(
    contender: &mut Contender,
    sample: &Sample,
    transform: &Transform,
) -> bdtree_baselines::peers::Update {
    let place = match *transform == HERE {
        true => Place::IDENTITY,
        false => contender.place(transform),
    };
    let Contender {
        deformer,
        tree,
        scratch,
        ..
    } = contender;
    tree.update(deformer, &sample.q, &place, scratch)
}

/// Long steps are repeated less often: until this much time is spent, s.
const LONG: f64 = 0.3;

/// Runs a step some times; the median, µs.
fn timed(mut step: impl FnMut() -> Result<Cost, ToolError>) -> Result<Cost, ToolError> {
    let mut times = Vec::new();
    let mut last = Cost::default();
    for _ in 0..REPETITIONS {
        let clock = Clock::start();
        last = step()?;
        times.push(clock.seconds() * 1e6);
        if times.iter().sum::<f64>() > 1e6 * LONG {
            break;
        }
    }
    Ok(Cost {
        micros: median(&times),
        ..last
    })
}

fn our_balls(asset: &Asset<'_>, sample: &Sample, amount: usize) -> Result<Cost, ToolError> {
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut found: Vec<Contact> = Vec::new();
    ours(asset, sample, amount, |asset, step| {
        let mut visits = 0;
        for (center, radius) in sample.balls(amount) {
            found.clear();
            let outcome = query::ball(asset, step.posed(), center, radius, &mut stack, &mut found);
            visits += outcome.map_err(refused)?.nodes_visited;
        }
        Ok(visits)
    })
}

fn our_rays(asset: &Asset<'_>, sample: &Sample, amount: usize) -> Result<Cost, ToolError> {
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    ours(asset, sample, amount, |asset, step| {
        let mut visits = 0;
        for (origin, direction) in sample.rays(amount) {
            let found = query::ray(
                asset,
                step.posed(),
                origin,
                direction,
                f64::INFINITY,
                &mut stack,
            );
            visits += found.map_err(refused)?.nodes_visited;
        }
        Ok(visits)
    })
}

/// A body in a step, with or without a cache.
enum Step<'s, 'p> {
    Plain(&'s Pose<'p>),
    Kept(&'s mut CachedPose<'p>),
}

impl Step<'_, '_> {
    fn posed(&mut self) -> Posed<'_> {
        match self {
            Self::Plain(pose) => (*pose).into(),
            Self::Kept(cached) => (&mut **cached).into(),
        }
    }
}

/// Prepares a pose, keeps nodes over the step where many ask, and counts visits.
fn ours(
    asset: &Asset<'_>,
    sample: &Sample,
    amount: usize,
    mut ask: impl FnMut(&Asset<'_>, &mut Step<'_, '_>) -> Result<u64, ToolError>,
) -> Result<Cost, ToolError> {
    let mut memory = vec![0.0; asset.pose_len()];
    let is_cached = amount >= CACHED;
    let slots = if is_cached { asset.node_count() } else { 0 };
    let leaves = if is_cached { LEAF_SLOTS } else { 0 };
    let mut cache = StepCache::new(vec![NodeSlot::EMPTY; slots], vec![LeafSlot::EMPTY; leaves]);
    timed(|| {
        let pose = sample.pose(asset, &mut memory)?;
        let visits = match is_cached {
            true => {
                let mut step = cache.start(&pose);
                ask(asset, &mut Step::Kept(&mut step))?
            }
            false => ask(asset, &mut Step::Plain(&pose))?,
        };
        Ok(Cost {
            visited: visits as f64 / asset.node_count().max(1) as f64,
            ..Cost::default()
        })
    })
}

fn their_balls(
    contender: &mut Contender,
    sample: &Sample,
    amount: usize,
) -> Result<Cost, ToolError> {
    let mut found: Vec<Contact> = Vec::new();
    timed(|| {
        update(contender, sample, &HERE);
        for (center, radius) in sample.balls(amount) {
            found.clear();
            let (center, radius) = (contender.point(center), radius / contender.unit);
            contender.tree.ball(center, radius, &mut found);
        }
        Ok(Cost::default())
    })
}

fn their_rays(
    contender: &mut Contender,
    sample: &Sample,
    amount: usize,
) -> Result<Cost, ToolError> {
    timed(|| {
        update(contender, sample, &HERE);
        for (origin, direction) in sample.rays(amount) {
            let origin = contender.point(origin).map(|x| x as f32);
            let direction = direction.map(|x| x as f32);
            std::hint::black_box(contender.tree.ray(origin, direction));
        }
        Ok(Cost::default())
    })
}

fn our_pair(asset: &Asset<'_>, sample: &Sample, which: usize) -> Result<Cost, ToolError> {
    let mut memory = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(asset)];
    let mut found: Vec<PairContact> = Vec::new();
    timed(|| {
        found.clear();
        let [a, b] = &mut memory;
        let a = sample.pose(asset, a)?;
        let b = sample.pose_at(asset, sample.places[which], b)?;
        let outcome = query::pair((asset, &a), (asset, &b), 0.0, &mut stack, &mut found);
        let visits = outcome.map_err(refused)?.nodes_visited;
        Ok(Cost {
            visited: visits as f64 / asset.node_count().max(1) as f64,
            amount: found.len() as f64,
            micros: 0.0,
        })
    })
}

fn their_pair(
    contender: &mut Contender,
    other: &mut Contender,
    sample: &Sample,
    which: usize,
) -> Result<Cost, ToolError> {
    let mut found: Vec<PairContact> = Vec::new();
    timed(|| {
        found.clear();
        update(contender, sample, &HERE);
        update(other, sample, &sample.places[which]);
        contender.tree.pair(&mut other.tree, &mut found);
        Ok(Cost {
            amount: found.len() as f64,
            ..Cost::default()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::{CurvePoint, break_even};

    fn points(all: &[[f64; 3]]) -> Vec<CurvePoint> {
        all.iter()
            .map(|[amount, ours, refit]| CurvePoint {
                amount: *amount,
                ours_micros: *ours,
                refit_micros: *refit,
                ratio: refit / ours,
                visited_rel: 0.0,
            })
            .collect()
    }

    #[test]
    fn break_even_is_between_the_points_around_it() {
        let at = break_even(&points(&[[1.0, 1.0, 100.0], [10.0, 10.0, 100.0]]));
        assert_eq!(at, None);
        // Ours grows with the amount, theirs does not: equal at 100.
        let at = break_even(&points(&[[10.0, 10.0, 100.0], [1000.0, 1000.0, 100.0]]));
        assert!(at.is_some_and(|x| (x - 100.0).abs() < 1e-9), "{at:?}");
        assert_eq!(break_even(&points(&[[4.0, 2.0, 1.0]])), Some(4.0));
        assert_eq!(break_even(&[]), None);
        // Noise before: the last crossing counts.
        let noisy = points(&[[1.0, 2.0, 1.0], [2.0, 1.0, 2.0], [8.0, 4.0, 2.0]]);
        assert!(break_even(&noisy).is_some_and(|x| x > 2.0 && x < 8.0));
    }
}
