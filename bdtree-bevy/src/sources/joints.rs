//! Joints of Bevy's skinned meshes.

use bdtree_runtime::{Asset, AssetId};
use bevy_asset::Assets;
use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Affine3A;
use bevy_mesh::skinning::SkinnedMesh;
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_transform::components::GlobalTransform;
use thiserror::Error;

use crate::asset::BdtModel;
use crate::faults::{PoseFaults, PoseStage};
use crate::placement::{affine, placement, rows};
use crate::pose::{Deformation, DeformingMesh};

/// Takes the joints of the [`Deformation`] from the entities of the entity's `SkinnedMesh`, in
/// [`BdtreeSystems::Sources`](crate::BdtreeSystems::Sources): their `GlobalTransform`s, whatever scale and shear they have,
/// as seen from this entity. Inverse bind matrices are those of the file.
#[derive(Component, Reflect, Debug, Clone, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Deformation, JointMap)]
pub struct PoseFromJoints {
    /// Which joint of the file each entity is.
    pub order: JointOrder,
}

/// Which of the entities of a `SkinnedMesh` each joint of the file is.
#[derive(Reflect, Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum JointOrder {
    /// Entity i is joint i, and there are as many: files that `bdtree-build` makes of the same glTF skin.
    #[default]
    InOrder,
    /// The entity whose `Name` is the joint's; the first of several. Other entities are passed over.
    ByName,
}

/// Of each joint of the file its place in the list of entities, and the file that it was found for.
#[derive(Component, Debug, Default)]
pub(crate) struct JointMap {
    found_for: Option<AssetId>,
    places: Vec<usize>,
    /// The joints of this frame.
    next: Vec<Affine3A>,
}

/// Why joints are not taken.
#[derive(Debug, Error)]
enum JointError {
    #[error("PoseFromJoints: the file has no skin")]
    NoSkin,
    #[error("PoseFromJoints: the SkinnedMesh has {found} joints, the file has {expected}")]
    Count { expected: usize, found: usize },
    #[error(
        "PoseFromJoints: no entity of the SkinnedMesh is named {0:?}, as a joint of the file is"
    )]
    Name(String),
    #[error("PoseFromJoints: joint {index} of the SkinnedMesh, {entity}, has no GlobalTransform")]
    NoTransform { index: usize, entity: Entity },
}

/// Writes joints into deformations.
pub(crate) fn read_joints(
    models: Res<Assets<BdtModel>>,
    names: Query<&Name>,
    transforms: Query<&GlobalTransform>,
    mut bodies: Query<(
        Entity,
        &DeformingMesh,
        Ref<PoseFromJoints>,
        Ref<SkinnedMesh>,
        &GlobalTransform,
        &mut JointMap,
        &mut Deformation,
        &mut PoseFaults,
    )>,
) {
    bodies.par_iter_mut().for_each(
        |(entity, mesh, source, skin, own, mut map, mut deformation, mut faults)| {
            let Some(asset) = models.get(&mesh.0) else {
                return;
            };
            if source.is_changed() || skin.is_changed() {
                map.found_for = None;
            }
            // Where this entity cannot stand, its instance says so.
            let Ok(at) = placement(own) else {
                return;
            };
            let read = map
                .find(asset.model.asset(), source.order, &skin.joints, &names)
                .and_then(|()| map.write(&at, &skin.joints, &transforms, &mut deformation));
            PoseFaults::tell(&mut faults, entity, PoseStage::Joints, read);
        },
    );
}

impl JointMap {
    /// Of each joint its entity, unless that is known.
    fn find(
        &mut self,
        asset: &Asset<'_>,
        order: JointOrder,
        entities: &[Entity],
        names: &Query<&Name>,
    ) -> Result<(), JointError> {
        if self.found_for == Some(asset.id()) {
            return Ok(());
        }
        let skeleton = asset.skeleton().ok_or(JointError::NoSkin)?;
        let count = skeleton.joint_count();
        self.places = match order {
            JointOrder::InOrder if entities.len() != count => {
                return Err(JointError::Count {
                    expected: count,
                    found: entities.len(),
                });
            }
            JointOrder::InOrder => (0..count).collect(),
            JointOrder::ByName => {
                let place = |joint: usize| {
                    let wanted = skeleton.joint_name(joint).unwrap_or_default();
                    let is_it = |entity: &Entity| {
                        names.get(*entity).is_ok_and(|name| name.as_str() == wanted)
                    };
                    let place = entities.iter().position(is_it);
                    place.ok_or_else(|| JointError::Name(wanted.to_string()))
                };
                (0..count).map(place).collect::<Result<_, _>>()?
            }
        };
        self.found_for = Some(asset.id());
        Ok(())
    }

    /// Changes the deformation only where a joint differs from it.
    fn write(
        &mut self,
        at: &bdtree_runtime::Transform,
        entities: &[Entity],
        transforms: &Query<&GlobalTransform>,
        deformation: &mut Mut<'_, Deformation>,
    ) -> Result<(), JointError> {
        self.next.clear();
        for index in self.places.iter().copied() {
            let entity = entities[index];
            let Ok(world) = transforms.get(entity) else {
                return Err(JointError::NoTransform { index, entity });
            };
            let joint = at.joint_in_model(&rows(&world.affine()));
            self.next.push(affine(&joint));
        }
        if deformation.joints != self.next {
            std::mem::swap(&mut deformation.joints, &mut self.next);
        }
        Ok(())
    }
}
