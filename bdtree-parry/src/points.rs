//! Points and rays: asked of the tree in f64.

use std::cell::RefCell;

use bdtree_runtime::{Ray as RuntimeRay, Workspace};

use super::parry::math::{Real, Vector};
use super::parry::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use super::parry::shape::FeatureId;
use super::shape::DeformingMesh;

/// What `bdtree-runtime` takes.
pub(super) fn wide(v: Vector) -> [f64; 3] {
    v.to_array().map(f64::from)
}

/// What parry takes.
pub(super) fn narrow(v: [f64; 3]) -> Vector {
    Vector::from_array(v.map(|x| x as Real))
}

/// Asks in the memory of this thread. Questions do not nest.
pub(super) fn with_workspace<T>(ask: impl FnOnce(&mut Workspace<'static>) -> T) -> T {
    thread_local! {
        static WORKSPACE: RefCell<Workspace<'static>> = const { RefCell::new(Workspace::new()) };
    }
    WORKSPACE.with_borrow_mut(ask)
}

impl DeformingMesh {
    /// The nearest point of the surface and its triangle, if it is within `max_distance`.
    pub(super) fn nearest(&self, point: Vector, max_distance: f64) -> Option<(Vector, u32)> {
        let pose = self.pose();
        let found = with_workspace(|workspace| {
            pose.query(workspace)
                .project_point(wide(point), max_distance)
        });
        // An error is that of a point that is none, or of a damaged file.
        let found = found.ok()??;
        Some((narrow(found.point), found.triangle.0))
    }
}

/// Of the surface: no point is inside. Where there is no answer (a point that is not finite) the point itself comes back.
impl PointQuery for DeformingMesh {
    fn project_local_point(&self, pt: Vector, _solid: bool) -> PointProjection {
        self.project_local_point_and_get_feature(pt).0
    }

    fn project_local_point_with_max_dist(
        &self,
        pt: Vector,
        _solid: bool,
        max_dist: Real,
    ) -> Option<PointProjection> {
        let (point, triangle) = self.nearest(pt, f64::from(max_dist))?;
        Some(PointProjection::new(point == pt, point).with_subshape(triangle))
    }

    fn project_local_point_and_get_feature(&self, pt: Vector) -> (PointProjection, FeatureId) {
        match self.nearest(pt, f64::INFINITY) {
            Some((point, triangle)) => (
                PointProjection::new(point == pt, point).with_subshape(triangle),
                FeatureId::Face(triangle),
            ),
            None => (PointProjection::new(false, pt), FeatureId::Unknown),
        }
    }
}

/// Of the surface, from both sides: `solid` makes no difference.
impl RayCast for DeformingMesh {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: Real,
        _solid: bool,
    ) -> Option<RayIntersection> {
        let speed = wide(ray.dir).iter().map(|x| x * x).sum::<f64>().sqrt();
        let limit = (f64::from(max_time_of_impact) * speed).max(0.0);
        let ray = RuntimeRay::new(wide(ray.origin), wide(ray.dir)).with_max_distance(limit);
        let pose = self.pose();
        let hit = with_workspace(|workspace| pose.query(workspace).cast_ray(&ray)).ok()??;
        let feature = FeatureId::Face(hit.triangle.0);
        let time = (hit.distance / speed) as Real;
        Some(RayIntersection::new(time, narrow(hit.normal), feature).with_subshape(hit.triangle.0))
    }
}
