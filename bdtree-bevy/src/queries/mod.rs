//! Questions about all deforming meshes of the world.

mod near;
mod pairs;
mod rays;
mod shapes;

use std::ops::Deref;

use bdtree_runtime::{Contact, Instance, PointProjection, QueryError, RayIntersection, Workspace};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::{DVec3, Vec3};
use thiserror::Error;

use crate::bounds::DeformedBounds;
use crate::pose::DeformedInstance;

/// Questions about the deforming meshes of the world: rays, shapes, points, and two entities at a time. Boxes around the
/// meshes are compared first, then the trees of those that remain are asked, the nearest first.
///
/// It reads only, so systems that ask may run side by side; each keeps its own memory, which grows to what its largest
/// question has needed. Answers are of the poses that [`BdtreeSystems::Bounds`](crate::BdtreeSystems::Bounds) has seen:
/// ask behind it in `PostUpdate`, or any time later until the next frame's.
///
/// Coordinates and lengths are the world's, in f64. Filters leave out entities for which they are false. The words, and
/// what limits include, are [`bdtree_runtime`]'s: meshes are surfaces whose triangles have two sides.
///
/// ```
/// use bdtree_bevy::DeformingQueries;
/// use bdtree_bevy::bdtree_runtime::Ray;
///
/// fn aim(mut queries: DeformingQueries) {
///     let ray = Ray::new([0.0, 1.0, 10.0], [0.0, 0.0, -1.0]);
///     match queries.cast_ray(&ray, |_| true) {
///         Ok(Some(hit)) => println!("{} at {:?}, triangle {}", hit.entity, hit.point, hit.triangle.0),
///         Ok(None) => println!("nothing"),
///         Err(why) => eprintln!("{why}"),
///     }
/// }
/// # bevy_ecs::system::assert_is_system(aim);
/// ```
#[derive(SystemParam)]
pub struct DeformingQueries<'w, 's> {
    bounds: Query<'w, 's, (Entity, &'static DeformedBounds)>,
    bodies: Query<'w, 's, &'static DeformedInstance>,
    memory: Local<'s, QueryMemory>,
}

/// What questions work in.
#[derive(Default)]
struct QueryMemory {
    workspace: Workspace<'static>,
    /// Entities that may be met, and from what distance on.
    near: Vec<(f64, Entity)>,
    contacts: Vec<Contact>,
    hits: Vec<RayIntersection>,
}

/// What a question found, and whose it is. Reads like what was found: `hit.point`, `hit.triangle`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EntityHit<T> {
    /// The entity of the mesh.
    pub entity: Entity,
    /// What was found of it: triangle, barycentric coordinates, point, normal, distance.
    pub hit: T,
}

impl<T> Deref for EntityHit<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.hit
    }
}

macro_rules! in_bevys_words {
    ($($found:ty),*) => {$(
        impl EntityHit<$found> {
            /// The point of the mesh, rounded (world units).
            pub fn position(&self) -> Vec3 {
                DVec3::from_array(self.hit.point).as_vec3()
            }

            /// The unit normal, rounded.
            pub fn direction(&self) -> Vec3 {
                DVec3::from_array(self.hit.normal).as_vec3()
            }
        }
    )*};
}
in_bevys_words!(RayIntersection, Contact, PointProjection);

/// Why a question has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum WorldQueryError {
    /// An argument that the library refuses (its text names it), or a damaged file.
    #[error("{entity}: {why}")]
    Body {
        /// The entity that was asked.
        entity: Entity,
        /// What is wrong.
        why: QueryError,
    },
    /// The origin or the direction of a ray is not finite, or the direction is zero.
    #[error("the ray's origin or direction is not finite, or its direction is zero")]
    Ray,
    /// The entity has no deforming mesh, or its model is not loaded yet.
    #[error("{0} has no DeformedInstance")]
    NoInstance(Entity),
    /// A question about two entities was asked of one.
    #[error("{0} is both entities of a pair")]
    Same(Entity),
}

impl WorldQueryError {
    fn of(entity: Entity) -> impl Fn(QueryError) -> Self {
        move |why| Self::Body { entity, why }
    }
}

impl DeformingQueries<'_, '_> {
    /// The deformed mesh of an entity, as queries see it.
    ///
    /// # Errors
    /// [`WorldQueryError::NoInstance`].
    pub fn instance(&self, entity: Entity) -> Result<&Instance, WorldQueryError> {
        match self.bodies.get(entity) {
            Ok(body) => Ok(&body.instance),
            Err(_) => Err(WorldQueryError::NoInstance(entity)),
        }
    }

    /// The entities for which `from` gives a distance, by that and then by entity, in the memory's list, which the caller
    /// gives back.
    fn nearest_first(
        &mut self,
        filter: impl Fn(Entity) -> bool,
        from: impl Fn(&DeformedBounds) -> Option<f64>,
    ) -> Vec<(f64, Entity)> {
        let mut near = std::mem::take(&mut self.memory.near);
        near.clear();
        for (entity, bounds) in &self.bounds {
            if let Some(distance) = from(bounds)
                && filter(entity)
            {
                near.push((distance, entity));
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near
    }
}
