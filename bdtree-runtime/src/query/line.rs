//! A ray in stored units: which spheres it meets, which triangles it certainly misses.

use bdtree_format::Row;

use super::ball::normal;
use super::{limit, point, unit};
use crate::bound::WideSpheres;
use crate::contact::{RayIntersection, TriangleId};
use crate::error::QueryError;
use crate::math::{add_scaled, clamp, dot, length_bound, scale};
use crate::narrow::{self, RayHit, Triangle, ray_hit};
use crate::pose::Pose;
use crate::refined::Boxes;
use crate::rounding::{
    ALONG_LEAST, BOX_GROWN, BOX_PARAMETER, CHORD, EDGE_FUNCTION, MARGIN, RAY, RAY_RANGE, RAY_REACH,
    SKIP, next_above, round_up,
};
use crate::shape::Ray;
use crate::simd::{Lanes, Quad};

/// A ray over one pose. Its point nearest to the asset, `near`, becomes its origin, so that f32
/// serves from there.
#[derive(Default)]
pub(super) struct Line {
    /// The ray as asked: what triangles are tested with.
    ray: narrow::PreparedRay,
    max_distance: f64,
    near: [f32; 3],
    along: [f32; 3],
    /// Range of the parameter from `near`, stored units.
    t_min: f32,
    t_max: f32,
    extra: f32,
    /// Parameter of `near` from the ray's origin (stored units).
    pub(super) shift: f64,
    pub(super) stored_per_world: f64,
    /// Parameters farther from `near` mean nothing.
    window: f64,
    sieve: Sieve,
    slabs: Slabs,
}

impl Line {
    /// `None` when the ray certainly misses the whole asset. With `has_boxes`, [`Line::boxes`] may be asked.
    ///
    /// # Errors
    /// An origin that is not finite or beyond 2^100, a direction that is zero or not finite, a
    /// negative or NaN distance.
    #[inline(always)] // a result that is as large is copied
    pub(super) fn new(
        pose: &Pose<'_>,
        ray: &Ray,
        has_boxes: bool,
    ) -> Result<Option<Self>, QueryError> {
        let origin = point(
            ray.origin,
            "origin: a coordinate is not finite or beyond 2^100",
        )?;
        let direction = unit(ray.direction, "direction: zero or not finite")?;
        let max_distance = limit(ray.max_distance)?;
        let frame = &pose.placement;
        let stored_per_world = 1.0 / frame.world_per_stored();
        let from = frame.point_to_stored(origin);
        let along = frame.inverse_rotate(direction);
        let t_max = max_distance * stored_per_world;
        let shift = clamp(-dot(from, along), 0.0, t_max);
        let near = add_scaled(from, shift, along);
        let error = frame.error(length_bound(origin), pose.reach + length_bound(from));
        // 32u B: rounding of origin, direction and parameter to f32 (docs/design/guarantees.md, rays).
        let extra = error + RAY * pose.reach;
        let reach = pose.reach + f64::from(pose.slack) + extra;
        let far = reach * RAY_REACH;
        if dot(near, near) > far * far {
            return Ok(None);
        }
        let window = 4.0 * reach;
        let (t_min, t_max) = (-shift.min(window), (t_max - shift).min(window));
        let near32 = [near[0] as f32, near[1] as f32, near[2] as f32];
        let along32 = [along[0] as f32, along[1] as f32, along[2] as f32];
        let slabs = if has_boxes {
            Slabs::new(near32, along32, extra, reach)
        } else {
            Slabs::default()
        };
        Ok(Some(Self {
            ray: narrow::PreparedRay::new(origin, direction),
            max_distance,
            near: near32,
            along: along32,
            slabs,
            t_min: -round_up(-t_min),
            t_max: round_up(t_max),
            extra: round_up(extra),
            shift,
            stored_per_world,
            window,
            sieve: Sieve::new(near, along, [t_min, t_max], error, reach),
        }))
    }

