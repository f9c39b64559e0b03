//! The dispatcher: parry's questions about two shapes, of which one or both deform.

use std::ops::ControlFlow::{Break, Continue};

use bdtree_runtime::TrianglePair;

use super::composite::{Nearness, PartPair, end_if, holds_mesh, part_pairs};
use super::near::bounds;
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::{
    ClosestPoints, Contact, DefaultQueryDispatcher, NonlinearRigidMotion, QueryDispatcher,
    ShapeCastHit, ShapeCastOptions, ShapeDistance, ShapeIntersection, Unsupported,
};
use super::parry::shape::{Shape, SubShapeId};
use super::points::narrow;
use super::shape::DeformingMesh;
use super::triangles::{ask_pair, convex_pairs, limit, meshes};

/// Answers parry's queries where a [`DeformingMesh`](super::DeformingMesh) is involved, also in a `Compound`, and asks another
/// dispatcher for everything else: parry's own unless given. Give it to rapier with `NarrowPhase::with_query_dispatcher`.
#[derive(Debug, Clone)]
pub struct MeshDispatcher<D = DefaultQueryDispatcher> {
    /// Asked for pairs without a deforming mesh, and for each triangle.
    pub inner: D,
}

impl MeshDispatcher {
    /// One that asks parry's own dispatcher.
    pub fn new() -> Self {
        Self {
            inner: DefaultQueryDispatcher,
        }
    }
}

impl Default for MeshDispatcher {
    fn default() -> Self {
        Self::new()
    }
}

/// The nearest found so far.
struct Nearest {
    /// None farther away matters.
    limit: Real,
    found: Option<ShapeDistance>,
}

impl Nearest {
    fn take(&mut self, distance: Real, subshape1: SubShapeId, subshape2: SubShapeId) {
        if self.found.is_none_or(|best| distance < best.distance) {
            let found = ShapeDistance::new(distance).with_subshapes(subshape1, subshape2);
            self.found = Some(found);
            self.limit = self.limit.min(distance);
        }
    }

    fn touches(&self) -> bool {
        self.found.is_some_and(|best| best.distance <= 0.0)
    }
}

/// The largest distance that matters: that of two points, one of each shape.
fn upper_bound(pos12: &Pose, shape1: &dyn Shape, shape2: &dyn Shape) -> Real {
    let start = match bounds(shape1) {
        Some(aabb) => aabb.center(),
        None => pos12 * shape2.compute_local_aabb().center(),
    };
    let mut point2 = shape2.project_point(pos12, start, false).point;
    let mut best = Real::INFINITY;
    // Each turn gets nearer, seldom by much after the third.
    for _ in 0..3 {
        let point1 = shape1.project_local_point(point2, false).point;
        best = best.min(point1.distance(point2));
        point2 = shape2.project_point(pos12, point1, false).point;
        best = best.min(point1.distance(point2));
    }
    // Rounded up; NaN of what is no shape is no bound.
    let rounded = best * (1.0 + 64.0 * Real::EPSILON) + Real::MIN_POSITIVE;
    if rounded.is_nan() {
        Real::INFINITY
    } else {
        rounded
    }
}

/// A contact of two parts, of the whole shapes.
fn whole_contact(pair: &PartPair<'_>, contact: Contact) -> Contact {
    Contact {
        point1: pair.one.pose * contact.point1,
        point2: pair.two.pose * contact.point2,
        normal1: pair.one.pose.rotation * contact.normal1,
        normal2: pair.two.pose.rotation * contact.normal2,
        ..contact
    }
}

/// The contact of a half-space and a shape with a support map, if it is one: with the shape first, parry 0.31 takes the pose
/// for its inverse.
fn plane_contact(
    pos12: &Pose,
    shape1: &dyn Shape,
    shape2: &dyn Shape,
    prediction: Real,
) -> Option<Option<Contact>> {
    if let (Some(plane), Some(shape)) = (shape1.as_halfspace(), shape2.as_support_map()) {
        let normal2 = pos12.rotation.inverse() * -plane.normal;
        let point2 = shape.local_support_point(normal2);
        let deepest = pos12 * point2;
        let dist = deepest.dot(plane.normal);
        let point1 = deepest - plane.normal * dist;
        let found = Contact::new(point1, point2, plane.normal, normal2, dist);
        return Some((dist <= prediction).then_some(found));
    }
    if shape2.as_halfspace().is_some() {
        let found = plane_contact(&pos12.inverse(), shape2, shape1, prediction)?;
        return Some(found.map(|mut found| {
            found.flip();
            found
        }));
    }
    None
}

