//! The nearest point of an asset.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::{Nearest, beyond, limit, point};
use crate::bound::WideSpheres;
use crate::contact::{ClosestPoint, TriangleId};
use crate::error::QueryError;
use crate::math::{norm, sqrt_f32};
use crate::narrow::{Triangle, closest_point};
use crate::pose::{Pose, U32, round_up};
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, mask_of, one};
use crate::view::Asset;

/// Beyond this many times the asset's reach f32 distances prune nothing and may overflow.
const FAR: f64 = (1_u64 << 30) as f64;

/// The asset's point nearest to `to`, if it is within `max_distance` (which may be infinite).
/// Triangles at the same distance: the lowest id.
///
/// # Errors
/// A point that is not finite or beyond 2^100, a negative or NaN distance, a pose of another
/// asset, too short a stack, a corrupt asset.
pub fn closest(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    to: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<Nearest<ClosestPoint>, QueryError> {
    let to = point(to, "point: a coordinate is not finite or beyond 2^100")?;
    let max_distance = limit(max_distance, "max_distance: negative, NaN or beyond 2^100")?;
    let stored = pose.frame.point_to_stored(to);
    let far = norm(stored);
    let extra = pose.frame.error(norm(to), pose.reach) + 2.0 * U32 * far;
    let mut visitor = Closest {
        stored: (far <= FAR * pose.reach).then(|| stored.map(|x| x as f32)),
        extra: round_up(extra),
        stored_per_world: 1.0 / pose.frame.world_per_stored(),
        bound: f32::INFINITY,
        to,
        max_distance,
        best: None,
    };
    visitor.tighten(max_distance);
    let walk = one(asset, pose, stack, &mut visitor)?;
    Ok(Nearest {
        hit: visitor.best,
        nodes_visited: walk.nodes_visited,
    })
}

struct Closest {
    /// `None`: too far for f32, everything is visited.
    stored: Option<[f32; 3]>,
    extra: f32,
    stored_per_world: f64,
    /// Best distance so far, rounded up (stored units).
    bound: f32,
    to: [f64; 3],
    max_distance: f64,
    best: Option<ClosestPoint>,
}

impl Closest {
    fn tighten(&mut self, distance: f64) {
        if distance.is_finite() {
            self.bound = round_up(distance * self.stored_per_world);
        }
    }
}

impl Visitor for Closest {
    const ORDERED: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        let spheres = spheres.store();
        let Some([x, y, z]) = self.stored else {
            *keys = [0.0; LANES];
            return u8::MAX;
        };
        // d (1 − 2⁻¹⁹) − R' − extra: below the exact distance of everything in the sphere.
        const SHRINK: f32 = 1.0 - 1.0 / (1 << 19) as f32;
        for k in 0..LANES {
            let dx = spheres.centre[0][k] - x;
            let dy = spheres.centre[1][k] - y;
            let dz = spheres.centre[2][k] - z;
            let gap =
                sqrt_f32(dx * dx + dy * dy + dz * dz) * SHRINK - (spheres.radius[k] + self.extra);
            keys[k] = if gap > 0.0 { gap } else { 0.0 };
        }
        mask_of(|k| self.wanted(keys[k]))
    }

    #[inline(always)]
    fn wanted(&self, key: f32) -> bool {
        let beyond = key > self.bound;
        !beyond
    }

    #[inline(always)]
    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        self.stored.is_some_and(|point| {
            beyond(
                corners,
                point,
                f64::from(self.bound) + f64::from(self.extra),
            )
        })
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let closest = closest_point(self.to, corners);
        let better = match &self.best {
            None => closest.distance <= self.max_distance,
            Some(best) => (closest.distance, id) < (best.distance, best.triangle),
        };
        if better {
            self.best = Some(ClosestPoint {
                triangle: id,
                point: closest.point,
                distance: closest.distance,
                barycentric: closest.barycentric,
            });
            self.tighten(closest.distance);
        }
        ControlFlow::Continue(())
    }
}
