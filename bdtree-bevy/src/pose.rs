//! Components of a deforming mesh, and the instance that queries ask.

use std::cell::RefCell;

use bdtree_runtime::{BoneMatrices, CacheSize, Instance, JointMatrix, Model, PoseError};
use bevy_asset::{Assets, Handle};
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Affine3A;
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_transform::components::{GlobalTransform, Transform};

use crate::asset::BdtModel;
use crate::bounds::Around;
use crate::faults::{PoseFaults, PoseStage};
use crate::placement::{placement, rows};

/// A mesh that deforms: the file that it is baked in. Its vertices are in mesh units in the space of the entity, whose
/// `GlobalTransform` may rotate, move, and scale all axes alike.
#[derive(Component, Reflect, Debug, Clone, Default)]
#[reflect(Component, Default, Clone)]
#[require(Deformation, Transform, PoseFaults)]
pub struct DeformingMesh(pub Handle<BdtModel>);

/// What deforms the mesh of this entity. Write it, or let a [`ClipPlayer`](crate::ClipPlayer), a
/// [`PoseFromMorphs`](crate::PoseFromMorphs) or a [`PoseFromJoints`](crate::PoseFromJoints) write it.
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
/// frame, after transforms have been propagated. A pose that the file refuses (too many or too large numbers) stands in
/// [`PoseFaults`], and the last one stays; so does a `GlobalTransform` that is no placement.
#[derive(Component, Debug)]
pub struct DeformedInstance {
    /// Placed in the world.
    pub instance: Instance,
}

/// Brings instances to the pose of their entities, where something changed, and makes new ones of models that were loaded
/// anew; writes their boxes, where they have them.
pub(crate) fn update_instances(
    models: Res<Assets<BdtModel>>,
    mut meshes: Query<(
        Entity,
        &DeformingMesh,
        Ref<Deformation>,
        Ref<GlobalTransform>,
        &mut PoseFaults,
        &mut DeformedInstance,
        Option<Around>,
    )>,
) {
    meshes.par_iter_mut().for_each(
        |(entity, mesh, deformation, transform, mut faults, mut kept, around)| {
            // A model that could not be loaded anew is still the old one here.
            let model = models.get(&mesh.0).map(|asset| &asset.model);
            let model = model.filter(|model| !is_of(&kept.instance, model));
            if model.is_none() && !deformation.is_changed() && !transform.is_changed() {
                return;
            }
            // Where the transform is that of the frame before, so is what it was turned into.
            let is_placed = !transform.is_changed() && faults.get(PoseStage::Placement).is_none();
            let mut body = if is_placed {
                Placed {
                    entity,
                    at: kept.instance.placement(),
                    faults: &mut faults,
                }
            } else {
                let Some(body) = placed(entity, &transform, &mut faults) else {
                    return;
                };
                body
            };
            if let Some(model) = model {
                if let Some(mut instance) = body.new_instance(model, &deformation) {
                    instance.user_data = kept.instance.user_data;
                    instance.collision_group = kept.instance.collision_group;
                    instance.collision_mask = kept.instance.collision_mask;
                    kept.instance = instance;
                }
            } else if deformation.is_changed() {
                body.deform(&mut kept.instance, &deformation);
            } else {
                body.place(&mut kept.instance);
            }
            if let Some(mut around) = around {
                around.update(entity, &kept.instance, &mut faults);
            }
        },
    );
}

/// Makes instances of the entities that have none yet and whose model is loaded.
pub(crate) fn make_instances(
    mut commands: Commands,
    models: Res<Assets<BdtModel>>,
    mut meshes: Query<
        (
            Entity,
            &DeformingMesh,
            &Deformation,
            &GlobalTransform,
            &mut PoseFaults,
        ),
        Without<DeformedInstance>,
    >,
) {
    for (entity, mesh, deformation, transform, mut faults) in &mut meshes {
        let made = models.get(&mesh.0).and_then(|asset| {
            placed(entity, transform, &mut faults)?.new_instance(&asset.model, deformation)
        });
        if let Some(instance) = made {
            commands
                .entity(entity)
                .insert(DeformedInstance { instance });
        }
    }
}

/// Instances go with what they were made of.
pub(crate) fn drop_instance(removed: On<Remove<DeformingMesh>>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .try_remove::<DeformedInstance>();
}

/// Whether an instance was made of this model: where the file was loaded anew its bytes lie elsewhere.
fn is_of(instance: &Instance, model: &Model) -> bool {
    instance.model().asset().id() == model.asset().id()
}

/// An entity whose transform is a placement.
struct Placed<'f, 'w> {
    entity: Entity,
    at: bdtree_runtime::Transform,
    faults: &'f mut Mut<'w, PoseFaults>,
}

/// `None`, with a fault, where the transform is none.
fn placed<'f, 'w>(
    entity: Entity,
    transform: &GlobalTransform,
    faults: &'f mut Mut<'w, PoseFaults>,
) -> Option<Placed<'f, 'w>> {
    match placement(transform) {
        Ok(at) => Some(Placed { entity, at, faults }),
        Err(why) => {
            PoseFaults::tell(faults, entity, PoseStage::Placement, Err(why));
            None
        }
    }
}

impl Placed<'_, '_> {
    /// At rest where the model refuses the deformation.
    fn new_instance(&mut self, model: &Model, deformation: &Deformation) -> Option<Instance> {
        // Systems that read share it, so none of them can use a cache.
        match Instance::with_cache(model, CacheSize::NONE) {
            Ok(mut instance) => {
                self.deform(&mut instance, deformation);
                Some(instance)
            }
            Err(why) => {
                self.tell(PoseStage::Deformation, Err(why));
                None
            }
        }
    }

    /// Deforms and places an instance; places it alone where it refuses the deformation.
    fn deform(&mut self, instance: &mut Instance, deformation: &Deformation) {
        let deformed = set_pose(instance, deformation, self.at);
        self.tell(PoseStage::Deformation, deformed);
        match deformed {
            Ok(()) => self.tell(PoseStage::Placement, Ok(())),
            Err(_) => self.place(instance),
        }
    }

    fn place(&mut self, instance: &mut Instance) {
        let at = instance.set_placement(self.at);
        self.tell(PoseStage::Placement, at);
    }

    fn tell(&mut self, stage: PoseStage, said: Result<(), PoseError>) {
        PoseFaults::tell(self.faults, self.entity, stage, said);
    }
}

/// Numbers as the runtime takes them.
#[derive(Default)]
struct Scratch {
    zeros: Vec<f32>,
    joints: Vec<JointMatrix>,
}

thread_local! {
    /// Kept, so that no frame allocates; of each thread, since instances are posed side by side.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Deforms and places an instance. An error leaves it as it was.
pub(crate) fn set_pose(
    instance: &mut Instance,
    deformation: &Deformation,
    at: bdtree_runtime::Transform,
) -> Result<(), PoseError> {
    SCRATCH.with_borrow_mut(|scratch| {
        let q = if deformation.q.is_empty() {
            scratch.zeros.clear();
            let count = instance.model().asset().mode_count();
            scratch.zeros.resize(count, 0.0);
            &scratch.zeros
        } else {
            &deformation.q
        };
        let bones = if deformation.joints.is_empty() {
            BoneMatrices::Rest
        } else {
            scratch.joints.clear();
            scratch.joints.extend(deformation.joints.iter().map(rows));
            BoneMatrices::Joints(&scratch.joints)
        };
        instance.set_pose_with_bones(q, bones, at)
    })
}
