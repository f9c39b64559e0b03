//! The `Mesh` of each drawn entity.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bdtree_runtime::{Model, TriangleId};
use bevy_asset::{AssetId, Assets, Handle, RenderAssetUsages};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::NoAutoAabb;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Vec3A;
use bevy_mesh::{Indices, Mesh, Mesh3d, PrimitiveTopology, VertexFormat};
use bevy_pbr::{MeshMaterial3d, StandardMaterial};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use thiserror::Error;

use super::tangents::Tangents;
use crate::asset::BdtModel;
use crate::faults::{PoseFaults, PoseStage};
use crate::pose::DeformingMesh;

/// The deformed mesh of this entity is drawn. Not needed beside a `MeshMaterial3d<StandardMaterial>`, only for other
/// materials.
///
/// The entity gets a [`Mesh3d`] of its own. Where it has one already, that mesh is its surface and gives triangles, texture
/// coordinates, colors and tangents: vertex i is vertex i of the `.bdt` file, positions and normals are written over, and
/// tangents (`Float32x4`, of a list of triangles) go with the triangles around them. It must have as many vertices as the
/// file, positions and normals as `Float32x3`, and be there for the main world (`RenderAssetUsages::MAIN_WORLD`). One that
/// does not fit is drawn as it is, and stands in the entity's [`PoseFaults`].
#[derive(Component, Reflect, Debug, Clone, Copy, Default)]
#[reflect(Component, Default, Clone)]
pub struct DrawDeformed;

/// The mesh that was made for an entity.
#[derive(Component, Debug)]
pub(crate) struct Surface {
    /// What it was made of.
    pub(crate) model: Model,
    asset: AssetId<BdtModel>,
    /// What the program gave, if it gave one.
    template: Option<Handle<Mesh>>,
    own: Handle<Mesh>,
    /// How the template's tangents follow, if it has any.
    pub(crate) tangents: Option<Arc<Tangents>>,
}

/// Why a program's mesh is not drawn deformed.
#[derive(Debug, Clone, Error)]
enum TemplateError {
    #[error(
        "the Mesh3d has {found} vertices and the .bdt file {expected}: vertex i of one must be vertex i of the other. \
         Without a Mesh3d, the file's own mesh is drawn"
    )]
    Count { expected: usize, found: usize },
    #[error("the Mesh3d has no {0} as Float32x3")]
    Format(&'static str),
    #[error(
        "the Mesh3d is in the render world alone: make it with RenderAssetUsages::MAIN_WORLD, too"
    )]
    Extracted,
}

/// A mesh to be drawn, of which each entity gets a copy.
struct Made {
    mesh: Mesh,
    tangents: Option<Arc<Tangents>>,
}

/// Until there is a box of the pose: Bevy's culling on the GPU may drop meshes that have none.
const EVERYWHERE: Aabb = Aabb {
    center: Vec3A::ZERO,
    half_extents: Vec3A::splat(1e9),
};

