//! Two entities.

use bdtree_runtime::{ContactManifold, PairContact, PairQuery, QueryError};
use bevy_ecs::prelude::*;

use super::{DeformingQueries, WorldQueryError};

impl DeformingQueries<'_, '_> {
    /// Reports every pair of triangles, one of each mesh, that are at most `prediction` apart (0: that touch). `out` is
    /// appended to.
    ///
    /// # Errors
    /// [`WorldQueryError::NoInstance`] and [`WorldQueryError::Same`]; a prediction that is negative or not finite; a
    /// damaged file.
    pub fn pair_contacts(
        &mut self,
        entities: [Entity; 2],
        prediction: f64,
        out: &mut Vec<PairContact>,
    ) -> Result<(), WorldQueryError> {
        self.ask(entities, |query| {
            query.contacts(prediction, out).map(|_| ())
        })
    }

    /// Reports one manifold per connected region of contact. `out` is appended to.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::pair_contacts`].
    pub fn pair_manifolds(
        &mut self,
        entities: [Entity; 2],
        prediction: f64,
        out: &mut Vec<ContactManifold>,
    ) -> Result<(), WorldQueryError> {
        self.ask(entities, |query| {
            query.contact_manifolds(prediction, out).map(|_| ())
        })
    }

    /// Whether the two meshes touch.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::pair_contacts`].
    pub fn are_touching(&mut self, entities: [Entity; 2]) -> Result<bool, WorldQueryError> {
        self.ask(entities, |query| query.intersects())
    }

    /// The nearest two triangles, one of each mesh, and where they are nearest, if that is within `max_distance` (which
    /// may be infinite).
    ///
    /// # Errors
    /// [`WorldQueryError::NoInstance`] and [`WorldQueryError::Same`]; a distance that is negative or NaN; a damaged file.
    pub fn closest_points(
        &mut self,
        entities: [Entity; 2],
        max_distance: f64,
    ) -> Result<Option<PairContact>, WorldQueryError> {
        self.ask(entities, |query| query.closest_points(max_distance))
    }

    /// The distance of the two meshes, if it is within `max_distance`; 0 where they touch.
    ///
    /// # Errors
    /// Those of [`DeformingQueries::closest_points`].
    pub fn distance(
        &mut self,
        entities: [Entity; 2],
        max_distance: f64,
    ) -> Result<Option<f64>, WorldQueryError> {
        self.ask(entities, |query| query.distance(max_distance))
    }

    fn ask<T>(
        &mut self,
        [first, second]: [Entity; 2],
        question: impl FnOnce(&mut PairQuery<'_, '_, '_>) -> Result<T, QueryError>,
    ) -> Result<T, WorldQueryError> {
        if first == second {
            return Err(WorldQueryError::Same(first));
        }
        let body = |entity| match self.bodies.get(entity) {
            Ok(body) => Ok(body.instance.snapshot()),
            Err(_) => Err(WorldQueryError::NoInstance(entity)),
        };
        let (pose, other) = (body(first)?, body(second)?);
        let mut query = pose.against(&other, &mut self.memory.workspace);
        question(&mut query).map_err(WorldQueryError::of(first))
    }
}
