//! The triangles that reach into a half-space.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::{ARGUMENT_MAX, unit};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{Contact, Sink, TriangleId};
use crate::error::QueryError;
use crate::math::{dot, norm};
use crate::narrow::Triangle;
use crate::pose::Pose;
use crate::rounding::{PLANE_HEIGHT, POINT, round_up};
use crate::shape;
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, Walk, one};

/// Reports every triangle with a vertex in the half-space: `point` is its deepest vertex (the first of
/// equals), `distance` that vertex's height above the plane, `normal` from there into the half-space.
///
/// # Errors
/// A normal that is zero or not finite, an offset that is not finite or beyond 2^100, a corrupt asset.
pub(super) fn contacts(
    posed: Posed<'_>,
    half_space: &shape::HalfSpace,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<Contact>,
) -> Result<Walk, QueryError> {
    let pose = posed.pose;
    let normal = unit(half_space.normal, "normal: zero or not finite")?;
    let offset = half_space.offset;
    if !(offset.abs() <= ARGUMENT_MAX) {
        return Err(QueryError::Argument("offset: not finite or beyond 2^100"));
    }
    let mut visitor = HalfSpace {
        stored: StoredPlane::new(pose, normal, offset),
        normal,
        offset,
        sink,
    };
    one(posed, stack, &mut visitor)
}

/// A plane among the spheres of a body: points where `normal · x = offset` (stored units).
#[derive(Debug, Clone, Copy)]
pub(super) struct StoredPlane {
    normal: [f32; 3],
    offset: f32,
    /// What heights of centers may be off by, besides what their spheres' slack covers.
    pub(super) extra: f32,
}

impl StoredPlane {
    /// The world plane `normal · x = offset`, `normal` being unit.
    pub(super) fn new(pose: &Pose<'_>, normal: [f64; 3], offset: f64) -> Self {
        let frame = &pose.placement;
        // n·x = n·o + k (n_s·p'), o the stored origin's world position, k world per stored unit.
        let origin = frame.origin_in_world();
        let stored_offset = (offset - dot(normal, origin)) / frame.world_per_stored();
        let error = frame.error(offset.abs() + norm(origin), pose.reach);
        // Beyond twice the reach an offset decides alone; clamping keeps its f32 rounding small.
        let far = 2.0 * pose.reach + 2.0 * error + 1.0;
        let stored_offset = stored_offset.clamp(-far, far);
        let extra = error + PLANE_HEIGHT * pose.reach + POINT * stored_offset.abs();
        Self {
            normal: frame.inverse_rotate(normal).map(|x| x as f32),
            offset: stored_offset as f32,
            extra: round_up(extra),
        }
    }

    /// Heights of the spheres' centers above the plane.
    #[inline(always)]
    pub(super) fn heights<L: Lanes>(&self, spheres: &WideSpheres<L>) -> L {
        let [x, y, z] = spheres.center;
        let [nx, ny, nz] = self.normal;
        x.mul(L::splat(nx))
            .add(y.mul(L::splat(ny)))
            .add(z.mul(L::splat(nz)))
            .sub(L::splat(self.offset))
    }
}

struct HalfSpace<'s> {
    stored: StoredPlane,
    normal: [f64; 3],
    offset: f64,
    sink: &'s mut (dyn Sink<Contact> + 's),
}

impl Visitor for HalfSpace<'_> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, _keys: &mut Row) -> u8 {
        let height = self.stored.heights(&spheres);
        !height.above(spheres.radius.add(L::splat(self.stored.extra)))
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let heights = corners.map(|x| dot(self.normal, x) - self.offset);
        let deepest = (1..3).fold(0, |d, i| if heights[i] < heights[d] { i } else { d });
        // Compared as the documentation writes it, not as height ≤ 0, which rounds once more.
        if !(dot(self.normal, corners[deepest]) <= self.offset) {
            return ControlFlow::Continue(());
        }
        let mut barycentric = [0.0; 3];
        barycentric[deepest] = 1.0;
        self.sink.push(Contact {
            triangle: id,
            point: corners[deepest],
            normal: self.normal.map(|n| -n),
            distance: heights[deepest],
            barycentric,
        })
    }
}