    /// The lanes that the ray may meet, and for each a lower bound of the parameter where it does.
    #[inline(always)]
    pub(super) fn lanes<L: Lanes>(&self, spheres: &WideSpheres<L>, keys: &mut Row) -> u8 {
        let [dx, dy, dz] = self.along;
        let (dx, dy, dz) = (L::splat(dx), L::splat(dy), L::splat(dz));
        let x = spheres.center[0].sub(L::splat(self.near[0]));
        let y = spheres.center[1].sub(L::splat(self.near[1]));
        let z = spheres.center[2].sub(L::splat(self.near[2]));
        let along = x.mul(dx).add(y.mul(dy)).add(z.mul(dz));
        let t = along.max(L::splat(self.t_min)).min(L::splat(self.t_max));
        let (x, y, z) = (x.sub(t.mul(dx)), y.sub(t.mul(dy)), z.sub(t.mul(dz)));
        let extra = L::splat(self.extra);
        let reach = spheres.radius.add(extra);
        let apart = x.mul(x).add(y.mul(y)).add(z.mul(z)).mul(L::splat(SKIP));
        let squared = reach.mul(reach);
        // Where the chord of the sphere begins, or earlier: half of it is √(reach² − d²).
        let half = squared.mul(L::splat(CHORD)).sub(apart).sqrt();
        *keys = t.sub(half).sub(extra).store();
        !apart.above(squared)
    }

    /// The boxes that the ray may meet up to a key, and for each a lower bound of the parameter where it does: its key.
    #[inline(always)]
    pub(super) fn boxes<L: Lanes>(&self, boxes: &Boxes, key_max: f32, keys: &mut Row) -> u8 {
        let Slabs {
            per_along,
            enter,
            leave,
            is_backward,
            slack,
        } = &self.slabs;
        let mut first = L::splat(self.t_min);
        let mut last = L::splat(self.t_max.min(key_max));
        for k in 0..3 {
            let (near, far) = if is_backward[k] {
                (&boxes.high[k], &boxes.low[k])
            } else {
                (&boxes.low[k], &boxes.high[k])
            };
            let per_along = L::splat(per_along[k]);
            first = first.max(L::load(near).sub(L::splat(enter[k])).mul(per_along));
            last = last.min(L::load(far).sub(L::splat(leave[k])).mul(per_along));
        }
        let first = first.sub(L::splat(*slack));
        *keys = first.store();
        !first.above(last)
    }

    /// The triangles, of four, that the ray certainly misses up to the best hit so far.
    #[inline(always)]
    pub(super) fn misses<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        self.sieve.misses::<Q>(corners)
    }

    /// Where the ray meets a triangle, by the leaf arithmetic.
    #[inline(always)]
    pub(super) fn hit(&self, corners: &Triangle) -> Option<RayHit> {
        ray_hit(&self.ray, corners, self.max_distance)
    }

    /// A hit with the triangle's unit normal on the side that the ray comes from.
    #[inline(always)]
    pub(super) fn intersection(
        &self,
        triangle: TriangleId,
        corners: &Triangle,
        hit: &RayHit,
    ) -> RayIntersection {
        let mut normal = normal(corners);
        if dot(normal, self.ray.direction()) > 0.0 {
            normal = scale(normal, -1.0);
        }
        RayIntersection {
            triangle,
            point: hit.point,
            normal,
            distance: hit.t,
            barycentric: hit.barycentric,
        }
    }

    /// What nothing at a key is met before (world).
    pub(super) fn distance(&self, key: f32) -> f64 {
        let key = f64::from(key);
        let t = key + self.shift - MARGIN * (key.abs() + self.shift);
        // Both infinite: nothing is known.
        if t > 0.0 {
            t / self.stored_per_world
        } else {
            0.0
        }
    }

    /// The parameter of a hit at this distance, rounded up: what keys are compared with. Nothing
    /// beyond it is asked for any more.
    pub(super) fn shorten(&mut self, distance: f64) -> f32 {
        // `extra` is in every key already and covers the errors of this subtraction.
        let t = (distance * self.stored_per_world - self.shift).min(self.window);
        self.sieve.shorten(t);
        next_above(t)
    }
}

/// The ray for boxes: where it enters and leaves the slab between two planes across an axis, both moved outwards by all errors
/// (docs/design/guarantees.md, where a ray enters a box).
#[derive(Default)]
struct Slabs {
    /// 1 / d of each axis.
    per_along: [f32; 3],
    /// What planes are compared with: `near` moved along or against the ray.
    enter: [f32; 3],
    leave: [f32; 3],
    /// Whether it enters through the higher plane.
    is_backward: [bool; 3],
    /// Of the parameter.
    slack: f32,
}

