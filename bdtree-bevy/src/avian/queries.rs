//! Questions about all colliders of the world, those that deform among them.

use avian3d::collider_tree::{ColliderTreeProxy, ColliderTrees};
use avian3d::collision::collider::SimpleCollider;
use avian3d::parry::math::Pose3 as Pose;
use avian3d::parry::query::{QueryDispatcher, Ray, ShapeCastOptions};
use avian3d::prelude::*;
use bdtree_parry::MeshDispatcher;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::{Dir3, Quat, Vec3};
use bevy_shape::Ray3d;

use super::collider::{BdtCollider, pose};

/// avian's `SpatialQuery` for [`BdtCollider`]s: the same questions, filters and answers, asked of the same trees of boxes,
/// which are those of the last physics step.
///
/// Meshes are surfaces: rays hit them from both sides whatever `solid` says, and no point is inside.
#[derive(SystemParam)]
pub struct BdtSpatialQuery<'w, 's> {
    colliders: Query<
        'w,
        's,
        (
            &'static Position,
            &'static Rotation,
            &'static BdtCollider,
            &'static ColliderAabb,
        ),
    >,
    trees: Res<'w, ColliderTrees>,
}

/// A collider that passed the filter, and where it stands.
struct Candidate<'a> {
    entity: Entity,
    pose: Pose,
    collider: &'a BdtCollider,
    aabb: &'a ColliderAabb,
}

impl BdtSpatialQuery<'_, '_> {
    /// The collider of a leaf, if the filter lets it through.
    fn candidate(
        &self,
        proxy: Option<&ColliderTreeProxy>,
        filter: &SpatialQueryFilter,
    ) -> Option<Candidate<'_>> {
        let proxy = proxy.filter(|proxy| filter.test(proxy.collider, proxy.layers))?;
        let (position, rotation, collider, aabb) = self.colliders.get(proxy.collider).ok()?;
        Some(Candidate {
            entity: proxy.collider,
            pose: pose(position.0, rotation.0),
            collider,
            aabb,
        })
    }

    /// The first collider that a ray hits within `max_distance` of `origin`.
    pub fn cast_ray(
        &self,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
        solid: bool,
        filter: &SpatialQueryFilter,
    ) -> Option<RayHitData> {
        let mut best: Option<RayHitData> = None;
        let mut limit = max_distance;
        for tree in self.trees.iter_trees() {
            tree.ray_traverse_closest(Ray3d::new(origin, direction), limit, |id| {
                let hit = self
                    .candidate(tree.get_proxy(id), filter)
                    .and_then(|found| found.ray(origin, direction, limit, solid));
                let Some(hit) = hit else {
                    return f32::MAX;
                };
                let distance = hit.distance;
                if best.is_none_or(|best| distance < best.distance) {
                    limit = distance;
                    best = Some(hit);
                }
                distance
            });
        }
        best
    }

    /// All colliders that a ray hits, each where it hits it first, in no order.
    pub fn ray_hits(
        &self,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
        solid: bool,
        filter: &SpatialQueryFilter,
    ) -> Vec<RayHitData> {
        let mut hits = Vec::new();
        for tree in self.trees.iter_trees() {
            tree.ray_traverse_all(Ray3d::new(origin, direction), max_distance, |id| {
                hits.extend(
                    self.candidate(tree.get_proxy(id), filter)
                        .and_then(|found| found.ray(origin, direction, max_distance, solid)),
                );
                true
            });
        }
        hits
    }

    /// The first collider that a shape touches that moves from `origin` on without turning.
    pub fn cast_shape(
        &self,
        shape: &BdtCollider,
        origin: Vec3,
        rotation: Quat,
        direction: Dir3,
        config: &ShapeCastConfig,
        filter: &SpatialQueryFilter,
    ) -> Option<ShapeHitData> {
        let mut best: Option<ShapeHitData> = None;
        let mut limit = config.max_distance;
        let aabb = shape.aabb(origin, rotation, 0.0);
        let start = pose(origin, rotation);
        for tree in self.trees.iter_trees() {
            let target = config.target_distance;
            tree.sweep_traverse_closest(aabb.into(), direction, limit, target, |id| {
                let hit = self
                    .candidate(tree.get_proxy(id), filter)
                    .and_then(|found| found.cast(shape, &start, direction, config, limit));
                let Some(hit) = hit else {
                    return f32::MAX;
                };
                let distance = hit.distance;
                if best.is_none_or(|best| distance < best.distance) {
                    limit = distance;
                    best = Some(hit);
                }
                distance
            });
        }
        best
    }

    /// All colliders that a moving shape touches, each where it touches it first, in no order.
    pub fn shape_hits(
        &self,
        shape: &BdtCollider,
        origin: Vec3,
        rotation: Quat,
        direction: Dir3,
        config: &ShapeCastConfig,
        filter: &SpatialQueryFilter,
    ) -> Vec<ShapeHitData> {
        let mut hits = Vec::new();
        let aabb = shape.aabb(origin, rotation, 0.0);
        let start = pose(origin, rotation);
        let (target, limit) = (config.target_distance, config.max_distance);
        for tree in self.trees.iter_trees() {
            tree.sweep_traverse_all(aabb.into(), direction, target, limit, |id| {
                hits.extend(
                    self.candidate(tree.get_proxy(id), filter)
                        .and_then(|found| found.cast(shape, &start, direction, config, limit)),
                );
                true
            });
        }
        hits
    }

    /// The nearest point of any collider. Where `solid`, points inside a rigid shape stay where they are.
    pub fn project_point(
        &self,
        point: Vec3,
        solid: bool,
        filter: &SpatialQueryFilter,
    ) -> Option<PointProjection> {
        let mut best: Option<(f32, PointProjection)> = None;
        for tree in self.trees.iter_trees() {
            tree.squared_distance_traverse_closest(point, f32::INFINITY, |id| {
                let Some(found) = self.candidate(tree.get_proxy(id), filter) else {
                    return f32::INFINITY;
                };
                let own = found
                    .collider
                    .shape()
                    .project_point(&found.pose, point, solid);
                let apart = own.point.distance_squared(point);
                if best.as_ref().is_none_or(|(best, _)| apart < *best) {
                    let projection = PointProjection {
                        entity: found.entity,
                        point: own.point,
                        is_inside: own.is_inside,
                    };
                    best = Some((apart, projection));
                }
                apart
            });
        }
        best.map(|(_, projection)| projection)
    }

    /// All colliders that a point is inside of, in no order.
    pub fn point_intersections(&self, point: Vec3, filter: &SpatialQueryFilter) -> Vec<Entity> {
        let mut inside = Vec::new();
        for tree in self.trees.iter_trees() {
            tree.point_traverse(point, |id| {
                if let Some(found) = self.candidate(tree.get_proxy(id), filter)
                    && found.collider.shape().contains_point(&found.pose, point)
                {
                    inside.push(found.entity);
                }
                true
            });
        }
        inside
    }

    /// All colliders whose `ColliderAabb` touches a box, in no order.
    pub fn aabb_intersections(
        &self,
        aabb: ColliderAabb,
        filter: &SpatialQueryFilter,
    ) -> Vec<Entity> {
        let mut touching = Vec::new();
        for tree in self.trees.iter_trees() {
            tree.aabb_traverse(aabb.into(), |id| {
                if let Some(found) = self.candidate(tree.get_proxy(id), filter)
                    && found.aabb.intersects(&aabb)
                {
                    touching.push(found.entity);
                }
                true
            });
        }
        touching
    }

    /// All colliders that a shape touches, in no order.
    pub fn shape_intersections(
        &self,
        shape: &BdtCollider,
        position: Vec3,
        rotation: Quat,
        filter: &SpatialQueryFilter,
    ) -> Vec<Entity> {
        let mut touching = Vec::new();
        let aabb = shape.aabb(position, rotation, 0.0);
        let at = pose(position, rotation);
        for tree in self.trees.iter_trees() {
            tree.aabb_traverse(aabb.into(), |id| {
                let Some(found) = self.candidate(tree.get_proxy(id), filter) else {
                    return true;
                };
                let pos12 = found.pose.inv_mul(&at);
                let (one, two) = (found.collider.shape(), shape.shape());
                let answer = MeshDispatcher::new().intersection_test(&pos12, one, two);
                if answer.is_ok_and(|answer| answer.intersecting) {
                    touching.push(found.entity);
                }
                true
            });
        }
        touching
    }
}

