//! Which triangles of a mesh another shape can reach: found in the tree from q, without deforming the mesh.

use bdtree_runtime::{Ball, Capsule, Contact, Cuboid, HalfSpace, Shape as Region, Transform};

use super::parry::bounding_volume::Aabb;
use super::parry::math::{Pose, Real, Vector};
use super::parry::shape::Shape;
use super::points::{wide, with_workspace};
use super::shape::DeformingMesh;

/// Coordinates beyond this are those of a shape without bounds.
const FAR: Real = 1e15;

/// Where something is, in the frame of a mesh.
#[derive(Debug, Clone, Copy)]
pub(super) enum Reach {
    /// No farther than this.
    Within(Region),
    /// Anywhere.
    Everywhere,
}

/// The placement of a shape at `pose`.
pub(super) fn transform(pose: &Pose, scale: f64) -> Transform {
    let [x, y, z, w] = pose.rotation.to_array().map(f64::from);
    let norm = (x * x + y * y + z * z + w * w).sqrt();
    Transform {
        rotation: [x, y, z, w].map(|c| c / norm),
        translation: wide(pose.translation),
        scale,
    }
}

/// The box of a shape in its own frame; `None` for one without bounds.
pub(super) fn bounds(shape: &dyn Shape) -> Option<Aabb> {
    let aabb = shape.compute_local_aabb();
    let is_bounded = aabb
        .mins
        .abs()
        .max_element()
        .max(aabb.maxs.abs().max_element())
        < FAR;
    is_bounded.then_some(aabb)
}

impl DeformingMesh {
    /// More than what rounding puts coordinates of this size off by.
    pub(super) fn margin(&self, other: Real) -> Real {
        let sphere = self.sphere();
        let size = sphere.radius + sphere.center.abs().max_element() + other;
        16.0 * Real::EPSILON * size
    }

    /// Everything within `distance` of a convex shape that stands at `pos` in this mesh's frame.
    pub(super) fn reach_of(&self, shape: &dyn Shape, pos: &Pose, distance: Real) -> Reach {
        if let Some(plane) = shape.as_halfspace() {
            let normal = wide(pos.rotation * plane.normal);
            let base = wide(pos.translation);
            let offset: f64 = (0..3).map(|k| normal[k] * base[k]).sum();
            let margin = self.margin(pos.translation.abs().max_element());
            if !(distance < FAR) {
                return Reach::Everywhere;
            }
            let reach = f64::from(distance) + f64::from(margin);
            return within(HalfSpace::new(normal, offset + reach));
        }
        let Some(aabb) = bounds(shape) else {
            return Reach::Everywhere;
        };
        let size = aabb.half_extents().length() + pos.translation.length() + aabb.center().length();
        let reach = distance + self.margin(size);
        if !(reach < FAR) {
            return Reach::Everywhere;
        }
        if let Some(ball) = shape.as_ball() {
            let radius = f64::from(ball.radius + reach);
            return within(Ball::new(wide(pos.translation), radius));
        }
        if let Some(capsule) = shape.as_capsule() {
            let [a, b] = [capsule.segment.a, capsule.segment.b].map(|x| wide(pos * x));
            return within(Capsule::new(a, b, f64::from(capsule.radius + reach)));
        }
        let half = aabb.half_extents() + Vector::splat(reach);
        let rotation = transform(pos, 1.0).rotation;
        within(Cuboid::new(wide(pos * aabb.center()), wide(half)).rotated(rotation))
    }

    /// Everything that a convex shape at `pos` comes within `distance` of while it moves by `sweep`.
    pub(super) fn swept_reach_of(
        &self,
        shape: &dyn Shape,
        pos: &Pose,
        sweep: Vector,
        distance: Real,
    ) -> Reach {
        let Some(aabb) = bounds(shape) else {
            return Reach::Everywhere;
        };
        let (start, radius) = (pos * aabb.center(), aabb.half_extents().length());
        let size = radius + start.length() + sweep.length();
        let reach = radius + distance + self.margin(size);
        if !(reach < FAR && sweep.length() < FAR) {
            return Reach::Everywhere;
        }
        within(Capsule::new(
            wide(start),
            wide(start + sweep),
            f64::from(reach),
        ))
    }

    /// The triangles that lie there at least in part, by their ids; all where the place is none that can be asked for.
    pub(super) fn triangles_in(&self, reach: &Reach) -> Vec<u32> {
        let all = || (0..self.triangle_count()).collect();
        let region = match reach {
            Reach::Everywhere => return all(),
            Reach::Within(region) => *region,
        };
        let pose = self.pose();
        let mut found: Vec<Contact> = Vec::new();
        let walked = with_workspace(|workspace| pose.query(workspace).contacts(region, &mut found));
        if walked.is_err() {
            return all();
        }
        let mut ids: Vec<u32> = found.iter().map(|contact| contact.triangle.0).collect();
        ids.sort_unstable();
        ids
    }
}

fn within(region: impl Into<Region>) -> Reach {
    Reach::Within(region.into())
}
