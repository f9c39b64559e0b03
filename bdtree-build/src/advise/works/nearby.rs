//! What a part of the memory for refined poses does where steps ask in one place.

use std::time::Instant;

use bdtree_runtime::{
    CacheSize, Pose, Ray, RayIntersection, RefinedPose, StepCache, TriangleId, Workspace,
};
use serde::Serialize;

use super::refined::WORTH;
use super::{WorksError, least};

/// Rays of a step, all from one place, ...
const RAYS: usize = 1024;

/// ... to this share of all triangles: those nearest to the one that is nearest to the place.
const SHARE: f64 = 0.01;

/// Parts of the memory for a whole pose, one of so many each.
const PARTS: [usize; 6] = [100, 50, 20, 10, 5, 2];

/// Times that all poses are asked, one after the other, after a first one in which a cache learns where steps ask.
const ROUNDS: usize = 5;

/// What part of the memory for a refined pose is enough where steps ask in one place ([`StepCache::refining`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Nearby {
    /// Memory to grant.
    pub bytes: usize,
    /// Rays of a step.
    pub rays: usize,
    /// The share of triangles that they are cast at.
    pub share: f64,
    /// Of one ray, without.
    pub seconds: f64,
    /// With that memory, refining included.
    pub refined_seconds: f64,
}

impl Nearby {
    /// The least part with which rays take as long as with any, within what one run measures; `None` where none refines anything
    /// or saves that much. Steps have these poses, one after the other, and rays all come from one place; `bytes` are those of the
    /// whole pose.
    ///
    /// # Errors
    /// Those of queries.
    pub(super) fn measure(
        poses: &[&Pose<'_>],
        from: [f64; 3],
        bytes: usize,
    ) -> Result<Option<Self>, WorksError> {
        let steps = poses.iter().map(|pose| Ok((*pose, rays(pose, from)?)));
        let steps: Vec<(&Pose<'_>, Vec<Ray>)> = steps.collect::<Result<_, WorksError>>()?;
        let mut memory = vec![0; bytes];
        let mut times = Vec::new();
        for part in PARTS {
            let part = bytes / part;
            let granted = RefinedPose::in_bytes(&mut memory[..part]);
            let mut cache = StepCache::new(CacheSize::NONE).refining(granted);
            let seconds = seconds(&steps, &mut cache)?;
            if cache.refined_triangles() > 0 {
                times.push((part, seconds));
            }
        }
        if times.is_empty() {
            return Ok(None);
        }
        let without = seconds(&steps, &mut StepCache::new(CacheSize::NONE))?;
        let all: Vec<f64> = times.iter().map(|(_, seconds)| *seconds).collect();
        let best = least(&all);
        let enough = times
            .into_iter()
            .find(|(_, seconds)| *seconds <= (1.0 + WORTH) * best);
        let enough = enough.filter(|_| best < (1.0 - WORTH) * without);
        Ok(enough.map(|(bytes, refined_seconds)| Self {
            bytes,
            rays: RAYS,
            share: SHARE,
            seconds: without,
            refined_seconds,
        }))
    }
}

/// Rays from a place to the triangles nearest to the one that is nearest to it, in no order.
fn rays(pose: &Pose<'_>, from: [f64; 3]) -> Result<Vec<Ray>, WorksError> {
    let ids = 0..pose.asset().triangle_count() as u32;
    let middle = |id| {
        let corners = pose.deformed_triangle(TriangleId(id))?;
        let sum = |k: usize| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0;
        Ok([0, 1, 2].map(sum))
    };
    let mut middles: Vec<[f64; 3]> = ids.map(middle).collect::<Result<_, WorksError>>()?;
    let apart = |a: &[f64; 3], b: &[f64; 3]| -> f64 { (0..3).map(|k| (a[k] - b[k]).powi(2)).sum() };
    let nearest =
        (middles.iter().copied()).min_by(|a, b| apart(a, &from).total_cmp(&apart(b, &from)));
    let nearest = nearest.unwrap_or(from);
    middles.sort_by(|a, b| apart(a, &nearest).total_cmp(&apart(b, &nearest)));
    let count = (SHARE * middles.len() as f64).ceil() as usize;
    // As far apart as there are rays for, and in no order: the prime is no factor of their number.
    let used = count.clamp(1, RAYS);
    let order = (0..RAYS).map(|k| (k * 104_729) % used * count / used);
    let ways = order.filter_map(|k| middles.get(k));
    let ways = ways.map(|to| [0, 1, 2].map(|k| to[k] - from[k]));
    Ok(ways
        .filter(|way| *way != [0.0; 3])
        .map(|way| Ray::new(from, way))
        .collect())
}

/// Seconds of one ray, refining included: of each pose the least time counts.
fn seconds(steps: &[(&Pose<'_>, Vec<Ray>)], cache: &mut StepCache<'_>) -> Result<f64, WorksError> {
    let mut workspace = Workspace::new();
    let mut hits: Vec<Option<RayIntersection>> = vec![None; RAYS];
    let mut times = vec![Vec::new(); steps.len()];
    for round in 0..=ROUNDS {
        for ((pose, rays), times) in steps.iter().zip(&mut times) {
            let begin = Instant::now();
            cache.start(pose);
            let mut query = pose.query(&mut workspace).cached(cache);
            query.cast_rays(rays, &mut hits)?;
            if round > 0 {
                times.push(begin.elapsed().as_secs_f64() / rays.len().max(1) as f64);
            }
        }
    }
    let all: f64 = times.iter().map(|times| least(times)).sum();
    Ok(all / steps.len().max(1) as f64)
}
