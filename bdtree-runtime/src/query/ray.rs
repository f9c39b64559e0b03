//! The first triangle that a ray meets.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::{Nearest, SKIP, limit, point, unit};
use crate::bound::WideSpheres;
use crate::contact::{RayHit, TriangleId};
use crate::error::QueryError;
use crate::math::{add_scaled, clamp, dot, norm};
use crate::narrow::{self, Triangle, ray_hit};
use crate::pose::{Pose, U32, round_up};
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, mask_of, one};
use crate::view::Asset;

/// The first point where the ray from `origin` along `direction` (normalised first) meets a
/// triangle, at a distance from 0 to `max_distance` (which may be infinite). Triangles are
/// two-sided; those of zero area are missed; at the same distance the lowest id wins. Rays
/// through edges and vertices do not slip between triangles that share them.
///
/// # Errors
/// An origin that is not finite or beyond 2^100, a direction that is zero or not finite, a
/// negative or NaN distance, a pose of another asset, too short a stack, a corrupt asset.
pub fn ray(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<Nearest<RayHit>, QueryError> {
    let origin = point(origin, "origin: a coordinate is not finite or beyond 2^100")?;
    let direction = unit(direction, "direction: zero or not finite")?;
    let max_distance = limit(max_distance, "max_distance: negative, NaN or beyond 2^100")?;
    let frame = &pose.frame;
    let stored_per_world = 1.0 / frame.world_per_stored();
    let from = frame.point_to_stored(origin);
    let along = frame.inverse_rotate(direction);
    let t_max = max_distance * stored_per_world;
    // The ray's point nearest to the asset becomes its origin, so that f32 serves from there.
    let shift = clamp(-dot(from, along), 0.0, t_max);
    let near = add_scaled(from, shift, along);
    let error = frame.error(norm(origin), pose.reach + norm(from));
    // 32u B: rounding of origin, direction and parameter to f32 (docs/guarantees.md, rays).
    let extra = error + 32.0 * U32 * pose.reach;
    let reach = pose.reach + f64::from(pose.slack) + extra;
    if norm(near) > reach * (1.0 + 16.0 * U32) {
        return Ok(Nearest {
            hit: None,
            nodes_visited: 0,
        });
    }
    let window = 4.0 * reach;
    let mut visitor = Ray {
        near: near.map(|x| x as f32),
        along: along.map(|x| x as f32),
        t_min: -round_up(shift.min(window)),
        t_max: round_up((t_max - shift).min(window)),
        extra: round_up(extra),
        shift,
        stored_per_world,
        window,
        bound: f32::INFINITY,
        ray: narrow::Ray::new(origin, direction),
        max_distance,
        best: None,
    };
    let walk = one(asset, pose, stack, &mut visitor)?;
    Ok(Nearest {
        hit: visitor.best,
        nodes_visited: walk.nodes_visited,
    })
}

struct Ray {
    /// The shifted origin, stored units.
    near: [f32; 3],
    along: [f32; 3],
    /// Range of the parameter from `near`, stored units.
    t_min: f32,
    t_max: f32,
    extra: f32,
    /// Parameter of `near` from the ray's origin (stored units).
    shift: f64,
    stored_per_world: f64,
    window: f64,
    /// Parameter of the best hit from `near`, rounded up.
    bound: f32,
    ray: narrow::Ray,
    max_distance: f64,
    best: Option<RayHit>,
}

impl Visitor for Ray {
    const ORDERED: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        let spheres = spheres.store();
        let [ox, oy, oz] = self.near;
        let [dx, dy, dz] = self.along;
        let mut miss = [false; LANES];
        for k in 0..LANES {
            let x = spheres.centre[0][k] - ox;
            let y = spheres.centre[1][k] - oy;
            let z = spheres.centre[2][k] - oz;
            let along = x * dx + y * dy + z * dz;
            let t = along.max(self.t_min).min(self.t_max);
            let (x, y, z) = (x - t * dx, y - t * dy, z - t * dz);
            let reach = spheres.radius[k] + self.extra;
            miss[k] = (x * x + y * y + z * z) * SKIP > reach * reach;
            // Nothing in the sphere is met earlier than where its radius begins.
            keys[k] = along - reach;
        }
        mask_of(|k| !miss[k] && self.wanted(keys[k]))
    }

    #[inline(always)]
    fn wanted(&self, key: f32) -> bool {
        let beyond = key > self.bound;
        !beyond
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let Some(hit) = ray_hit(&self.ray, corners, self.max_distance) else {
            return ControlFlow::Continue(());
        };
        let better = self
            .best
            .is_none_or(|best| (hit.t, id) < (best.distance, best.triangle));
        if better {
            self.best = Some(RayHit {
                triangle: id,
                point: hit.point,
                distance: hit.t,
                barycentric: hit.barycentric,
            });
            // `extra` is in every key already and covers the errors of this subtraction.
            let t = (hit.t * self.stored_per_world - self.shift).min(self.window);
            self.bound = t as f32 + f32::EPSILON * (t.abs() as f32) + f32::MIN_POSITIVE;
        }
        ControlFlow::Continue(())
    }
}
