//! What is asked of an asset at one q: the same questions in every run.

use bdtree_build::advise::samples::Samples;
use bdtree_build::advise::works::BALL_RADIUS_REL;
use bdtree_runtime::{Asset, Pose, Transform, TriangleId};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::depth::HERE;
use super::{pose_refused, problem};
use crate::error::ToolError;

/// Surface points per sample that questions are about: more questions ask about them again.
const POINTS: usize = 512;

/// Radius of the balls of [`Sample::balls`] over that of [`Sample::ball`].
pub(super) const SMALL_BALL: f64 = 0.2;

/// How far apart two instances stand, over the body's longest extent: from beside each other to deep inside.
const APART: [f64; 8] = [1.1, 0.98, 0.9, 0.8, 0.65, 0.5, 0.3, 0.1];

/// An asset at a q, and what is asked about it (world coordinates are the mesh's).
pub(super) struct Sample {
    pub(super) q: Vec<f32>,
    /// Centre and radius of the ball that levels are compared with.
    pub(super) ball: ([f64; 3], f64),
    /// Where a second instance stands, nearer each time.
    pub(super) places: Vec<Transform>,
    /// Points of the deformed surface.
    points: Vec<[f64; 3]>,
    /// Where rays come from, one for each point.
    origins: Vec<[f64; 3]>,
}

impl Sample {
    /// One for every q of `samples`; `bounds` is the box of the mesh at rest.
    pub(super) fn all(
        asset: &Asset<'_>,
        samples: &Samples,
        bounds: [[f64; 3]; 2],
    ) -> Result<Vec<Self>, ToolError> {
        let mut memory = vec![0.0; asset.pose_len()];
        (0..samples.len())
            .map(|k| Self::new(asset, samples.q(k), k as u64, bounds, &mut memory))
            .collect()
    }

    fn new(
        asset: &Asset<'_>,
        q: &[f32],
        seed: u64,
        [low, high]: [[f64; 3]; 2],
        memory: &mut [f32],
    ) -> Result<Self, ToolError> {
        let pose = Pose::new(asset, q, HERE, memory).map_err(|e| pose_refused(&e))?;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let extent = [0, 1, 2].map(|k| high[k] - low[k]);
        let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let diagonal = extent.iter().map(|x| x * x).sum::<f64>().sqrt();
        let count = asset.triangle_count() as u32;
        let mut points = Vec::with_capacity(POINTS);
        let mut origins = Vec::with_capacity(POINTS);
        for _ in 0..POINTS {
            let id = TriangleId(random.random_range(0..count));
            let corners = asset.triangle(id).map_err(problem)?;
            let mut point = [0.0; 3];
            for corner in corners {
                let p = asset.deformed(&pose, corner).map_err(problem)?;
                point = [0, 1, 2].map(|k| point[k] + p[k] / 3.0);
            }
            points.push(point);
            let mut direction = [0.0; 3];
            let mut size = 0.0;
            // Evenly over all directions: those in the ball are, by rejection.
            while !(1e-3..=1.0).contains(&size) {
                direction = [0; 3].map(|_| random.random_range(-1.0..1.0));
                size = direction.iter().map(|x: &f64| x * x).sum();
            }
            let far = diagonal.max(f64::MIN_POSITIVE) / size.sqrt();
            origins.push([0, 1, 2].map(|k| middle[k] + far * direction[k]));
        }
        let radius = BALL_RADIUS_REL * diagonal;
        let first = points.first().copied().unwrap_or(middle);
        // Up to 1.7 radii off a point of the surface: deep inside, barely touching, or apart.
        let center = [0, 1, 2].map(|k| first[k] + radius * random.random_range(-1.0..1.0));
        Ok(Self {
            q: q.to_vec(),
            ball: (center, radius),
            places: places(middle, extent),
            points,
            origins,
        })
    }

    /// Its pose where the mesh stands.
    pub(super) fn pose<'m>(
        &self,
        asset: &Asset<'_>,
        memory: &'m mut [f32],
    ) -> Result<Pose<'m>, ToolError> {
        self.pose_at(asset, HERE, memory)
    }

    /// Its pose at a placement.
    pub(super) fn pose_at<'m>(
        &self,
        asset: &Asset<'_>,
        place: Transform,
        memory: &'m mut [f32],
    ) -> Result<Pose<'m>, ToolError> {
        Pose::new(asset, &self.q, place, memory).map_err(|e| pose_refused(&e))
    }

    /// So many balls about points of the surface, [`SMALL_BALL`] as large as the one.
    pub(super) fn balls(&self, amount: usize) -> impl Iterator<Item = ([f64; 3], f64)> {
        let radius = SMALL_BALL * self.ball.1;
        let points = self.points.iter().cycle().take(amount);
        points.map(move |p| (*p, radius))
    }

    /// So many rays, origin and unit direction, from around the body to points of its surface.
    pub(super) fn rays(&self, amount: usize) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
        // Past the last point, other origins meet other points.
        let shift = |i: usize| (i + i / POINTS) % POINTS;
        (0..amount).map(move |i| {
            let (from, to) = (self.origins[shift(i)], self.points[i % POINTS]);
            let along = [0, 1, 2].map(|k| to[k] - from[k]);
            let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            (from, along.map(|x| x / length))
        })
    }
}

/// Beside the body along its longest extent, turned a little about its own middle.
fn places(middle: [f64; 3], extent: [f64; 3]) -> Vec<Transform> {
    let axis = (0..3).fold(0, |a, b| if extent[b] > extent[a] { b } else { a });
    // About 7 degrees around a slanted axis.
    let rotation = [0.03, 0.04, 0.035, 1.0];
    let norm = rotation.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
    let rotation = rotation.map(|x| x / norm);
    let rows = bdtree_baselines::place::matrix(rotation);
    let turned = rows.map(|row| (0..3).map(|k| row[k] * middle[k]).sum::<f64>());
    let place = |apart: &f64| {
        let mut translation = [0, 1, 2].map(|k| middle[k] - turned[k]);
        translation[axis] += apart * extent[axis];
        Transform {
            rotation,
            translation,
            scale: 1.0,
        }
    };
    APART.iter().map(place).collect()
}
