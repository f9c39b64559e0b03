//! Poses on their way to the renderer.

use std::collections::HashMap;
use std::sync::Arc;

use bdtree_runtime::{JointMatrix, Model};
use bevy_asset::AssetId;
use bevy_ecs::prelude::*;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_render::Extract;

use super::surface::Surface;
use super::tangents::Tangents;
use crate::placement::rows;
use crate::pose::Deformation;

/// Entities of the main world that are drawn deformed.
#[derive(Resource, Default)]
pub(crate) struct Bodies(pub(crate) HashMap<Entity, Body>);

/// A drawn entity.
pub(crate) struct Body {
    pub(crate) model: Model,
    pub(crate) mesh: AssetId<Mesh>,
    /// Of that mesh, if it has any.
    pub(crate) tangents: Option<Arc<Tangents>>,
    /// Of all modes.
    pub(crate) q: Vec<f32>,
    /// Empty: the bind pose.
    pub(crate) joints: Vec<JointMatrix>,
    /// Its vertices in the renderer are not those of this pose.
    pub(crate) is_stale: bool,
}

/// Takes over the poses that changed.
pub(crate) fn extract(
    mut bodies: ResMut<Bodies>,
    changed: Extract<
        Query<
            (Entity, &Surface, &Mesh3d, &Deformation),
            Or<(Changed<Deformation>, Changed<Surface>, Changed<Mesh3d>)>,
        >,
    >,
    mut gone: Extract<RemovedComponents<Surface>>,
    all: Extract<Query<(), With<Surface>>>,
) {
    for entity in gone.read() {
        // It may have come back since.
        if !all.contains(entity) {
            bodies.0.remove(&entity);
        }
    }
    for (entity, surface, mesh, deformation) in &changed {
        let body = bodies.0.entry(entity).or_insert_with(|| Body {
            model: surface.model.clone(),
            mesh: mesh.id(),
            tangents: None,
            q: Vec::new(),
            joints: Vec::new(),
            is_stale: true,
        });
        body.model = surface.model.clone();
        body.mesh = mesh.id();
        body.tangents.clone_from(&surface.tangents);
        body.q.clear();
        body.q.extend_from_slice(&deformation.q);
        if body.q.is_empty() {
            body.q.resize(surface.model.asset().mode_count(), 0.0);
        }
        body.joints.clear();
        body.joints.extend(deformation.joints.iter().map(rows));
        body.is_stale = true;
    }
}
