//! Spheres, boxes and hits for those who debug, drawn by Bevy's gizmos.

use bdtree_runtime::{Contact, FormatError, Pose, RayIntersection, TriangleId};
use bevy_app::{App, PostUpdate};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_gizmos::AppGizmoBuilder;
use bevy_gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy_gizmos::gizmos::{GizmoBuffer, Gizmos};
use bevy_log::warn_once;
use bevy_math::{Isometry3d, Vec3};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_shape::Aabb3d;
use bevy_transform::components::GlobalTransform;

use crate::BdtreeSystems;
use crate::pose::DeformedInstance;

/// How the gizmos of this crate are drawn: `GizmoConfigStore::config_mut::<BdtreeGizmos>()`.
#[derive(Clone, Debug, Reflect, GizmoConfigGroup)]
#[reflect(Default, Clone)]
pub struct BdtreeGizmos {
    /// The color of spheres whose component names none.
    pub spheres: Color,
    /// The color of boxes whose component names none.
    pub boxes: Color,
}

impl Default for BdtreeGizmos {
    fn default() -> Self {
        Self {
            spheres: Color::srgb(0.1, 0.45, 0.8),
            boxes: Color::srgb(0.1, 0.6, 0.3),
        }
    }
}

/// Draws the spheres of a level of this entity's tree in its pose: those that hold its triangles for queries.
#[derive(Component, Reflect, Debug, Clone, Copy, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ShowSpheres {
    /// The level; 0 is the root's, of up to eight spheres. Those of leaves above it are drawn too, so that all triangles are
    /// in one. Levels below the last show the leaves.
    pub level: usize,
    /// `None`: that of [`BdtreeGizmos`].
    pub color: Option<Color>,
}

/// Draws the box along the axes of the world that holds this entity's mesh in its pose.
#[derive(Component, Reflect, Debug, Clone, Copy, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ShowBox {
    /// `None`: that of [`BdtreeGizmos`].
    pub color: Option<Color>,
}

/// What queries found, as lines: the triangle, a cross at the point, and an arrow along the normal.
pub trait DeformedGizmos {
    /// A hit of a ray on the mesh in this pose. The arrow is `length` world units long.
    ///
    /// # Errors
    /// A hit of another asset; a corrupt asset.
    fn ray_hit(
        &mut self,
        pose: &Pose<'_>,
        hit: &RayIntersection,
        length: f32,
        color: impl Into<Color>,
    ) -> Result<(), FormatError>;

    /// A contact of the mesh in this pose. The arrow is `length` world units long.
    ///
    /// # Errors
    /// A contact of another asset; a corrupt asset.
    fn contact(
        &mut self,
        pose: &Pose<'_>,
        contact: &Contact,
        length: f32,
        color: impl Into<Color>,
    ) -> Result<(), FormatError>;
}

impl<Config: GizmoConfigGroup, Clear: 'static + Send + Sync> DeformedGizmos
    for GizmoBuffer<Config, Clear>
{
    fn ray_hit(
        &mut self,
        pose: &Pose<'_>,
        hit: &RayIntersection,
        length: f32,
        color: impl Into<Color>,
    ) -> Result<(), FormatError> {
        let (point, normal) = (vector(hit.point), vector(hit.normal));
        touch(
            self,
            pose,
            hit.triangle,
            point,
            normal * length,
            color.into(),
        )
    }

    fn contact(
        &mut self,
        pose: &Pose<'_>,
        contact: &Contact,
        length: f32,
        color: impl Into<Color>,
    ) -> Result<(), FormatError> {
        let (point, normal) = (vector(contact.point), vector(contact.normal));
        touch(
            self,
            pose,
            contact.triangle,
            point,
            normal * length,
            color.into(),
        )
    }
}

fn touch<Config: GizmoConfigGroup, Clear: 'static + Send + Sync>(
    gizmos: &mut GizmoBuffer<Config, Clear>,
    pose: &Pose<'_>,
    triangle: TriangleId,
    point: Vec3,
    arrow: Vec3,
    color: Color,
) -> Result<(), FormatError> {
    gizmos.lineloop(pose.deformed_triangle(triangle)?.map(vector), color);
    gizmos.cross(
        Isometry3d::from_translation(point),
        0.1 * arrow.length(),
        color,
    );
    gizmos.arrow(point, point + arrow, color);
    Ok(())
}