/// Makes the meshes of entities that are to be drawn, where there is none or its file or template changed.
pub(crate) fn update_surfaces(
    mut commands: Commands,
    models: Res<Assets<BdtModel>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut drawn: Query<
        (
            Entity,
            &DeformingMesh,
            Option<&Mesh3d>,
            Option<&Surface>,
            &mut PoseFaults,
        ),
        Or<(
            With<DrawDeformed>,
            With<MeshMaterial3d<StandardMaterial>>,
            With<Surface>,
        )>,
    >,
    orphans: Query<(Entity, &Surface), Without<DeformingMesh>>,
    mut shared: Local<HashMap<AssetId<Mesh>, Weak<Tangents>>>,
) {
    // Many entities share a file.
    let mut made: HashMap<_, Option<Result<Made, TemplateError>>> = HashMap::new();
    for (entity, deforming, mesh, surface, mut faults) in &mut drawn {
        let Some(BdtModel { model }) = models.get(&deforming.0) else {
            continue;
        };
        let asset = deforming.0.id();
        // A mesh that is not the one made here is the program's.
        let template = match (mesh, surface) {
            (Some(mesh), Some(surface)) if mesh.0 == surface.own => surface.template.clone(),
            (mesh, _) => mesh.map(|mesh| mesh.0.clone()),
        };
        let is_current = surface.is_some_and(|surface| {
            surface.asset == asset
                && surface.model.asset().id() == model.asset().id()
                && surface.template == template
                && mesh.is_some_and(|mesh| mesh.0 == surface.own)
        });
        if is_current {
            continue;
        }
        let key = (asset, template.as_ref().map(Handle::id));
        let new = made.entry(key).or_insert_with(|| match &template {
            None => Some(Ok(Made {
                mesh: rest_mesh(model),
                tangents: None,
            })),
            Some(template) => {
                let made = from_template(model, meshes.get(template)?);
                Some(made.map(|made| made.sharing(template.id(), &mut shared)))
            }
        });
        // Later, where the template is not loaded yet.
        let Some(new) = new else {
            continue;
        };
        let said = new.as_ref().map(|_| ());
        PoseFaults::tell(&mut faults, entity, PoseStage::Drawing, said);
        let Ok(new) = new else {
            continue;
        };
        let own = meshes.add(new.mesh.clone());
        let surface = Surface {
            model: model.clone(),
            asset,
            template,
            own: own.clone(),
            tangents: new.tangents.clone(),
        };
        // Bevy would take the box of the rest vertices.
        commands
            .entity(entity)
            .insert((Mesh3d(own), surface, NoAutoAabb))
            .insert_if_new(EVERYWHERE);
    }
    for (entity, surface) in &orphans {
        let mut entity = commands.entity(entity);
        entity.remove::<(Surface, NoAutoAabb)>();
        match &surface.template {
            Some(template) => entity.insert(Mesh3d(template.clone())),
            None => entity.remove::<Mesh3d>(),
        };
    }
}

/// The file's mesh at rest. Only the renderer has it: its vertices are written there.
fn rest_mesh(model: &Model) -> Mesh {
    let asset = model.asset();
    let (origin, unit) = (asset.origin(), asset.unit());
    let in_mesh_units = |p: &[f32; 3]| -> [f32; 3] {
        [0, 1, 2].map(|k| (origin[k] + f64::from(p[k]) * unit) as f32)
    };
    let positions: Vec<[f32; 3]> = asset.positions().iter().map(in_mesh_units).collect();
    let corners = (0..asset.triangle_count() as u32)
        .filter_map(|id| asset.triangle(TriangleId(id)).ok())
        .filter(|corners| corners.iter().all(|v| (v.0 as usize) < positions.len()))
        .flatten();
    let indices = Indices::U32(corners.map(|v| v.0).collect());
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_NORMAL,
        vec![[0.0_f32, 1.0, 0.0]; positions.len()],
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(indices)
}

/// A program's mesh as one that can be written over.
fn from_template(model: &Model, template: &Mesh) -> Result<Made, TemplateError> {
    for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        let values = match template.try_attribute_option(attribute.id) {
            Ok(values) => values,
            Err(_) => return Err(TemplateError::Extracted),
        };
        if values.map(VertexFormat::from) != Some(VertexFormat::Float32x3) {
            return Err(TemplateError::Format(attribute.name));
        }
    }
    let expected = model.asset().vertex_count();
    let found = template.count_vertices();
    if found != expected {
        return Err(TemplateError::Count { expected, found });
    }
    let mut mesh = template.clone();
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let tangents = Tangents::of(&mesh).map(Arc::new);
    Ok(Made { mesh, tangents })
}

impl Made {
    /// With the tangents that entities of the same template have already, so that there is one of them on the device.
    fn sharing(
        mut self,
        template: AssetId<Mesh>,
        shared: &mut HashMap<AssetId<Mesh>, Weak<Tangents>>,
    ) -> Self {
        shared.retain(|_, tangents| tangents.strong_count() > 0);
        if let Some(own) = &self.tangents {
            match shared.get(&template).and_then(Weak::upgrade) {
                Some(other) if other == *own => self.tangents = Some(other),
                _ => {
                    shared.insert(template, Arc::downgrade(own));
                }
            }
        }
        self
    }
}
