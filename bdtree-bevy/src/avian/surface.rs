//! The velocity of surfaces that deform: avian moves bodies out of a mesh that came nearer, and knows of no speed.

use std::collections::HashMap;

use avian3d::dynamics::solver::constraint_graph::ConstraintGraph;
use avian3d::dynamics::solver::solver_body::{SolverBodies, SolverBody};
use avian3d::prelude::*;
use bdtree_parry::DeformingMesh;
use bdtree_runtime::Workspace;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::Time;

use super::collider::{BdtCollider, pose};

/// Meshes that changed before this step.
#[derive(Resource, Debug, Default)]
pub(super) struct Surfaces {
    /// As they were.
    pub(super) before: EntityHashMap<DeformingMesh>,
    /// Those that changed before the last step: contacts that avian keeps still know of it.
    pub(super) last: EntityHashSet,
    /// Of each contact and manifold the velocity of each point on the second surface relative to that on the first.
    speeds: HashMap<(u32, usize), Vec<Vec3>>,
}

impl Surfaces {
    /// Begins a step.
    pub(super) fn begin(&mut self) {
        self.last = self.before.drain().map(|(entity, _)| entity).collect();
    }
}

/// How fast a surface moves in the world near a point of it; 0 where it does not deform.
fn velocity(
    collider: &BdtCollider,
    before: Option<&DeformingMesh>,
    place: (Vec3, Quat),
    point: Vec3,
    step_s: f32,
) -> Vec3 {
    let moved = collider.mesh().zip(before).and_then(|(now, before)| {
        let local = pose(place.0, place.1).inverse_transform_point(point);
        let own = now.pose();
        let mut workspace = Workspace::new();
        let found = own
            .query(&mut workspace)
            .project_point(local.to_array().map(f64::from), f64::INFINITY);
        let found = found.ok()??;
        let [now, before] = [own, before.pose()].map(|pose| pose.deformed_triangle(found.triangle));
        let (now, before) = (now.ok()?, before.ok()?);
        let axis = |k: usize| {
            let each = (0..3).map(|c| found.barycentric[c] * (now[c][k] - before[c][k]));
            each.sum::<f64>() as f32
        };
        Some(Vec3::new(axis(0), axis(1), axis(2)))
    });
    place.1 * (moved.unwrap_or_default() / step_s)
}

/// After the narrow phase: how fast surfaces move at contacts, and friction along them.
pub(super) fn find_speeds(
    mut surfaces: ResMut<Surfaces>,
    mut contacts: ResMut<ContactGraph>,
    colliders: Query<(&BdtCollider, &Position, &Rotation)>,
    time: Res<Time>,
) {
    let surfaces = &mut *surfaces;
    surfaces.speeds.clear();
    let step_s = time.delta_secs();
    if surfaces.before.is_empty() || !(step_s > 0.0) {
        return;
    }
    for pair in contacts.iter_active_touching_mut() {
        let sides = [pair.collider1, pair.collider2];
        let before = sides.map(|side| surfaces.before.get(&side));
        let (true, Ok(found)) = (
            before.iter().any(Option::is_some),
            colliders.get_many(sides),
        ) else {
            continue;
        };
        let speed = |side: usize, point: Vec3| {
            let (collider, position, rotation) = found[side];
            let place = (position.0, rotation.0);
            velocity(collider, before[side], place, point, step_s)
        };
        for (index, manifold) in pair.manifolds.iter_mut().enumerate() {
            let points = manifold.points.iter();
            let speeds: Vec<Vec3> = points
                .map(|point| speed(1, point.point) - speed(0, point.point))
                .collect();
            let mean = speeds.iter().sum::<Vec3>() / speeds.len().max(1) as f32;
            manifold.tangent_velocity += mean;
            surfaces.speeds.insert((pair.contact_id.0, index), speeds);
        }
    }
}

/// After the substeps: bodies that were moved out of a surface get at least its speed away from it.
pub(super) fn throw(
    surfaces: Res<Surfaces>,
    mut constraints: ResMut<ConstraintGraph>,
    mut bodies: ResMut<SolverBodies>,
) {
    if surfaces.speeds.is_empty() {
        return;
    }
    let all = constraints.colors.iter_mut();
    for constraint in all.flat_map(|color| &mut color.contact_constraints) {
        let key = (constraint.contact_id.0, constraint.manifold_index);
        let Some(speeds) = surfaces.speeds.get(&key) else {
            continue;
        };
        let normal = constraint.normal;
        let indices = [constraint.body_index1, constraint.body_index2];
        for (point, speed) in constraint.points.iter_mut().zip(speeds) {
            if point.normal_part.total_impulse <= 0.0 {
                continue;
            }
            let anchors = [point.anchor1, point.anchor2];
            let own = |k: usize| {
                let body: Option<&SolverBody> = bodies.get(indices[k]);
                body.map_or(Vec3::ZERO, |body| body.velocity_at_point(anchors[k]))
            };
            let apart = (own(1) - own(0) + *speed).dot(normal);
            // Where bodies part faster than surfaces, nothing is missing.
            if apart >= 0.0 || speed.dot(normal) >= 0.0 {
                continue;
            }
            let impulse = normal * (-apart * point.normal_part.effective_mass);
            point.normal_part.total_impulse += impulse.dot(normal);
            for (k, sign) in [(0, -1.0_f32), (1, 1.0)] {
                let Some(inertia) = bodies.get_inertia(indices[k]) else {
                    continue;
                };
                let turned = inertia.effective_inv_angular_inertia() * anchors[k].cross(impulse);
                let moved = inertia.effective_inv_mass() * impulse;
                if let Some(body) = bodies.get_mut(indices[k]) {
                    body.linear_velocity += moved * sign;
                    body.angular_velocity += turned * sign;
                }
            }
        }
    }
}