impl Slabs {
    fn new(near: [f32; 3], along: [f32; 3], extra: f64, reach: f64) -> Self {
        let grown = round_up(extra + BOX_GROWN * reach);
        let mut slabs = Self {
            slack: round_up(extra + BOX_PARAMETER * reach),
            ..Self::default()
        };
        for k in 0..3 {
            // By the sign, without a branch: it cannot be foreseen.
            slabs.is_backward[k] = along[k].is_sign_negative();
            let grown = grown.copysign(along[k]);
            // So slow across the slab that within the window it moves by less than the slab has grown.
            let along = along[k].abs().max(ALONG_LEAST).copysign(along[k]);
            slabs.per_along[k] = 1.0 / along;
            (slabs.enter[k], slabs.leave[k]) = (near[k] + grown, near[k] - grown);
        }
        slabs
    }
}

/// The shear of [`narrow::ray_hit`] in stored units, without its exactness: four triangles at once
/// by the signs of their edge functions, with a margin (docs/design/guarantees.md, rays).
#[derive(Default)]
struct Sieve {
    /// The coordinate of largest |direction| comes last.
    axes: [usize; 3],
    /// d_x / d_z, d_y / d_z and 1 / d_z in that order of axes.
    shear: [f64; 3],
    /// What `near` becomes: subtracted.
    offset: [f64; 3],
    /// Range of the parameter, grown by all errors.
    range: [f64; 2],
    /// Edge functions up to this may be 0.
    edge: f64,
    /// What the range was grown by.
    grown: f64,
}

impl Sieve {
    fn new(near: [f64; 3], along: [f64; 3], range: [f64; 2], error: f64, reach: f64) -> Self {
        let [x, y, z] = [along[0].abs(), along[1].abs(), along[2].abs()];
        let axes = if z >= x && z >= y {
            [0, 1, 2]
        } else if y >= x {
            [2, 0, 1]
        } else {
            [1, 2, 0]
        };
        let d = [along[axes[0]], along[axes[1]], along[axes[2]]];
        let p = [near[axes[0]], near[axes[1]], near[axes[2]]];
        let per_depth = 1.0 / d[2];
        let shear = [d[0] * per_depth, d[1] * per_depth, per_depth];
        let grown = RAY_RANGE * error;
        Self {
            axes,
            shear,
            offset: [
                p[0] - shear[0] * p[2],
                p[1] - shear[1] * p[2],
                shear[2] * p[2],
            ],
            range: [range[0] - grown, range[1] + grown],
            edge: EDGE_FUNCTION * error * reach,
            grown,
        }
    }

    fn shorten(&mut self, t: f64) {
        self.range[1] = t + self.grown;
    }

    /// A triangle is missed when its sheared corners leave the axis outside, or all are before or
    /// behind the range. NaN is not missed.
    #[inline(always)]
    fn misses<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        let shear = [Q::splat(self.shear[0]), Q::splat(self.shear[1])];
        let offset = [Q::splat(self.offset[0]), Q::splat(self.offset[1])];
        let zero = Q::splat(0.0);
        let mut across = [[zero; 2]; 3];
        let mut depth = [zero; 3];
        for i in 0..3 {
            let z = Q::widen(&corners[i][self.axes[2]]);
            for k in 0..2 {
                let x = Q::widen(&corners[i][self.axes[k]]);
                across[i][k] = x.sub(shear[k].mul(z)).sub(offset[k]);
            }
            depth[i] = z.mul(Q::splat(self.shear[2])).sub(Q::splat(self.offset[2]));
        }
        let [a, b, c] = across;
        let edges = [det2(b, c), det2(c, a), det2(a, b)];
        let (low, high) = (Q::splat(-self.edge), Q::splat(self.edge));
        let right = Q::either(
            Q::either(low.above(edges[0]), low.above(edges[1])),
            low.above(edges[2]),
        );
        let left = Q::either(
            Q::either(edges[0].above(high), edges[1].above(high)),
            edges[2].above(high),
        );
        let (first, last) = (Q::splat(self.range[0]), Q::splat(self.range[1]));
        let before = Q::both(
            Q::both(first.above(depth[0]), first.above(depth[1])),
            first.above(depth[2]),
        );
        let behind = Q::both(
            Q::both(depth[0].above(last), depth[1].above(last)),
            depth[2].above(last),
        );
        Q::bits(Q::either(Q::both(left, right), Q::either(before, behind)))
    }
}

#[inline(always)]
fn det2<Q: Quad>(a: [Q; 2], b: [Q; 2]) -> Q {
    a[0].mul(b[1]).sub(a[1].mul(b[0]))
}
