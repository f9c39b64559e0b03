//! The triangles that an oriented box touches.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::{length, point};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{Contact, Sink, TriangleId};
use crate::error::QueryError;
use crate::math::{clamp, dot, norm};
use crate::narrow::{OrientedBox, Triangle};
use crate::pose::Pose;
use crate::rounding::{CUT_TO_REACH, MARGIN, SKIP, round_up};
use crate::shape;
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, Walk, one};

/// Reports every triangle that shares a point with the box: `point` is the triangle's point deepest in the
/// box, that is farthest from the nearest face, `distance` minus that distance (≤ 0), `normal` unit, from that
/// face into the box: moving the box by `−distance` along it takes the face to the point.
///
/// # Errors
/// A center or half extent that is not finite or beyond 2^100, a negative half extent, a quaternion
/// that is not finite or whose norm is off by more than 1e-3, a corrupt asset.
pub(super) fn contacts(
    posed: Posed<'_>,
    cuboid: &shape::Cuboid,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<Contact>,
) -> Result<Walk, QueryError> {
    let pose = posed.pose;
    let center = point(
        cuboid.center,
        "center: a coordinate is not finite or beyond 2^100",
    )?;
    for half in cuboid.half_extents {
        length(half, "half_extents: negative, not finite or beyond 2^100")?;
    }
    let squared = cuboid.rotation.iter().fold(0.0, |sum, c| sum + c * c);
    // (1 ± 1e-3)², as placements are refused.
    if !((0.998_001..=1.002_001).contains(&squared)) {
        let what = "rotation: not a quaternion within 1e-3 of unit length";
        return Err(QueryError::Argument(what));
    }
    let shape = OrientedBox::new(center, cuboid.rotation, cuboid.half_extents);
    let Some(near) = NearBox::new(pose, &shape) else {
        return Ok(Walk::default());
    };
    let mut visitor = Cuboid { near, shape, sink };
    one(posed, stack, &mut visitor)
}

/// A box as three slabs `low ≤ axis · x ≤ high` about the origin of stored coordinates.
#[derive(Clone, Copy)]
struct NearBox {
    axes: [[f32; 3]; 3],
    low: [f32; 3],
    high: [f32; 3],
    /// All errors but those that the spheres' slack covers.
    reach: f32,
}

impl NearBox {
    /// Nothing where a slab holds no point of the body. Slabs are cut off where the body cannot
    /// be, so a box may be as large and as far as you like.
    fn new(pose: &Pose<'_>, shape: &OrientedBox) -> Option<Self> {
        let frame = &pose.placement;
        // Twice: leaf predicate and placement; the slabs and axes formed here.
        let world = norm(shape.center()) + norm(shape.half_extents());
        let error = 2.0 * frame.error(world, pose.reach);
        let around = pose.reach + f64::from(pose.slack) + error;
        let around = around * (1.0 + MARGIN);
        let center = frame.point_to_stored(shape.center());
        let axes = shape.axes().map(|axis| frame.inverse_rotate(axis));
        let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let middle = dot(axes[k], center);
            let half = shape.half_extents()[k] / frame.world_per_stored();
            if middle - half > around || middle + half < -around {
                return None;
            }
            low[k] = clamp(middle - half, -2.0 * around, 2.0 * around) as f32;
            high[k] = clamp(middle + half, -2.0 * around, 2.0 * around) as f32;
        }
        Some(Self {
            axes: axes.map(|axis| axis.map(|x| x as f32)),
            low,
            high,
            // 32 u: axes and slabs in f32, of numbers up to twice `around`.
            reach: round_up(error + CUT_TO_REACH * around),
        })
    }

    /// The lanes that are not certainly farther than `reach`.
    #[inline(always)]
    fn within<L: Lanes>(&self, spheres: &WideSpheres<L>) -> u8 {
        let [x, y, z] = spheres.center;
        let mut squared = L::splat(0.0);
        for k in 0..3 {
            let [ax, ay, az] = self.axes[k];
            let along = x
                .mul(L::splat(ax))
                .add(y.mul(L::splat(ay)))
                .add(z.mul(L::splat(az)));
            let below = L::splat(self.low[k]).sub(along);
            let above = along.sub(L::splat(self.high[k]));
            let beyond = below.max(above).max(L::splat(0.0));
            squared = squared.add(beyond.mul(beyond));
        }
        let reach = spheres.radius.add(L::splat(self.reach));
        !squared.mul(L::splat(SKIP)).above(reach.mul(reach))
    }

    /// Whether all corners of a triangle (stored units) are certainly beyond the same side of a
    /// slab by more than `reach`.
    #[inline(always)]
    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        let reach = f64::from(self.reach);
        let mut misses = false;
        for k in 0..3 {
            let axis = self.axes[k].map(f64::from);
            let (mut below, mut above) = (true, true);
            for corner in corners {
                let along = dot(axis, corner.map(f64::from));
                below &= along < f64::from(self.low[k]) - reach;
                above &= along > f64::from(self.high[k]) + reach;
            }
            misses |= below | above;
        }
        misses
    }
}

struct Cuboid<'s> {
    near: NearBox,
    shape: OrientedBox,
    sink: &'s mut (dyn Sink<Contact> + 's),
}

impl Visitor for Cuboid<'_> {
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
        let Some(contact) = self.shape.contact(corners) else {
            return ControlFlow::Continue(());
        };
        self.sink.push(Contact {
            triangle: id,
            point: contact.point,
            normal: contact.normal,
            // Not the negated depth, which for 0 is −0.
            distance: 0.0 - contact.depth,
            barycentric: contact.barycentric,
        })
    }
}