fn vector(v: [f64; 3]) -> Vec3 {
    Vec3::from_array(v.map(|x| x as f32))
}

/// Nothing where the program has no gizmos.
pub(crate) fn finish(app: &mut App) {
    if !app.world().contains_resource::<GizmoConfigStore>() {
        return;
    }
    app.register_type::<ShowSpheres>()
        .register_type::<ShowBox>()
        .init_gizmo_group::<BdtreeGizmos>()
        .add_systems(
            PostUpdate,
            (draw_spheres, draw_boxes).after(BdtreeSystems::Bounds),
        );
}

fn draw_spheres(
    shown: Query<(Entity, &ShowSpheres, &DeformedInstance)>,
    mut gizmos: Gizmos<BdtreeGizmos>,
) {
    for (entity, show, DeformedInstance { instance }) in &shown {
        let color = show.color.unwrap_or(gizmos.config_ext.spheres);
        let spheres = level_spheres(&instance.snapshot(), show.level);
        match spheres {
            Ok(spheres) => {
                for (center, radius) in spheres {
                    gizmos.sphere(Isometry3d::from_translation(center), radius, color);
                }
            }
            Err(why) => warn_once!("{entity}: {why}"),
        }
    }
}

fn draw_boxes(
    shown: Query<(Entity, &ShowBox, &DeformedInstance)>,
    mut gizmos: Gizmos<BdtreeGizmos>,
) {
    for (entity, show, DeformedInstance { instance }) in &shown {
        let color = show.color.unwrap_or(gizmos.config_ext.boxes);
        match instance.aabb() {
            Ok(found) => {
                let (min, max) = (vector(found.min), vector(found.max));
                let found = Aabb3d {
                    min: min.into(),
                    max: max.into(),
                };
                gizmos.aabb_3d(found, GlobalTransform::IDENTITY, color);
            }
            Err(why) => warn_once!("{entity}: {why}"),
        }
    }
}

/// Centers and radii (world units) of the spheres of a level and of the leaves above it.
fn level_spheres(pose: &Pose<'_>, level: usize) -> Result<Vec<(Vec3, f32)>, FormatError> {
    let asset = pose.asset();
    let map = pose.stored_to_world();
    let level = level.min(asset.depth().saturating_sub(1));
    let mut found = Vec::new();
    for (index, node) in (0..).zip(&asset.nodes()[..asset.node_count_to(level)]) {
        let spheres = pose.node_spheres(index)?;
        let is_last = usize::from(node.level) == level;
        for lane in node.lanes() {
            if is_last || node.child(lane).is_none() {
                let center = map.point([0, 1, 2].map(|k| spheres.center[k][lane]));
                let radius = f64::from(spheres.radius[lane]) * map.scale();
                found.push((vector(center), radius as f32));
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use bdtree_runtime::{Instance, Model, Transform, VertexId};

    use super::*;

    #[test]
    fn every_vertex_of_a_triangle_is_in_a_sphere_of_every_level() {
        let bytes = std::fs::read("../fixtures/golden/sphere.bdt").unwrap();
        let model = Model::from_bytes(&bytes).unwrap();
        let mut instance = Instance::new(&model).unwrap();
        let q = vec![0.2; model.asset().mode_count()];
        let at = Transform {
            scale: 2.0,
            ..Transform::from_translation([1.0, 2.0, 3.0])
        };
        instance.set_pose(&q, at).unwrap();
        let pose = instance.pose();
        let mut last = 0;
        for level in 0..model.asset().depth() + 2 {
            let spheres = level_spheres(&pose, level).unwrap();
            assert!(spheres.len() >= last);
            last = spheres.len();
            for id in 0..model.asset().triangle_count() as u32 {
                for corner in model.asset().triangle(TriangleId(id)).unwrap() {
                    let point = vector(pose.deformed(VertexId(corner.0)).unwrap());
                    let is_in = |(center, radius): &(Vec3, f32)| {
                        point.distance(*center) <= radius * 1.000_01
                    };
                    assert!(spheres.iter().any(is_in), "level {level}");
                }
            }
        }
        assert!(last > 8);
    }
}
