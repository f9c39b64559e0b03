//! Colliders follow their entities.

use avian3d::collision::collider::ScalableCollider;
use avian3d::collision::collider::collider_transform::ColliderTransform;
use avian3d::dynamics::solver::islands::BodyIslandNode;
use avian3d::prelude::*;
use bdtree_parry::ShapeError;
use bdtree_runtime::PoseError;
use bevy_asset::{AssetEvent, Assets};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::message::MessageReader;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_transform::components::Transform;

use super::collider::{BdtCollider, deformed, uniform};
use super::flexible::FlexibleModes;
use super::surface::Surfaces;
use crate::asset::BdtModel;
use crate::faults::{PoseFaults, PoseStage};
use crate::pose::{Deformation, DeformingMesh};
use crate::shape::ShapeModels;

/// Gives a [`DeformingMesh`] a [`BdtCollider`] that takes the entity's [`Deformation`] before every physics step, once the
/// file is loaded. The scale of the entity has to be the same along all axes.
#[derive(Component, Reflect, Debug, Clone, Copy, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(DeformingMesh)]
pub struct DeformingCollider;

/// A `Collider` of avian becomes one of ours.
pub(super) fn take_collider(
    trigger: On<Insert<Collider>>,
    colliders: Query<&Collider>,
    mut commands: Commands,
) {
    if let Ok(collider) = colliders.get(trigger.entity) {
        commands
            .entity(trigger.entity)
            .try_insert(BdtCollider::Rigid(collider.clone()));
    }
}

/// And goes with it.
pub(super) fn drop_collider(trigger: On<Remove<Collider>>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(trigger.entity) {
        entity.try_remove::<BdtCollider>();
    }
}

/// As does that of a mesh.
pub(super) fn drop_mesh(trigger: On<Remove<DeformingCollider>>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(trigger.entity) {
        entity.try_remove::<BdtCollider>();
    }
}

/// `Collider`s that the program changed.
pub(super) fn follow_colliders(
    mut changed: Query<(Ref<Collider>, &mut BdtCollider), Changed<Collider>>,
) {
    for (collider, mut own) in &mut changed {
        if !collider.is_added() {
            *own = BdtCollider::Rigid((*collider).clone());
        }
    }
}

/// avian's own queries and sweeps ask the `Collider`: it gets the scale that ours has.
pub(super) fn scale_colliders(
    mut changed: Query<(&BdtCollider, &mut Collider), Changed<BdtCollider>>,
) {
    for (own, mut collider) in &mut changed {
        let scale = own.scale();
        if collider.scale() != scale {
            collider.bypass_change_detection().set_scale(scale, 10);
        }
    }
}

/// Deformed meshes. A pose that the file refuses is reported, and the last one stays.
pub(super) fn follow_meshes(
    mut commands: Commands,
    assets: Res<Assets<BdtModel>>,
    mut models: ResMut<ShapeModels>,
    mut reloads: MessageReader<AssetEvent<BdtModel>>,
    mut surfaces: ResMut<Surfaces>,
    mut meshes: Query<
        (
            Entity,
            Ref<DeformingMesh>,
            Ref<Deformation>,
            &Transform,
            Option<&ColliderTransform>,
            Has<ChildOf>,
            Option<&mut BdtCollider>,
            Option<&FlexibleModes>,
            &mut PoseFaults,
        ),
        With<DeformingCollider>,
    >,
) {
    surfaces.begin();
    let changed: Vec<_> = (reloads.read())
        .filter_map(|event| match event {
            AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (entity, mesh, deformation, transform, own, is_child, collider, modes, mut faults) in
        &mut meshes
    {
        let is_new = mesh.is_changed() || changed.contains(&mesh.0.id()) || collider.is_none();
        // Modes bring their colliders up to date themselves.
        let is_own = modes.is_some_and(|modes| modes.q() == deformation.q);
        if !is_new && (is_own || !deformation.is_changed()) {
            continue;
        }
        // What avian scales the colliders of children by, as far as it knows it.
        let scale = match own {
            Some(own) if is_child => own.scale,
            _ => transform.scale,
        };
        let made = collider_of(&assets, &mut models, &mesh, &deformation, scale);
        let Some(made) = made else {
            continue;
        };
        let said = made.as_ref().map(|_| ());
        PoseFaults::tell(&mut faults, entity, PoseStage::Collider, said);
        match (made, collider) {
            (Err(_), _) => {}
            (Ok(made), Some(mut collider)) => {
                let is_same = collider.scale() == made.scale() && !is_new && modes.is_none();
                if let Some(before) = collider.mesh().filter(|_| is_same) {
                    surfaces.before.insert(entity, before.clone());
                }
                *collider = made;
            }
            (Ok(made), None) => {
                commands.entity(entity).try_insert(made);
            }
        }
    }
}

/// The collider of a mesh at a scale, once its file is loaded.
fn collider_of(
    assets: &Assets<BdtModel>,
    models: &mut ShapeModels,
    mesh: &DeformingMesh,
    deformation: &Deformation,
    scale: Vec3,
) -> Option<Result<BdtCollider, ShapeError>> {
    let Some(factor) = uniform(scale) else {
        return Some(Err(PoseError::Scale.into()));
    };
    let model = models.get(assets, mesh.0.id(), factor)?;
    let shape = model.and_then(|model| deformed(&model, deformation));
    Some(shape.map(|shape| BdtCollider::deforming(shape, 1.0, scale, Some(deformation.clone()))))
}

/// Whatever touches a mesh that deforms stays awake or wakes up. Dynamic
/// flexible bodies fall asleep with what they touch, and their modes with them.
pub(super) fn wake_touched(
    changed: Query<
        (Entity, Option<&RigidBody>, Has<FlexibleModes>),
        (Changed<BdtCollider>, With<DeformingCollider>),
    >,
    contacts: Res<ContactGraph>,
    mut bodies: Query<(&mut SleepTimer, Has<Sleeping>), With<BodyIslandNode>>,
    mut commands: Commands,
) {
    let changed: EntityHashSet = (changed.iter())
        .filter(|(_, body, is_flexible)| !(*is_flexible && body.is_some_and(RigidBody::is_dynamic)))
        .map(|(entity, ..)| entity)
        .collect();
    if changed.is_empty() {
        return;
    }
    for pair in (contacts.iter_sleeping()).chain(contacts.iter_active_touching()) {
        if !changed.contains(&pair.collider1) && !changed.contains(&pair.collider2) {
            continue;
        }
        for body in [pair.body1, pair.body2].into_iter().flatten() {
            let Ok((mut timer, is_asleep)) = bodies.get_mut(body) else {
                continue;
            };
            timer.0 = 0.0;
            if is_asleep {
                commands.queue(WakeBody(body));
            }
        }
    }
}

/// avian keeps the contacts of bodies that hardly moved: those of shapes that changed, now or last, are found anew.
pub(super) fn renew_contacts(
    changed: Query<Entity, Changed<BdtCollider>>,
    surfaces: Res<Surfaces>,
    mut contacts: ResMut<ContactGraph>,
) {
    let changed: EntityHashSet = changed
        .iter()
        .chain(surfaces.last.iter().copied())
        .collect();
    if changed.is_empty() {
        return;
    }
    for pair in contacts.active_pairs_mut() {
        if changed.contains(&pair.collider1) || changed.contains(&pair.collider2) {
            pair.recycling_cache = None;
        }
    }
}
