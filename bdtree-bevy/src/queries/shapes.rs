//! Shapes and points.

use bdtree_runtime::Vec3 as Point;
use bdtree_runtime::{Contact, PointProjection, Shape};
use bevy_ecs::prelude::*;

use super::near::may_touch;
use super::{DeformingQueries, EntityHit, WorldQueryError};

impl DeformingQueries<'_, '_> {
    /// Reports every triangle that the shape touches (a [`Ball`](bdtree_runtime::Ball),
    /// [`Capsule`](bdtree_runtime::Capsule), [`Cuboid`](bdtree_runtime::Cuboid) or
    /// [`HalfSpace`](bdtree_runtime::HalfSpace) in the world), by entity. `out` is appended to.
    ///
    /// # Errors
    /// A shape with a field that is not allowed, of which its text speaks, where a mesh may be near; a damaged file. What
    /// was found before stays.
    pub fn contacts(
        &mut self,
        shape: impl Into<Shape>,
        filter: impl Fn(Entity) -> bool,
        out: &mut Vec<EntityHit<Contact>>,
    ) -> Result<(), WorldQueryError> {
        let shape = shape.into();
        self.near(&shape, filter, |queries, entity| {
            let Ok(body) = queries.bodies.get(entity) else {
                return Ok(());
            };
            let memory = &mut *queries.memory;
            memory.contacts.clear();
            let pose = body.instance.snapshot();
            let mut query = pose.query(&mut memory.workspace);
            let coverage = query.contacts(shape, &mut memory.contacts);
            coverage.map_err(WorldQueryError::of(entity))?;
            let contacts = memory.contacts.iter();
            out.extend(contacts.map(|hit| EntityHit { entity, hit: *hit }));
            Ok(())
        })
    }

    /// Reports every entity whose mesh the shape touches, in ascending order. `out` is appended to.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::contacts`].
    pub fn intersections(
        &mut self,
        shape: impl Into<Shape>,
        filter: impl Fn(Entity) -> bool,
        out: &mut Vec<Entity>,
    ) -> Result<(), WorldQueryError> {
        let shape = shape.into();
        self.near(&shape, filter, |queries, entity| {
            let Ok(body) = queries.bodies.get(entity) else {
                return Ok(());
            };
            let pose = body.instance.snapshot();
            let mut query = pose.query(&mut queries.memory.workspace);
            if query
                .intersects(shape)
                .map_err(WorldQueryError::of(entity))?
            {
                out.push(entity);
            }
            Ok(())
        })
    }

    /// The point of all meshes that is nearest to `point`, if it is within `max_distance` (which may be infinite); of
    /// several at the same distance, the lowest entity's.
    ///
    /// # Errors
    /// A point that is not finite or beyond 2^100, a negative or NaN distance, where there is a mesh; a damaged file.
    pub fn project_point(
        &mut self,
        point: impl Into<Point>,
        max_distance: f64,
        filter: impl Fn(Entity) -> bool,
    ) -> Result<Option<EntityHit<PointProjection>>, WorldQueryError> {
        let Point(point) = point.into();
        let near = self.nearest_first(filter, |bounds| {
            let distance = bounds.distance_to(point);
            (!(distance > max_distance)).then_some(distance)
        });
        let found = self.nearest_of(&near, point, max_distance);
        self.memory.near = near;
        found
    }

    fn nearest_of(
        &mut self,
        near: &[(f64, Entity)],
        point: [f64; 3],
        max_distance: f64,
    ) -> Result<Option<EntityHit<PointProjection>>, WorldQueryError> {
        let mut best: Option<EntityHit<PointProjection>> = None;
        for (from, entity) in near.iter().copied() {
            let limit = best.map_or(max_distance, |best| best.distance);
            if from > limit {
                break;
            }
            let Ok(body) = self.bodies.get(entity) else {
                continue;
            };
            let pose = body.instance.snapshot();
            let mut query = pose.query(&mut self.memory.workspace);
            let found = query.project_point(point, limit);
            if let Some(hit) = found.map_err(WorldQueryError::of(entity))?
                && best.is_none_or(|best| (hit.distance, entity) < (best.distance, best.entity))
            {
                best = Some(EntityHit { entity, hit });
            }
        }
        Ok(best)
    }

    /// Visits the entities whose boxes the shape may touch, in ascending order.
    fn near(
        &mut self,
        shape: &Shape,
        filter: impl Fn(Entity) -> bool,
        mut visit: impl FnMut(&mut Self, Entity) -> Result<(), WorldQueryError>,
    ) -> Result<(), WorldQueryError> {
        let near = self.nearest_first(filter, |bounds| may_touch(shape, bounds).then_some(0.0));
        let done = near.iter().try_for_each(|(_, entity)| visit(self, *entity));
        self.memory.near = near;
        done
    }
}
