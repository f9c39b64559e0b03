//! Rays.

use bdtree_runtime::{Ray, RayIntersection};
use bevy_ecs::prelude::*;

use super::{DeformingQueries, EntityHit, WorldQueryError};
use crate::bounds::BoxRay;

impl DeformingQueries<'_, '_> {
    /// Where the ray first meets a mesh; of several at the same distance, the lowest entity's.
    ///
    /// # Errors
    /// [`WorldQueryError::Ray`]; a damaged file.
    pub fn cast_ray(
        &mut self,
        ray: &Ray,
        filter: impl Fn(Entity) -> bool,
    ) -> Result<Option<EntityHit<RayIntersection>>, WorldQueryError> {
        let mut first: Option<EntityHit<RayIntersection>> = None;
        self.along(ray, filter, |queries, entity, from| {
            let limit = first.map_or(ray.max_distance, |hit| hit.distance);
            if from > limit {
                return Ok(false);
            }
            // One at exactly the limit counts.
            if let Some(hit) = queries.cast_at(entity, &ray.with_max_distance(limit))?
                && first.is_none_or(|best| (hit.distance, entity) < (best.distance, best.entity))
            {
                first = Some(hit);
            }
            Ok(true)
        })?;
        Ok(first)
    }

    /// An entity whose mesh the ray meets, not necessarily the first: ends with the first that is found.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::cast_ray`].
    pub fn intersects_ray(
        &mut self,
        ray: &Ray,
        filter: impl Fn(Entity) -> bool,
    ) -> Result<Option<Entity>, WorldQueryError> {
        let mut found = None;
        self.along(ray, filter, |queries, entity, _| {
            let Ok(body) = queries.bodies.get(entity) else {
                return Ok(true);
            };
            let pose = body.instance.snapshot();
            let mut query = pose.query(&mut queries.memory.workspace);
            if query
                .intersects_ray(ray)
                .map_err(WorldQueryError::of(entity))?
            {
                found = Some(entity);
            }
            Ok(found.is_none())
        })?;
        Ok(found)
    }

    /// Reports every triangle that the ray meets, sorted by distance. `out` is appended to.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::cast_ray`]; what was found before stays.
    pub fn cast_ray_all(
        &mut self,
        ray: &Ray,
        filter: impl Fn(Entity) -> bool,
        out: &mut Vec<EntityHit<RayIntersection>>,
    ) -> Result<(), WorldQueryError> {
        let start = out.len();
        self.along(ray, filter, |queries, entity, _| {
            let Ok(body) = queries.bodies.get(entity) else {
                return Ok(true);
            };
            let memory = &mut *queries.memory;
            memory.hits.clear();
            let pose = body.instance.snapshot();
            let mut query = pose.query(&mut memory.workspace);
            let coverage = query.cast_ray_all(ray, &mut memory.hits);
            coverage.map_err(WorldQueryError::of(entity))?;
            out.extend(
                memory
                    .hits
                    .iter()
                    .map(|hit| EntityHit { entity, hit: *hit }),
            );
            Ok(true)
        })?;
        sort(&mut out[start..]);
        Ok(())
    }

    /// Reports where the ray first meets each mesh, sorted by distance, up to the first that blocks it. `out` is appended
    /// to.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::cast_ray`]; what was found before stays.
    pub fn cast_ray_through(
        &mut self,
        ray: &Ray,
        filter: impl Fn(Entity) -> bool,
        is_blocking: impl Fn(Entity) -> bool,
        out: &mut Vec<EntityHit<RayIntersection>>,
    ) -> Result<(), WorldQueryError> {
        let (start, mut limit) = (out.len(), ray.max_distance);
        self.along(ray, filter, |queries, entity, from| {
            if from > limit {
                return Ok(false);
            }
            if let Some(hit) = queries.cast_at(entity, &ray.with_max_distance(limit))? {
                if is_blocking(entity) {
                    limit = hit.distance;
                }
                out.push(hit);
            }
            Ok(true)
        })?;
        sort(&mut out[start..]);
        let within = out[start..].partition_point(|hit| hit.distance <= limit);
        out.truncate(start + within);
        Ok(())
    }

    /// Where the ray first meets the mesh of one entity.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::cast_ray`]; [`WorldQueryError::NoInstance`].
    pub fn cast_ray_at(
        &mut self,
        entity: Entity,
        ray: &Ray,
    ) -> Result<Option<EntityHit<RayIntersection>>, WorldQueryError> {
        self.instance(entity)?;
        self.cast_at(entity, ray)
    }

    fn cast_at(
        &mut self,
        entity: Entity,
        ray: &Ray,
    ) -> Result<Option<EntityHit<RayIntersection>>, WorldQueryError> {
        let Ok(body) = self.bodies.get(entity) else {
            return Ok(None);
        };
        let pose = body.instance.snapshot();
        let hit = pose.query(&mut self.memory.workspace).cast_ray(ray);
        let hit = hit.map_err(WorldQueryError::of(entity))?;
        Ok(hit.map(|hit| EntityHit { entity, hit }))
    }

    /// Visits the entities whose boxes the ray may meet, those first whose boxes it enters first, while `visit` says true.
    fn along(
        &mut self,
        ray: &Ray,
        filter: impl Fn(Entity) -> bool,
        mut visit: impl FnMut(&mut Self, Entity, f64) -> Result<bool, WorldQueryError>,
    ) -> Result<(), WorldQueryError> {
        let boxes = BoxRay::new(ray).ok_or(WorldQueryError::Ray)?;
        let near = self.nearest_first(filter, |bounds| boxes.enters(bounds));
        let mut done = Ok(());
        for (from, entity) in &near {
            match visit(self, *entity, *from) {
                Ok(true) => {}
                Ok(false) => break,
                Err(why) => {
                    done = Err(why);
                    break;
                }
            }
        }
        self.memory.near = near;
        done
    }
}

/// By distance, then by entity and triangle.
fn sort(hits: &mut [EntityHit<RayIntersection>]) {
    hits.sort_unstable_by(|a, b| {
        let by_distance = a.distance.total_cmp(&b.distance);
        let by_entity = a.entity.cmp(&b.entity);
        by_distance
            .then(by_entity)
            .then(a.triangle.cmp(&b.triangle))
    });
}
