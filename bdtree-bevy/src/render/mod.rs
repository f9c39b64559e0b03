//! Drawing: vertices are deformed on the GPU and written to the vertex buffers that Bevy draws from.
//!
//! Each drawn entity has a `Mesh` of its own with the rest vertices, so all of Bevy's pipelines, shadows and materials treat
//! it as any other mesh. Each frame, compute passes of `bdtree-gpu` deform the entities whose pose changed, and a pass of this
//! crate writes positions, normals and tangents over the rest vertices, where Bevy's mesh allocator keeps them. Nothing is read back.

mod deform;
mod extract;
mod surface;
mod tangents;
mod windows;
mod write;

use bevy_app::{App, PostUpdate};
use bevy_asset::{AssetEventSystems, Assets};
use bevy_ecs::prelude::*;
use bevy_mesh::Mesh;
use bevy_render::mesh::allocator::MeshAllocator;
use bevy_render::{
    ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems, init_gpu_resource,
};

use crate::BdtreeSystems;

pub use surface::DrawDeformed;

/// What a program with a renderer needs; nothing in one without.
pub(crate) fn finish(app: &mut App) {
    let Some(render) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render
        .init_resource::<extract::Bodies>()
        .add_systems(
            RenderStartup,
            (
                deform::allow_writes.before(init_gpu_resource::<MeshAllocator>),
                deform::start,
            ),
        )
        .add_systems(ExtractSchedule, extract::extract)
        .add_systems(
            Render,
            deform::deform.in_set(RenderSystems::PrepareResources),
        );
    app.add_systems(
        PostUpdate,
        surface::update_surfaces
            .run_if(resource_exists::<Assets<Mesh>>)
            .before(BdtreeSystems::Pose)
            // The renderer hears of new meshes in the frame in which their entities have them: one that it draws before is
            // not drawn later either.
            .before(AssetEventSystems),
    );
}
