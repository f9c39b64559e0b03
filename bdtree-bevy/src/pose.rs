//! Components of a deforming mesh, and the instance that queries ask.

use bdtree_runtime::{Instance, JointMatrix, PoseError, Transform as Placement};
use bevy_asset::{Assets, Handle};
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_log::error;
use bevy_math::Affine3A;
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_transform::components::{GlobalTransform, Transform};

use crate::asset::BdtModel;

/// A mesh that deforms: the file that it is baked in. Its vertices are in mesh units in the space of the entity.
#[derive(Component, Reflect, Debug, Clone, Default)]
#[reflect(Component, Default, Clone)]
#[require(Deformation, Transform)]
pub struct DeformingMesh(pub Handle<BdtModel>);

/// What deforms the mesh of this entity.
#[derive(Component, Reflect, Debug, Clone, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Deformation {
    /// Of each mode its coordinate: the weights of vibration modes, principal components or morph targets. Empty: 0 of all.
    pub q: Vec<f32>,
    /// Of each joint of the file its matrix, column by column, from its space to the entity's, without inverse bind matrices.
    /// Empty: the bind pose.
    pub joints: Vec<Affine3A>,
}

/// The mesh as queries see it: deformed and placed. [`BdtreeSystems::Pose`](crate::BdtreeSystems::Pose) keeps it, once a
/// frame, after transforms have been propagated.
#[derive(Component, Debug)]
pub struct DeformedInstance {
    /// Placed in the world.
    pub instance: Instance,
}

/// Brings instances to the pose of their entities, where something changed. A pose that the file refuses (too many or too
/// large numbers) is reported once per change, and the last one stays.
pub(crate) fn update_instances(
    mut commands: Commands,
    models: Res<Assets<BdtModel>>,
    mut meshes: Query<(
        Entity,
        Ref<DeformingMesh>,
        Ref<Deformation>,
        Ref<GlobalTransform>,
        Option<&mut DeformedInstance>,
    )>,
) {
    for (entity, mesh, deformation, transform, instance) in &mut meshes {
        let Some(asset) = models.get(&mesh.0) else {
            continue;
        };
        match instance {
            Some(mut kept) if !mesh.is_changed() => {
                if (deformation.is_changed() || transform.is_changed())
                    && let Err(why) = pose(&mut kept.instance, &deformation, &transform)
                {
                    error!("{entity}: {why}");
                }
            }
            _ => {
                let made = Instance::new(&asset.model).and_then(|mut instance| {
                    pose(&mut instance, &deformation, &transform)?;
                    Ok(instance)
                });
                match made {
                    Ok(instance) => {
                        commands
                            .entity(entity)
                            .insert(DeformedInstance { instance });
                    }
                    Err(why) => error!("{entity}: {why}"),
                }
            }
        }
    }
}

/// Deforms and places an instance.
fn pose(
    instance: &mut Instance,
    deformation: &Deformation,
    transform: &GlobalTransform,
) -> Result<(), PoseError> {
    let (scale, rotation, translation) = transform.to_scale_rotation_translation();
    let placement = Placement {
        scale: f64::from(scale.x),
        rotation: rotation.to_array().map(f64::from),
        translation: translation.to_array().map(f64::from),
    };
    if deformation.q.is_empty() {
        let zero = vec![0.0; instance.model().asset().mode_count()];
        instance.set_pose(&zero, placement)?;
    } else {
        instance.set_pose(&deformation.q, placement)?;
    }
    if !deformation.joints.is_empty() {
        let joints: Vec<JointMatrix> = deformation.joints.iter().map(joint).collect();
        instance.set_joints(&joints)?;
    }
    Ok(())
}

/// Row by row, as the runtime has it.
pub(crate) fn joint(matrix: &Affine3A) -> JointMatrix {
    let rows = matrix.matrix3.transpose();
    let shift = matrix.translation;
    [
        (rows.x_axis, shift.x),
        (rows.y_axis, shift.y),
        (rows.z_axis, shift.z),
    ]
    .map(|(row, shift)| [row.x, row.y, row.z, shift].map(f64::from))
}
