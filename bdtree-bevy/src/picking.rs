//! Pointers hit the deformed surface: a backend of Bevy's picking.

use bdtree_runtime::Ray;
use bevy_app::{App, Plugin, PreUpdate};
use bevy_camera::Camera;
use bevy_camera::visibility::{InheritedVisibility, RenderLayers, ViewVisibility};
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{ReflectComponent, ReflectResource};
use bevy_log::error_once;
use bevy_picking::backend::ray::RayMap;
use bevy_picking::backend::{HitData, PointerHits};
use bevy_picking::{Pickable, PickingSystems};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;

use crate::queries::DeformingQueries;

/// Tests the rays of pointers against deforming meshes and writes `PointerHits`. Add Bevy's `PickingPlugin` or
/// `DefaultPickingPlugins` too, which make the rays: they know viewports, windows and scale factors.
///
/// It does what Bevy's own backend for meshes does for meshes that do not deform: a camera picks what shares a render layer
/// with it; `Pickable` says what is hovered and what blocks what lies behind it; groups of hits have the camera's order. An
/// entity that has a `Mesh3d` besides is seen by Bevy's backend too, in the bind pose: add one backend, or set
/// `MeshPickingSettings::require_markers`. Other than there, surfaces are hit from both sides.
#[derive(Debug, Default, Clone, Copy)]
pub struct DeformingPickingPlugin;

impl Plugin for DeformingPickingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<DeformingPickingSettings>()
            .register_type::<DeformingPickingCamera>()
            .add_systems(PreUpdate, update_hits.in_set(PickingSystems::Backend));
    }
}

/// What the backend takes into account.
#[derive(Resource, Reflect, Debug, Clone, Copy, Default, PartialEq, Eq)]
#[reflect(Resource, Default)]
pub struct DeformingPickingSettings {
    /// Whether only cameras with a [`DeformingPickingCamera`] and entities with a `Pickable` count; `false` by default.
    pub require_markers: bool,
    /// Which entities are hit, as far as they can be seen.
    pub visibility: PickVisibility,
}

/// Which entities pointers hit, as far as they can be seen.
#[derive(Reflect, Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PickVisibility {
    /// All, hidden ones too, and those without `Visibility`.
    Any,
    /// Those that are not hidden.
    Visible,
    /// Those that are not hidden and in the view of a camera or a light.
    #[default]
    VisibleInView,
}

/// A camera that picks where [`DeformingPickingSettings::require_markers`] is set.
#[derive(Component, Reflect, Debug, Clone, Copy, Default)]
#[reflect(Component, Default)]
pub struct DeformingPickingCamera;

/// Where a pointer hits a deforming mesh: `hit.extra_as::<DeformingHit>()` of a `HitData` of this backend, whose `position`
/// and `normal` are the world's, the normal of unit length and towards the camera, and whose `depth` is the distance along
/// the ray (world units).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeformingHit {
    /// The triangle: its number among those of the file's source.
    pub triangle: u32,
    /// Weights of its corners that give the point; not negative, sum 1.
    pub barycentric: [f64; 3],
    /// The point (world units).
    pub point: [f64; 3],
    /// The distance along the ray (world units).
    pub distance: f64,
}

/// Casts the rays of pointers and writes what they hit.
fn update_hits(
    settings: Res<DeformingPickingSettings>,
    rays: Res<RayMap>,
    cameras: Query<(&Camera, Has<DeformingPickingCamera>, Option<&RenderLayers>)>,
    entities: Query<(
        Option<&Pickable>,
        Option<&RenderLayers>,
        Option<&InheritedVisibility>,
        Option<&ViewVisibility>,
    )>,
    mut queries: DeformingQueries,
    mut writer: MessageWriter<PointerHits>,
) {
    let mut hits = Vec::new();
    for (id, ray) in rays.iter() {
        let Ok((camera, is_marked, camera_layers)) = cameras.get(id.camera) else {
            continue;
        };
        if settings.require_markers && !is_marked {
            continue;
        }
        let default_layers = RenderLayers::default();
        let camera_layers = camera_layers.unwrap_or(&default_layers);
        let is_hit = |entity: Entity| {
            let Ok((pickable, layers, inherited, view)) = entities.get(entity) else {
                return false;
            };
            let is_visible = match settings.visibility {
                PickVisibility::Any => true,
                PickVisibility::Visible => inherited.is_some_and(|v| v.get()),
                PickVisibility::VisibleInView => view.is_some_and(|v| v.get()),
            };
            is_visible
                && camera_layers.intersects(layers.unwrap_or(&default_layers))
                && pickable.map_or(!settings.require_markers, |p| p.is_hoverable)
        };
        let is_blocking = |entity: Entity| {
            let pickable = entities.get(entity).ok().and_then(|of| of.0);
            pickable.is_some_and(|pickable| pickable.should_block_lower)
        };
        let ray = Ray::new(ray.origin.to_array(), ray.direction.to_array());
        hits.clear();
        if let Err(why) = queries.cast_ray_through(&ray, is_hit, is_blocking, &mut hits) {
            error_once!("picking of deforming meshes: {why}");
            continue;
        }
        if hits.is_empty() {
            continue;
        }
        let picks = hits.iter().map(|hit| {
            let extra = DeformingHit {
                triangle: hit.triangle.0,
                barycentric: hit.barycentric,
                point: hit.point,
                distance: hit.distance,
            };
            let depth = hit.distance as f32;
            let (position, normal) = (Some(hit.position()), Some(hit.direction()));
            let data = HitData::new_with_extra(id.camera, depth, position, normal, extra);
            (hit.entity, data)
        });
        writer.write(PointerHits::new(
            id.pointer,
            picks.collect(),
            camera.order as f32,
        ));
    }
}
