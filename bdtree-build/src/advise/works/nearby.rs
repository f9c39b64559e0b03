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

#[cfg(test)]
mod tests {
    use bdtree_runtime::{Asset, Model, Transform};

    use super::*;
    use crate::basis::Basis;
    use crate::input::RawMesh;
    use crate::pipeline::{BakeSettings, Provenance, bake_fields};
    use crate::progress::Silent;

    /// A flat sheet from (0, 0) to (1, 1) of twice n × n triangles.
    fn sheet(n: u32) -> Model {
        let side = n + 1;
        let at = |k: u32| f64::from(k) / f64::from(n);
        let corner = |i: u32, j: u32| i * side + j;
        let each = |i: u32, j: u32| {
            let [a, b] = [corner(i, j), corner(i + 1, j)];
            [[a, b, a + 1], [b, b + 1, a + 1]]
        };
        let mesh = RawMesh {
            positions: (0..side)
                .flat_map(|i| (0..side).map(move |j| [at(i), at(j), 0.0]))
                .collect(),
            triangles: (0..n)
                .flat_map(|i| (0..n).flat_map(move |j| each(i, j)))
                .collect(),
            ..RawMesh::default()
        };
        let basis = Basis {
            vertex_count: mesh.positions.len(),
            ..Basis::default()
        };
        let settings = BakeSettings::default();
        let baked = bake_fields(&mesh, &basis, &settings, &Provenance::default(), &Silent);
        Model::from_bytes(&baked.expect("a sound mesh").bytes).expect("a sound file")
    }

    fn posed(asset: &Asset<'_>, check: impl FnOnce(&Pose<'_>)) {
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(&[], Transform::IDENTITY, &mut memory);
        check(&pose.expect("a pose"));
    }

    #[test]
    fn rays_hit_the_nearest_hundredth() {
        // Fewer triangles in reach than rays, and more.
        for n in [20, 80, 300] {
            posed(sheet(n).asset(), |pose| {
                let from = [0.2, 0.7, 1.0];
                let rays = rays(pose, from).expect("rays");
                assert_eq!(rays.len(), RAYS);
                let mut workspace = Workspace::new();
                let mut met = std::collections::BTreeSet::new();
                for ray in &rays {
                    let hit = pose.query(&mut workspace).cast_ray(ray);
                    let hit = hit.expect("an answer").expect("a hit");
                    met.insert(hit.triangle);
                    // A hundredth of the area is a disc of radius 0.056.
                    let way = (hit.point[0] - 0.2).hypot(hit.point[1] - 0.7);
                    assert!(way < 0.057 + 2.0 / f64::from(n), "{n}: {way}");
                }
                let all = (SHARE * f64::from(2 * n * n)).ceil() as usize;
                assert_eq!(met.len(), all.min(RAYS), "each is met");
            });
        }
    }

    #[test]
    fn a_part_is_named_only_where_parts_are_refined() {
        // Too few triangles.
        posed(sheet(20).asset(), |pose| {
            let bytes = RefinedPose::bytes_for(pose.asset()).expect("a size");
            let found = Nearby::measure(&[pose], [0.2, 0.7, 1.0], bytes);
            assert_eq!(found.expect("times"), None);
        });
        posed(sheet(120).asset(), |pose| {
            let bytes = RefinedPose::bytes_for(pose.asset()).expect("a size");
            let found = Nearby::measure(&[pose; 3], [0.2, 0.7, 1.0], bytes);
            // Times decide whether one is.
            if let Some(near) = found.expect("times") {
                assert!(PARTS.iter().any(|part| near.bytes == bytes / part));
                assert!(near.refined_seconds > 0.0 && near.refined_seconds < near.seconds);
            }
        });
    }
}
