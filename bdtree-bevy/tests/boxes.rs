//! Boxes of entities, from the instances of the library.

use bdtree_bevy::{BdtreeSystems, Deformation, DeformedInstance};
use bdtree_runtime::{Instance, Transform as Placement};
use bevy_app::{App, PostUpdate};
use bevy_camera::primitives::Aabb;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;

/// Writes each entity's box in its own space.
pub(crate) fn write(app: &mut App) {
    app.add_systems(PostUpdate, update.in_set(BdtreeSystems::Bounds));
}

fn update(
    mut commands: Commands,
    changed: Query<
        (Entity, &DeformedInstance),
        Or<(Changed<Deformation>, Added<DeformedInstance>)>,
    >,
) {
    for (entity, DeformedInstance { instance }) in &changed {
        let mut local = Instance::new(instance.model()).unwrap();
        local.set_pose(instance.q(), Placement::IDENTITY).unwrap();
        let found = local.aabb().unwrap();
        let [min, max] = [found.min, found.max].map(|v| Vec3::from_array(v.map(|x| x as f32)));
        commands.entity(entity).insert(Aabb::from_min_max(min, max));
    }
}