impl<D: QueryDispatcher> QueryDispatcher for MeshDispatcher<D> {
    fn intersection_test(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        if !holds_mesh([shape1, shape2]) {
            return self.inner.intersection_test(pos12, shape1, shape2);
        }
        let mut answer = Ok(ShapeIntersection::new(false));
        part_pairs(pos12, shape1, shape2, Nearness::within(0.0), &mut |pair| {
            let mut is_found = false;
            if let Some(both) = meshes(&pair.one, &pair.two) {
                // The first pair of triangles that share a point.
                let found = ask_pair(both, &pair.pos12, |query| query.closest_points(0.0));
                if let Some(Some(found)) = found {
                    let a = pair.one.subshape(found.triangle1.0);
                    let b = pair.two.subshape(found.triangle2.0);
                    answer = Ok(ShapeIntersection::new(true).with_subshapes(a, b));
                    is_found = true;
                }
                return end_if(is_found);
            }
            let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| {
                mesh.reach_of(other, pos, 0.0)
            };
            convex_pairs(pair, &reach, false, &mut |convex| {
                let (a, b) = (convex.shape1, convex.shape2);
                match self.inner.intersection_test(&pair.pos12, a, b) {
                    Ok(found) if !found.intersecting => return Continue(()),
                    Ok(found) => {
                        answer = Ok(found.with_subshapes(convex.subshape1, convex.subshape2));
                    }
                    Err(Unsupported) => answer = Err(Unsupported),
                }
                is_found = true;
                Break(())
            });
            end_if(is_found)
        });
        answer
    }

    fn distance(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
    ) -> Result<ShapeDistance, Unsupported> {
        if !holds_mesh([shape1, shape2]) {
            return self.inner.distance(pos12, shape1, shape2);
        }
        let mut nearest = Nearest {
            limit: upper_bound(pos12, shape1, shape2),
            found: None,
        };
        let mut failed = false;
        let near = Nearness::within(nearest.limit);
        part_pairs(pos12, shape1, shape2, near, &mut |pair| {
            if let Some(both) = meshes(&pair.one, &pair.two) {
                let found = ask_pair(both, &pair.pos12, |query| {
                    query.closest_points(f64::INFINITY)
                });
                if let Some(Some(found)) = found {
                    let a = pair.one.subshape(found.triangle1.0);
                    let b = pair.two.subshape(found.triangle2.0);
                    nearest.take(found.distance as Real, a, b);
                }
            } else {
                let now = nearest.limit;
                let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| {
                    mesh.reach_of(other, pos, now)
                };
                convex_pairs(pair, &reach, false, &mut |convex| {
                    let (a, b) = (convex.shape1, convex.shape2);
                    match self.inner.distance(&pair.pos12, a, b) {
                        Ok(of) => nearest.take(of.distance, convex.subshape1, convex.subshape2),
                        Err(Unsupported) => failed = true,
                    }
                    end_if(failed)
                });
            }
            end_if(failed || nearest.touches())
        });
        match nearest.found {
            Some(best) if !failed => Ok(best),
            _ => Err(Unsupported),
        }
    }

