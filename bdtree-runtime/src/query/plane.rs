//! The triangles that reach below a plane.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::{ARGUMENT_MAX, Outcome, unit};
use crate::bound::WideSpheres;
use crate::contact::{Contact, Sink, TriangleId};
use crate::error::QueryError;
use crate::math::{dot, norm};
use crate::narrow::Triangle;
use crate::pose::{Pose, U32, round_up};
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, mask_of, one};
use crate::view::Asset;

/// Reports every triangle with a vertex where `normal · x ≤ offset`, `normal` being normalised
/// first: `point` is its deepest vertex (the first of equals), `dist` that vertex's
/// `normal · x − offset`, `normal` the plane's.
///
/// # Errors
/// A normal that is zero or not finite, an offset that is not finite or beyond 2^100, a pose of
/// another asset, too short a stack, a corrupt asset.
pub fn plane(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    normal: [f64; 3],
    offset: f64,
    stack: &mut [StackEntry],
    sink: &mut impl Sink<Contact>,
) -> Result<Outcome, QueryError> {
    let normal = unit(normal, "normal: zero or not finite")?;
    if !(offset.abs() <= ARGUMENT_MAX) {
        return Err(QueryError::Argument("offset: not finite or beyond 2^100"));
    }
    let frame = &pose.frame;
    // n·x = n·o + k (n_s·p'), o the stored origin's world position, k world per stored unit.
    let origin = frame.origin_in_world();
    let stored_offset = (offset - dot(normal, origin)) / frame.world_per_stored();
    let error = frame.error(offset.abs() + norm(origin), pose.reach);
    // Beyond twice the reach an offset decides alone; clamping keeps its f32 rounding small.
    let far = 2.0 * pose.reach + 2.0 * error + 1.0;
    let stored_offset = stored_offset.clamp(-far, far);
    let extra = error + 8.0 * U32 * pose.reach + 2.0 * U32 * stored_offset.abs();
    let mut visitor = Plane {
        stored_normal: frame.inverse_rotate(normal).map(|x| x as f32),
        stored_offset: stored_offset as f32,
        extra: round_up(extra),
        normal,
        offset,
        sink,
    };
    let walk = one(asset, pose, stack, &mut visitor)?;
    Ok(Outcome {
        nodes_visited: walk.nodes_visited,
        truncated: walk.stopped,
    })
}

struct Plane<'s, S> {
    stored_normal: [f32; 3],
    stored_offset: f32,
    extra: f32,
    normal: [f64; 3],
    offset: f64,
    sink: &'s mut S,
}

impl<S: Sink<Contact>> Visitor for Plane<'_, S> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, _keys: &mut Row) -> u8 {
        let spheres = spheres.store();
        let [nx, ny, nz] = self.stored_normal;
        let [x, y, z] = &spheres.centre;
        mask_of(|k| {
            let height = (nx * x[k] + ny * y[k] + nz * z[k]) - self.stored_offset;
            let above = height > spheres.radius[k] + self.extra;
            !above
        })
    }

    fn wanted(&self, _key: f32) -> bool {
        true
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
            normal: self.normal,
            dist: heights[deepest],
            barycentric,
        })
    }
}
