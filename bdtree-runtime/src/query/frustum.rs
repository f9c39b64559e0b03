//! Whether a mesh is inside, across or outside a view frustum.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::bounds::BoundingSphere;
use super::half_space::StoredPlane;
use super::unit;
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::TriangleId;
use crate::error::QueryError;
use crate::math::{dot, norm};
use crate::narrow::frustum_triangle::FRUSTUM_PLANES_MAX;
use crate::narrow::{Frustum, FrustumState, Triangle};
use crate::rounding::MARGIN;
use crate::simd::Lanes;
use crate::traverse::{StackEntry, Visitor, Walk, one};

/// Where the deformed triangles lie: `Inside` if all of them are (exactly: if all their corners
/// are), `Outside` if each of them is as [`Frustum::triangle`] says, `Intersects` otherwise.
///
/// The root's sphere is asked first. Undecided, the tree is descended only
/// where spheres are not clear of all planes, until the answer is known: a triangle inside and one
/// outside, or one that intersects, end it.
///
/// # Errors
/// A corrupt asset.
pub(super) fn state(
    posed: Posed<'_>,
    frustum: &Frustum,
    stack: &mut [StackEntry],
) -> Result<(FrustumState, Walk), QueryError> {
    let pose = posed.pose;
    let state = pose.bounding_sphere()?.state(frustum);
    let mut walk = Walk {
        nodes_visited: 1,
        nodes_updated: 1,
        ..Walk::default()
    };
    if state != FrustumState::Intersects {
        return Ok((state, walk));
    }
    let count = frustum.planes().len();
    let nowhere = StoredPlane::new(pose, [0.0, 0.0, 1.0], 0.0);
    let mut planes = [nowhere; FRUSTUM_PLANES_MAX];
    for (stored, [nx, ny, nz, d]) in planes.iter_mut().zip(frustum.planes()) {
        let n = [*nx, *ny, *nz];
        let normal = unit(n, "planes: zero normal")?;
        // |n| without its square, which may overflow.
        *stored = StoredPlane::new(pose, normal, -(d / dot(n, normal)));
    }
    let mut visitor = Culling {
        planes: &planes[..count],
        frustum,
        inside: false,
        outside: false,
    };
    walk.add(&one(posed, stack, &mut visitor)?);
    let state = match (visitor.inside, visitor.outside) {
        (true, false) => FrustumState::Inside,
        (false, true) => FrustumState::Outside,
        _ => FrustumState::Intersects,
    };
    Ok((state, walk))
}

impl BoundingSphere {
    /// Where the sphere lies, and so what it holds; `Intersects` where that is not certain.
    pub fn state(&self, frustum: &Frustum) -> FrustumState {
        let mut inside = true;
        for [nx, ny, nz, d] in frustum.planes() {
            let n = [*nx, *ny, *nz];
            let size = dot(n.map(f64::abs), self.center.map(f64::abs)) + d.abs();
            let height = dot(n, self.center) + d;
            // Rounding is below 2⁻⁵⁰ of what enters.
            let reach = (norm(n) * self.radius + size * MARGIN) * (1.0 + MARGIN);
            if height < -reach {
                return FrustumState::Outside;
            }
            inside &= height > reach;
        }
        if inside {
            FrustumState::Inside
        } else {
            FrustumState::Intersects
        }
    }
}

struct Culling<'f> {
    planes: &'f [StoredPlane],
    frustum: &'f Frustum,
    /// A triangle was found inside.
    inside: bool,
    /// A triangle was found outside.
    outside: bool,
}

impl Visitor for Culling<'_> {
    const ORDERED: bool = false;

    /// A lane that is surely inside, or outside, is followed only to find the first triangle that
    /// is: what else is below it would say the same.
    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, _keys: &mut Row) -> u8 {
        let (mut inside, mut outside) = (u8::MAX, 0);
        for plane in self.planes {
            let height = plane.heights(&spheres);
            let reach = spheres.radius.add(L::splat(plane.extra));
            inside &= height.above(reach);
            outside |= L::splat(0.0).above(height.add(reach));
        }
        let known =
            (if self.inside { inside } else { 0 }) | (if self.outside { outside } else { 0 });
        !known
    }

    fn triangle(&mut self, _id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        match self.frustum.triangle(corners) {
            FrustumState::Inside => self.inside = true,
            FrustumState::Outside => self.outside = true,
            FrustumState::Intersects => (self.inside, self.outside) = (true, true),
        }
        if self.inside && self.outside {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}