    fn contact(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        if !holds_mesh([shape1, shape2]) {
            return self.inner.contact(pos12, shape1, shape2, prediction);
        }
        let mut best: Option<Contact> = None;
        let mut failed = false;
        let near = Nearness::within(prediction);
        part_pairs(pos12, shape1, shape2, near, &mut |pair| {
            let mut ask = |a: &dyn Shape, b: &dyn Shape, ids: (u32, u32)| {
                let found = match plane_contact(&pair.pos12, a, b, prediction) {
                    Some(found) => Ok(found),
                    None => self.inner.contact(&pair.pos12, a, b, prediction),
                };
                match found {
                    Ok(Some(found)) if best.is_none_or(|best| found.dist < best.dist) => {
                        best = Some(whole_contact(pair, found.with_subshapes(ids.0, ids.1)));
                    }
                    Ok(_) => {}
                    Err(Unsupported) => failed = true,
                }
                end_if(failed)
            };
            if let Some(both) = meshes(&pair.one, &pair.two) {
                let mut ids: Vec<TrianglePair> = Vec::new();
                // More than parry's rounding.
                let within = prediction + both.0.margin(both.1.sphere().radius);
                ask_pair(both, &pair.pos12, |query| {
                    query.triangle_pairs(limit(within), &mut ids)
                });
                ids.sort_unstable();
                for TrianglePair {
                    triangle1,
                    triangle2,
                } in ids
                {
                    let shapes = (both.0.triangle(triangle1.0), both.1.triangle(triangle2.0));
                    let (Some(a), Some(b)) = shapes else {
                        continue;
                    };
                    let a_id = pair.one.subshape(triangle1.0);
                    let b_id = pair.two.subshape(triangle2.0);
                    if ask(&a, &b, (a_id, b_id)).is_break() {
                        break;
                    }
                }
            } else {
                let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| {
                    mesh.reach_of(other, pos, prediction)
                };
                convex_pairs(pair, &reach, false, &mut |convex| {
                    let ids = (convex.subshape1, convex.subshape2);
                    ask(convex.shape1, convex.shape2, ids)
                });
            }
            end_if(failed)
        });
        if failed { Err(Unsupported) } else { Ok(best) }
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        if !holds_mesh([shape1, shape2]) {
            return self.inner.closest_points(pos12, shape1, shape2, max_dist);
        }
        let mut now = max_dist.min(upper_bound(pos12, shape1, shape2));
        let mut best: Option<(Real, Vector, Vector)> = None;
        let mut failed = false;
        part_pairs(pos12, shape1, shape2, Nearness::within(now), &mut |pair| {
            let mut take = |found: ClosestPoints| {
                let points = match found {
                    ClosestPoints::Intersecting => Some((0.0, Vector::ZERO, Vector::ZERO)),
                    ClosestPoints::WithinMargin(a, b) => {
                        let apart = a.distance(pair.pos12 * b).max(Real::MIN_POSITIVE);
                        Some((apart, pair.one.pose * a, pair.two.pose * b))
                    }
                    ClosestPoints::Disjoint => None,
                };
                if let Some(points) = points
                    && points.0 <= max_dist
                    && best.is_none_or(|best| points.0 < best.0)
                {
                    best = Some(points);
                }
                best
            };
            if let Some(both) = meshes(&pair.one, &pair.two) {
                let found = ask_pair(both, &pair.pos12, |query| {
                    query.closest_points(limit(max_dist))
                });
                if let Some(Some(found)) = found {
                    let point2 = pair.pos12.inverse_transform_point(narrow(found.point2));
                    take(if found.distance == 0.0 {
                        ClosestPoints::Intersecting
                    } else {
                        ClosestPoints::WithinMargin(narrow(found.point1), point2)
                    });
                }
            } else {
                let within = now;
                let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| {
                    mesh.reach_of(other, pos, within)
                };
                convex_pairs(pair, &reach, false, &mut |convex| {
                    // Not less than what was found, so that equal distances are not lost by rounding.
                    let (a, b) = (convex.shape1, convex.shape2);
                    match self.inner.closest_points(&pair.pos12, a, b, max_dist) {
                        Ok(found) => {
                            if let Some(best) = take(found) {
                                now = now.min(best.0);
                            }
                        }
                        Err(Unsupported) => failed = true,
                    }
                    end_if(failed)
                });
            }
            end_if(failed || best.is_some_and(|best| best.0 == 0.0))
        });
        match best {
            _ if failed => Err(Unsupported),
            Some((0.0, ..)) => Ok(ClosestPoints::Intersecting),
            Some((_, a, b)) => Ok(ClosestPoints::WithinMargin(a, b)),
            None => Ok(ClosestPoints::Disjoint),
        }
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        if !holds_mesh([shape1, shape2]) {
            return self
                .inner
                .cast_shapes(pos12, local_vel12, shape1, shape2, options);
        }
        self.cast(pos12, local_vel12, shape1, shape2, options)
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        shape1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        shape2: &dyn Shape,
        start_time: Real,
        end_time: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        let times = [start_time, end_time];
        if !holds_mesh([shape1, shape2]) {
            return self.inner.cast_shapes_nonlinear(
                motion1,
                shape1,
                motion2,
                shape2,
                start_time,
                end_time,
                stop_at_penetration,
            );
        }
        self.cast_nonlinear(
            [motion1, motion2],
            shape1,
            shape2,
            times,
            stop_at_penetration,
        )
    }
}
