//! Weights of Bevy's morph targets.

use bdtree_runtime::{Asset, AssetId};
use bevy_asset::{AssetId as HandleId, Assets};
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy_mesh::{Mesh, Mesh3d};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use thiserror::Error;

use crate::asset::BdtModel;
use crate::faults::{PoseFaults, PoseStage};
use crate::pose::{Deformation, DeformingMesh};

/// Takes q from the weights of Bevy's morph targets, in [`BdtreeSystems::Sources`](crate::BdtreeSystems::Sources): those of
/// the entity's `MeshMorphWeights`, or, where it refers to another entity, of that one's `MorphWeights`; without
/// `MeshMorphWeights`, of its own `MorphWeights`. Modes that no target maps to keep their q.
#[derive(Component, Reflect, Debug, Clone, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Deformation, MorphMap)]
pub struct PoseFromMorphs {
    /// Which mode each target is.
    pub order: MorphOrder,
}

/// Which mode of the file each morph target of Bevy's mesh is.
#[derive(Reflect, Debug, Clone, Default, PartialEq, Eq)]
pub enum MorphOrder {
    /// Target i is mode i, and there are as many: files that `bdtree-build` makes of the same glTF mesh.
    #[default]
    InOrder,
    /// The names of the targets, in order, as the file calls its modes.
    Named(Vec<String>),
    /// The names that the mesh asset of the entity's `Mesh3d` has for its targets.
    NamesOfMesh,
}

/// Of each target its mode, and what that was found for.
#[derive(Component, Debug, Default)]
pub(crate) struct MorphMap {
    found_for: Option<(AssetId, Option<HandleId<Mesh>>, usize)>,
    modes: Vec<usize>,
}

/// Why weights are not taken.
#[derive(Debug, Error)]
enum MorphError {
    #[error("PoseFromMorphs: the entity has neither MeshMorphWeights nor MorphWeights")]
    NoWeights,
    #[error("PoseFromMorphs: {0}, to which MeshMorphWeights refers, has no MorphWeights")]
    NoReferred(Entity),
    #[error("PoseFromMorphs: the mesh has {found} morph targets, the file has {expected} modes")]
    Count { expected: usize, found: usize },
    #[error("PoseFromMorphs: {found} names for {expected} morph targets")]
    NameCount { expected: usize, found: usize },
    #[error("PoseFromMorphs: the file has no mode {0:?}: its modes are {1}")]
    Name(String, String),
    #[error("PoseFromMorphs: the entity's mesh does not name its morph targets")]
    NoNames,
}

/// Writes weights into deformations.
pub(crate) fn read_morphs(
    models: Res<Assets<BdtModel>>,
    meshes: Option<Res<Assets<Mesh>>>,
    weights: Query<&MorphWeights>,
    mut bodies: Query<(
        Entity,
        &DeformingMesh,
        Ref<PoseFromMorphs>,
        Option<&MeshMorphWeights>,
        Option<&Mesh3d>,
        &mut MorphMap,
        &mut Deformation,
        &mut PoseFaults,
    )>,
) {
    let meshes = meshes.as_deref();
    bodies.par_iter_mut().for_each(
        |(entity, body, source, own, mesh, mut map, mut deformation, mut faults)| {
            let Some(asset) = models.get(&body.0) else {
                return;
            };
            if source.is_changed() {
                map.found_for = None;
            }
            let read = weights_of(entity, own, &weights).and_then(|weights| {
                map.find(
                    asset.model.asset(),
                    &source.order,
                    weights.len(),
                    mesh,
                    meshes,
                )?;
                map.write(weights, asset.model.asset().mode_count(), &mut deformation);
                Ok(())
            });
            PoseFaults::tell(&mut faults, entity, PoseStage::Morphs, read);
        },
    );
}

fn weights_of<'w>(
    entity: Entity,
    own: Option<&'w MeshMorphWeights>,
    weights: &'w Query<&MorphWeights>,
) -> Result<&'w [f32], MorphError> {
    match own {
        Some(MeshMorphWeights::Value { weights }) => Ok(weights),
        Some(MeshMorphWeights::Reference(other)) => match weights.get(*other) {
            Ok(weights) => Ok(weights.weights()),
            Err(_) => Err(MorphError::NoReferred(*other)),
        },
        None => match weights.get(entity) {
            Ok(weights) => Ok(weights.weights()),
            Err(_) => Err(MorphError::NoWeights),
        },
    }
}

impl MorphMap {
    /// Of each target its mode, unless that is known.
    fn find(
        &mut self,
        asset: &Asset<'_>,
        order: &MorphOrder,
        count: usize,
        mesh: Option<&Mesh3d>,
        meshes: Option<&Assets<Mesh>>,
    ) -> Result<(), MorphError> {
        let wanted = (asset.id(), mesh.map(|mesh| mesh.0.id()), count);
        if self.found_for == Some(wanted) {
            return Ok(());
        }
        self.found_for = None;
        let names = match order {
            MorphOrder::InOrder => {
                let expected = asset.mode_count();
                if count != expected {
                    return Err(MorphError::Count {
                        expected,
                        found: count,
                    });
                }
                self.modes = (0..count).collect();
                self.found_for = Some(wanted);
                return Ok(());
            }
            MorphOrder::Named(names) => names,
            MorphOrder::NamesOfMesh => {
                let mesh = mesh.and_then(|mesh| meshes?.get(&mesh.0));
                // What the renderer took away cannot be read any more.
                let names = mesh.and_then(|mesh| mesh.try_morph_target_names().ok().flatten());
                names.ok_or(MorphError::NoNames)?
            }
        };
        if names.len() != count {
            return Err(MorphError::NameCount {
                expected: count,
                found: names.len(),
            });
        }
        let mode = |name: &String| {
            asset.mode_index(name).ok_or_else(|| {
                let own: Vec<_> = asset.mode_names().flatten().collect();
                MorphError::Name(name.clone(), format!("{own:?}"))
            })
        };
        self.modes = names.iter().map(mode).collect::<Result<_, _>>()?;
        self.found_for = Some(wanted);
        Ok(())
    }

    /// Changes the deformation only where weights differ from it.
    fn write(&self, weights: &[f32], mode_count: usize, deformation: &mut Mut<'_, Deformation>) {
        let is_same = deformation.q.len() == mode_count
            && (self.modes.iter().zip(weights)).all(|(mode, w)| deformation.q[*mode] == *w);
        if is_same {
            return;
        }
        deformation.q.resize(mode_count, 0.0);
        for (mode, weight) in self.modes.iter().zip(weights) {
            deformation.q[*mode] = *weight;
        }
    }
}
