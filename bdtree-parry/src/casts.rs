//! Shapes that move until they touch.

use std::ops::ControlFlow::Continue;

use super::composite::{Nearness, PartPair, end_if, part_pairs};
use super::dispatcher::MeshDispatcher;
use super::near::{Reach, bounds};
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::{
    NonlinearRigidMotion, QueryDispatcher, ShapeCastHit, ShapeCastOptions, Unsupported,
};
use super::parry::shape::Shape;
use super::shape::DeformingMesh;
use super::triangles::{ConvexPair, convex_pairs};

/// Longer ways are those of shapes that never meet.
const LONGEST: Real = 1e12;

/// The first hit so far, or that a pair of shapes cannot be cast.
#[derive(Default)]
struct First {
    hit: Option<ShapeCastHit>,
    failed: bool,
}

impl First {
    /// The first of two that start in contact stays.
    fn take(
        &mut self,
        pair: &PartPair<'_>,
        convex: &ConvexPair<'_>,
        found: Result<Option<ShapeCastHit>, Unsupported>,
    ) {
        match found {
            Ok(Some(hit)) => {
                let best = self.hit.map(|best| best.time_of_impact);
                if best.is_none_or(|best| hit.time_of_impact < best) {
                    self.hit = Some(ShapeCastHit {
                        witness1: pair.one.pose * hit.witness1,
                        witness2: pair.two.pose * hit.witness2,
                        normal1: pair.one.pose.rotation * hit.normal1,
                        normal2: pair.two.pose.rotation * hit.normal2,
                        subshape1: convex.subshape1,
                        subshape2: convex.subshape2,
                        ..hit
                    });
                }
            }
            Ok(None) => {}
            Err(Unsupported) => self.failed = true,
        }
    }

    /// No later hit matters.
    fn until(&self, time: Real) -> Real {
        self.hit.map_or(time, |hit| hit.time_of_impact.min(time))
    }

    fn answer(self) -> Result<Option<ShapeCastHit>, Unsupported> {
        if self.failed {
            Err(Unsupported)
        } else {
            Ok(self.hit)
        }
    }
}

/// Center and radius of what holds a shape; `None` for one without bounds.
fn ball(shape: &dyn Shape) -> Option<(Vector, Real)> {
    let aabb = bounds(shape)?;
    Some((aabb.center(), aabb.half_extents().length()))
}

/// Shows the convex pairs of two parts: where both are meshes, triangles of the first that `reach` holds, each with such
/// triangles of the second.
fn all_convex_pairs(
    pair: &PartPair<'_>,
    reach: &dyn Fn(&DeformingMesh, &dyn Shape, &Pose, bool) -> Reach,
    visit: &mut dyn FnMut(&PartPair<'_>, &ConvexPair<'_>),
) {
    let is_first = pair.one.mesh().is_some();
    let own =
        |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| reach(mesh, other, pos, is_first);
    convex_pairs(pair, &own, false, &mut |convex| {
        if pair.two.mesh().is_none() || !is_first {
            visit(pair, convex);
            return Continue(());
        }
        // A triangle of the first mesh with the second mesh.
        let mut single = *pair;
        single.one.shape = convex.shape1;
        let others =
            |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| reach(mesh, other, pos, false);
        convex_pairs(&single, &others, false, &mut |inner| {
            visit(
                &single,
                &ConvexPair {
                    subshape1: convex.subshape1,
                    ..*inner
                },
            );
            Continue(())
        });
        Continue(())
    });
}

impl<D: QueryDispatcher> MeshDispatcher<D> {
    /// `cast_shapes` of two shapes, one of which holds a mesh.
    pub(super) fn cast(
        &self,
        pos12: &Pose,
        velocity: Vector,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        let speed = velocity.length();
        let mut end = options.max_time_of_impact;
        if let (Some((center1, radius1)), Some((center2, radius2))) = (ball(shape1), ball(shape2)) {
            // Then the two balls have passed each other.
            let apart = (pos12 * center2).distance(center1) + radius1 + radius2;
            end = end.min((apart + options.target_distance) / speed * 1.01);
        }
        let sweep_until = |time: Real| {
            if speed == 0.0 {
                return Vector::ZERO;
            }
            velocity / speed * (time * speed).min(LONGEST)
        };
        let mut first = First::default();
        let near = Nearness {
            distance: options.target_distance,
            sweep: sweep_until(end),
        };
        part_pairs(pos12, shape1, shape2, near, &mut |pair| {
            let until = first.until(end);
            // Of the second part in the frame of the first.
            let own_velocity = pair.one.pose.rotation.inverse() * velocity;
            let own_sweep = pair.one.pose.rotation.inverse() * sweep_until(until);
            let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose, is_first: bool| {
                let sweep = if is_first {
                    own_sweep
                } else {
                    pair.pos12.rotation.inverse() * -own_sweep
                };
                mesh.swept_reach_of(other, pos, sweep, options.target_distance)
            };
            all_convex_pairs(pair, &reach, &mut |pair, convex| {
                let options = ShapeCastOptions {
                    max_time_of_impact: first.until(options.max_time_of_impact),
                    ..options
                };
                let (a, b) = (convex.shape1, convex.shape2);
                let found = self
                    .inner
                    .cast_shapes(&pair.pos12, own_velocity, a, b, options);
                first.take(pair, convex, found);
            });
            end_if(first.failed)
        });
        first.answer()
    }

    /// `cast_shapes_nonlinear` of two shapes, one of which holds a mesh: triangles that the other shape can come near at any
    /// time, by the speeds of both motions.
    pub(super) fn cast_nonlinear(
        &self,
        [motion1, motion2]: [&NonlinearRigidMotion; 2],
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        [start, end]: [Real; 2],
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        let pos12 = motion1
            .position_at_time(start)
            .inv_mul(&motion2.position_at_time(start));
        let way = farthest([motion1, motion2], shape1, shape2, end - start);
        let mut first = First::default();
        let near = Nearness::within(way);
        part_pairs(&pos12, shape1, shape2, near, &mut |pair| {
            let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose, _: bool| {
                mesh.reach_of(other, pos, way)
            };
            let own1 = motion1.prepend(pair.one.pose);
            let own2 = motion2.prepend(pair.two.pose);
            all_convex_pairs(pair, &reach, &mut |pair, convex| {
                let until = first.until(end);
                let found = self.inner.cast_shapes_nonlinear(
                    &own1,
                    convex.shape1,
                    &own2,
                    convex.shape2,
                    start,
                    until,
                    stop_at_penetration,
                );
                first.take(pair, convex, found);
            });
            end_if(first.failed)
        });
        first.answer()
    }
}

/// How far any point of the second shape gets at most in the frame of the first; infinite where that has no bound.
fn farthest(
    [motion1, motion2]: [&NonlinearRigidMotion; 2],
    shape1: &dyn Shape,
    shape2: &dyn Shape,
    duration: Real,
) -> Real {
    let (Some((center1, radius1)), Some((center2, radius2))) = (ball(shape1), ball(shape2)) else {
        return Real::INFINITY;
    };
    let lever1 = center1.distance(motion1.local_center) + radius1;
    let lever2 = center2.distance(motion2.local_center) + radius2;
    // A point near both moves with the second, and the first's frame turns under it.
    let speed1 = motion1.linvel.length() + motion1.angvel.length() * lever1;
    let speed2 = motion2.linvel.length() + motion2.angvel.length() * lever2;
    let way = (speed1 + speed2) * duration * 1.01;
    if way < LONGEST { way } else { Real::INFINITY }
}