impl Candidate<'_> {
    fn ray(&self, origin: Vec3, direction: Dir3, limit: f32, solid: bool) -> Option<RayHitData> {
        let ray = Ray::new(origin, direction.into());
        let shape = self.collider.shape();
        let hit = shape.cast_ray_and_get_normal(&self.pose, &ray, limit, solid)?;
        Some(RayHitData {
            entity: self.entity,
            distance: hit.time_of_impact,
            normal: hit.normal,
        })
    }

    fn cast(
        &self,
        shape: &BdtCollider,
        start: &Pose,
        direction: Dir3,
        config: &ShapeCastConfig,
        limit: f32,
    ) -> Option<ShapeHitData> {
        let options = ShapeCastOptions {
            max_time_of_impact: limit,
            target_distance: config.target_distance,
            stop_at_penetration: !config.ignore_origin_penetration,
            compute_impact_geometry_on_penetration: config.compute_contact_on_penetration,
        };
        let pos12 = self.pose.inv_mul(start);
        let velocity = self.pose.rotation.inverse() * Vec3::from(direction);
        let (one, two) = (self.collider.shape(), shape.shape());
        let hit = MeshDispatcher::new()
            .cast_shapes(&pos12, velocity, one, two, options)
            .ok()??;
        let distance = hit.time_of_impact;
        Some(ShapeHitData {
            entity: self.entity,
            distance,
            point1: self.pose * hit.witness1,
            point2: *start * hit.witness2 + direction * distance,
            normal1: self.pose.rotation * hit.normal1,
            normal2: start.rotation * hit.normal2,
        })
    }
}
