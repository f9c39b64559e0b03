//! The triangles within a capsule.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::ball::{direction, normal};
use super::{length, point};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{Contact, Sink, TriangleId};
use crate::error::QueryError;
use crate::math::{add_scaled, clamp, dot, norm, scale, sqrt, sub};
use crate::narrow::{Triangle, segment_triangle_distance};
use crate::pose::Pose;
use crate::rounding::{CUT_TO_REACH, MARGIN, SKIP, round_up};
use crate::shape;
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, Walk, one};

/// Reports every triangle whose distance to the segment is at most the radius: `distance` is distance
/// minus radius (≤ 0), `point` the triangle's nearest point, `normal` from there to the segment's nearest
/// point (the triangle's own normal where the two touch). A segment of length 0 makes it a ball.
///
/// # Errors
/// An end or radius that is not finite or beyond 2^100, a negative radius, a corrupt asset.
pub(super) fn contacts(
    posed: Posed<'_>,
    capsule: &shape::Capsule,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<Contact>,
) -> Result<Walk, QueryError> {
    let pose = posed.pose;
    let a = point(capsule.a, "a: a coordinate is not finite or beyond 2^100")?;
    let b = point(capsule.b, "b: a coordinate is not finite or beyond 2^100")?;
    let radius = length(
        capsule.radius,
        "radius: negative, not finite or beyond 2^100",
    )?;
    let Some(near) = NearSegment::new(pose, [a, b], radius) else {
        return Ok(Walk::default());
    };
    let mut visitor = Capsule {
        near,
        segment: [a, b],
        radius,
        sink,
    };
    one(posed, stack, &mut visitor)
}

/// The part of a segment that a body can be near to (stored units).
#[derive(Clone, Copy)]
struct NearSegment {
    from: [f32; 3],
    /// Unit, or zero for a point.
    along: [f32; 3],
    length: f32,
    /// The radius and all errors but those that the spheres' slack covers.
    reach: f32,
}

impl NearSegment {
    /// Nothing where no point of the body is within `radius` of the segment. So a segment may be
    /// as long as you like: what is left of it is not longer than the body and the capsule's
    /// radius make it, and f32 serves.
    fn new(pose: &Pose<'_>, ends: [[f64; 3]; 2], radius: f64) -> Option<Self> {
        let frame = &pose.placement;
        let radius = radius / frame.world_per_stored();
        let world = norm(ends[0]) + norm(ends[1]) + radius * frame.world_per_stored();
        let error = frame.error(world, pose.reach);
        let [from, to] = ends.map(|x| frame.point_to_stored(x));
        let whole = sub(to, from);
        let length = norm(whole);
        let along = if length > 0.0 {
            scale(whole, 1.0 / length)
        } else {
            [0.0; 3]
        };
        // The chord of a ball that holds whatever is within the radius of the body.
        let around = pose.reach + f64::from(pose.slack) + radius + 2.0 * error;
        let around = around * (1.0 + MARGIN);
        let middle = -dot(from, along);
        let apart = norm(add_scaled(from, middle, along));
        if !(apart <= around) {
            return None;
        }
        let half = sqrt(around * around - apart * apart);
        let (start, end) = ((middle - half).max(0.0), (middle + half).min(length));
        if start > end {
            return None;
        }
        // 32 u: start, direction, length and parameter in f32, of numbers up to twice `around`.
        let reach = radius + error + CUT_TO_REACH * around;
        Some(Self {
            from: add_scaled(from, start, along).map(|x| x as f32),
            along: along.map(|x| x as f32),
            length: round_up(end - start),
            reach: round_up(reach),
        })
    }

    /// The lanes that are not certainly farther than `reach`.
    #[inline(always)]
    fn within<L: Lanes>(&self, spheres: &WideSpheres<L>) -> u8 {
        let [dx, dy, dz] = [
            L::splat(self.along[0]),
            L::splat(self.along[1]),
            L::splat(self.along[2]),
        ];
        let x = spheres.center[0].sub(L::splat(self.from[0]));
        let y = spheres.center[1].sub(L::splat(self.from[1]));
        let z = spheres.center[2].sub(L::splat(self.from[2]));
        let along = x.mul(dx).add(y.mul(dy)).add(z.mul(dz));
        let t = along.max(L::splat(0.0)).min(L::splat(self.length));
        let (x, y, z) = (x.sub(t.mul(dx)), y.sub(t.mul(dy)), z.sub(t.mul(dz)));
        let squared = x.mul(x).add(y.mul(y)).add(z.mul(z));
        let reach = spheres.radius.add(L::splat(self.reach));
        !squared.mul(L::splat(SKIP)).above(reach.mul(reach))
    }

    /// Whether a triangle (stored units) is certainly farther than `reach`: along the direction
    /// from the segment to the corners' mean all corners are beyond all of the segment by that
    /// much. Anything not proved is not, NaN included.
    #[inline(always)]
    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        let from = self.from.map(f64::from);
        let along = self.along.map(f64::from);
        let length = f64::from(self.length);
        let reach = f64::from(self.reach);
        let mut d = [[0.0; 3]; 3];
        let mut mean = [0.0; 3];
        for i in 0..3 {
            d[i] = sub(corners[i].map(f64::from), from);
            mean = add_scaled(mean, 1.0 / 3.0, d[i]);
        }
        let t = clamp(dot(mean, along), 0.0, length);
        let n = add_scaled(mean, -t, along);
        // The farthest that the segment reaches along n from its start.
        let ahead = (dot(n, along) * length).max(0.0);
        let size = |v: [f64; 3]| (v[0] * n[0]).abs() + (v[1] * n[1]).abs() + (v[2] * n[2]).abs();
        let ahead = ahead + MARGIN * length * size(along);
        let limit = reach * reach * dot(n, n) * (1.0 + MARGIN);
        let mut misses = true;
        for d in d {
            let low = dot(d, n) - MARGIN * size(d) - ahead;
            misses &= (low > 0.0) & (low * low > limit);
        }
        misses
    }
}

struct Capsule<'s> {
    near: NearSegment,
    segment: [[f64; 3]; 2],
    radius: f64,
    sink: &'s mut (dyn Sink<Contact> + 's),
}

impl Visitor for Capsule<'_> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, _keys: &mut Row) -> u8 {
        self.near.within(&spheres)
    }

    #[inline(always)]
    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        self.near.misses(corners)
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let nearest = segment_triangle_distance(&self.segment, corners);
        if nearest.distance > self.radius {
            return ControlFlow::Continue(());
        }
        // Touching points are equal but for rounding, which is no direction.
        let towards = (nearest.distance > 0.0)
            .then(|| direction(nearest.on_triangle, nearest.on_segment))
            .flatten();
        self.sink.push(Contact {
            triangle: id,
            point: nearest.on_triangle,
            normal: towards.unwrap_or_else(|| normal(corners)),
            distance: nearest.distance - self.radius,
            barycentric: nearest.barycentric,
        })
    }
}
