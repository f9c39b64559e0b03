//! The `Mesh` of each drawn entity.

use std::collections::HashMap;

use bdtree_runtime::{Model, TriangleId};
use bevy_asset::{AssetId, Assets, Handle, RenderAssetUsages};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::NoAutoAabb;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_log::error;
use bevy_math::Vec3A;
use bevy_mesh::{Indices, Mesh, Mesh3d, PrimitiveTopology, VertexFormat};
use bevy_pbr::{MeshMaterial3d, StandardMaterial};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;

use crate::asset::BdtModel;
use crate::pose::DeformingMesh;

/// The deformed mesh of this entity is drawn. Not needed beside a `MeshMaterial3d<StandardMaterial>`, only for other
/// materials.
///
/// The entity gets a [`Mesh3d`] of its own. Where it has one already, that mesh is its surface and gives triangles, texture
/// coordinates and colors: vertex i is vertex i of the `.bdt` file, and positions and normals are written over. It must have
/// as many vertices as the file, both attributes as `Float32x3`, and be there for the main world
/// (`RenderAssetUsages::MAIN_WORLD`).
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
    drawn: Query<
        (Entity, &DeformingMesh, Option<&Mesh3d>, Option<&Surface>),
        Or<(
            With<DrawDeformed>,
            With<MeshMaterial3d<StandardMaterial>>,
            With<Surface>,
        )>,
    >,
    orphans: Query<(Entity, &Surface), Without<DeformingMesh>>,
) {
    // Many entities share a file.
    let mut made: HashMap<(AssetId<BdtModel>, Option<AssetId<Mesh>>), Option<Mesh>> =
        HashMap::new();
    for (entity, deforming, mesh, surface) in &drawn {
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
            None => Some(rest_mesh(model)),
            Some(template) => from_template(model, meshes.get(template)?),
        });
        let Some(new) = new else {
            continue;
        };
        let own = meshes.add(new.clone());
        let surface = Surface {
            model: model.clone(),
            asset,
            template,
            own: own.clone(),
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

/// A program's mesh as one that can be written over; `None` is reported.
fn from_template(model: &Model, template: &Mesh) -> Option<Mesh> {
    let expected = model.asset().vertex_count();
    let found = template.count_vertices();
    if found != expected {
        error!("a deforming mesh has {expected} vertices, the Mesh3d beside it {found}");
        return None;
    }
    for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        let values = template.attribute(attribute.id);
        if values.map(VertexFormat::from) != Some(VertexFormat::Float32x3) {
            error!(
                "the Mesh3d beside a deforming mesh has no {} as Float32x3",
                attribute.name
            );
            return None;
        }
    }
    let mut mesh = template.clone();
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    Some(mesh)
}
