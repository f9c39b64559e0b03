//! The nearest point of an asset.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::ball::{direction, normal};
use super::{beyond_four, limit, point};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{PointProjection, TriangleId};
use crate::error::QueryError;
use crate::math::norm;
use crate::narrow::{Triangle, closest_point};
use crate::pose::Pose;
use crate::refined::Boxes;
use crate::rounding::{GAP_DISTANCE, POINT, round_up};
use crate::simd::{Lanes, Quad};
use crate::traverse::{StackEntry, Visitor, Walk, one};

/// Beyond this many times the asset's reach f32 distances prune nothing and may overflow.
const FAR: f64 = (1_u64 << 30) as f64;

/// The point of the deformed mesh nearest to `to`, if it is within `max_distance` (which may be infinite).
/// Triangles at the same distance: the lowest id.
///
/// # Errors
/// A point that is not finite or beyond 2^100, a negative or NaN distance, a corrupt asset.
pub(super) fn project(
    posed: Posed<'_>,
    to: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<(Option<PointProjection>, Walk), QueryError> {
    let pose = posed.pose;
    let mut visitor = Closest::new(pose, to, max_distance)?;
    let walk = one(posed, stack, &mut visitor)?;
    Ok((visitor.projection(pose)?, walk))
}

pub(super) struct Closest {
    /// `None`: too far for f32, everything is visited.
    stored: Option<[f32; 3]>,
    extra: f32,
    pub(super) stored_per_world: f64,
    /// Best distance so far, rounded up (stored units).
    pub(super) bound: f32,
    to: [f64; 3],
    max_distance: f64,
    pub(super) best: Option<PointProjection>,
}

impl Closest {
    pub(super) fn new(
        pose: &Pose<'_>,
        to: [f64; 3],
        max_distance: f64,
    ) -> Result<Self, QueryError> {
        let to = point(to, "point: a coordinate is not finite or beyond 2^100")?;
        let max_distance = limit(max_distance)?;
        let stored = pose.placement.point_to_stored(to);
        let far = norm(stored);
        let extra = pose.placement.error(norm(to), pose.reach) + POINT * far;
        let mut closest = Self {
            stored: (far <= FAR * pose.reach).then(|| stored.map(|x| x as f32)),
            extra: round_up(extra),
            stored_per_world: 1.0 / pose.placement.world_per_stored(),
            bound: f32::INFINITY,
            to,
            max_distance,
            best: None,
        };
        closest.tighten(max_distance);
        Ok(closest)
    }

    /// The best one, with its normal.
    pub(super) fn projection(
        &self,
        pose: &Pose<'_>,
    ) -> Result<Option<PointProjection>, QueryError> {
        let Some(best) = self.best else {
            return Ok(None);
        };
        let normal = match direction(best.point, self.to) {
            Some(away) => away,
            None => normal(&pose.deformed_triangle(best.triangle)?),
        };
        Ok(Some(PointProjection { normal, ..best }))
    }

    /// The lanes whose `distance` less `reach` does not exceed the bound.
    #[inline(always)]
    fn keep<L: Lanes>(&self, distance: L, reach: L, keys: &mut Row) -> u8 {
        let gap = distance
            .mul(L::splat(GAP_DISTANCE))
            .sub(reach)
            .max(L::splat(0.0));
        *keys = gap.store();
        !gap.above(L::splat(self.bound))
    }

    fn tighten(&mut self, distance: f64) {
        if distance.is_finite() {
            self.bound = round_up(distance * self.stored_per_world);
        }
    }
}

impl Visitor for Closest {
    const ORDERED: bool = true;
    const HAS_BOXES: bool = true;
    // Far fewer boxes are visited than spheres.
    const NODE_GAIN: u64 = 9;
    const OF_SPHERES: u8 = 11;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        let Some([x, y, z]) = self.stored else {
            *keys = [0.0; LANES];
            return u8::MAX;
        };
        // d (1 − 2⁻¹⁹) − R' − extra: below the exact distance of everything in the sphere.
        let dx = spheres.center[0].sub(L::splat(x));
        let dy = spheres.center[1].sub(L::splat(y));
        let dz = spheres.center[2].sub(L::splat(z));
        let distance = dx.mul(dx).add(dy.mul(dy)).add(dz.mul(dz)).sqrt();
        let reach = spheres.radius.add(L::splat(self.extra));
        self.keep(distance, reach, keys)
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, boxes: &Boxes, keys: &mut Row) -> u8 {
        let Some(point) = self.stored else {
            *keys = [0.0; LANES];
            return u8::MAX;
        };
        let distance = boxes.squared_distances::<L>(point).sqrt();
        self.keep(distance, L::splat(self.extra), keys)
    }

    #[inline(always)]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        let Some(point) = self.stored else {
            return 0;
        };
        let reach = f64::from(self.bound) + f64::from(self.extra);
        beyond_four::<Q>(corners, point, reach)
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let closest = closest_point(self.to, corners);
        let better = match &self.best {
            None => closest.distance <= self.max_distance,
            Some(best) => (closest.distance, id) < (best.distance, best.triangle),
        };
        if better {
            self.best = Some(PointProjection {
                triangle: id,
                point: closest.point,
                normal: [0.0; 3], // of the last one only
                distance: closest.distance,
                barycentric: closest.barycentric,
            });
            self.tighten(closest.distance);
        }
        ControlFlow::Continue(())
    }
}
