//! Boxes around deformed meshes, from the root of the tree: for culling and as the broad phase of queries.

use bdtree_runtime::{
    Aabb as Box64, BoundingSphere, Instance, QueryError, Ray, Transform as Placement,
};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemChangeTick;
use bevy_math::{DVec3, Vec3A};

use crate::faults::{PoseFaults, PoseStage};
use crate::placement::rotation;
use crate::pose::{DeformedInstance, DeformingMesh};

/// A box along the axes of the world that holds the deformed mesh of an entity, every rounding included. Kept by
/// [`BdtreeSystems::Bounds`](crate::BdtreeSystems::Bounds), together with Bevy's `Aabb` in the space of the entity.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
pub struct DeformedBounds {
    /// Least coordinates (world units).
    pub min: [f64; 3],
    /// Largest coordinates (world units).
    pub max: [f64; 3],
}

/// A sphere in the world that holds the deformed mesh of an entity: mostly far smaller than one around its box. Kept together
/// with [`DeformedBounds`].
#[derive(Component, Debug, Clone, Copy)]
pub(crate) struct DeformedSphere(pub(crate) BoundingSphere);

impl DeformedSphere {
    /// What holds a sphere (mesh units) that stands somewhere.
    fn placed(own: &BoundingSphere, at: &Placement) -> Self {
        let (center, shift) = (
            DVec3::from_array(own.center),
            DVec3::from_array(at.translation),
        );
        let middle = rotation(at) * at.scale * center + shift;
        let largest = at.scale * (center.abs().max_element() + own.radius);
        let error = ROUNDING * (largest + shift.abs().max_element());
        Self(BoundingSphere {
            center: middle.to_array(),
            radius: at.scale * own.radius + error,
        })
    }
}

/// Shares of the largest number that went in by which boxes are made larger where numbers are added or multiplied.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl DeformedBounds {
    /// What holds a box (mesh units) that stands somewhere.
    fn placed(own: &Box64, at: &Placement) -> Self {
        let turn = rotation(at) * at.scale;
        let (min, max) = (DVec3::from_array(own.min), DVec3::from_array(own.max));
        let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
        let shift = DVec3::from_array(at.translation);
        let middle = turn * center + shift;
        let reach = turn.abs() * half;
        // What went into the sums.
        let largest = at.scale * (center.abs().max_element() + half.max_element());
        let error = ROUNDING * (largest + shift.abs().max_element());
        Self {
            min: (middle - reach - error).to_array(),
            max: (middle + reach + error).to_array(),
        }
    }

    /// The box of the runtime's kind.
    pub fn aabb(&self) -> Box64 {
        Box64 {
            min: self.min,
            max: self.max,
        }
    }

    /// Whether two boxes are at most a distance apart along each axis.
    pub(crate) fn is_near(&self, other: &Self, distance: f64) -> bool {
        (0..3).all(|k| {
            self.min[k] - other.max[k] <= distance && other.min[k] - self.max[k] <= distance
        })
    }

    /// No point of the box is nearer to `point` than this.
    pub(crate) fn distance_to(&self, point: [f64; 3]) -> f64 {
        let (mut square, mut largest) = (0.0, 0.0_f64);
        for k in 0..3 {
            let gap = (self.min[k] - point[k])
                .max(point[k] - self.max[k])
                .max(0.0);
            square += gap * gap;
            largest = largest
                .max(self.min[k].abs())
                .max(self.max[k].abs())
                .max(point[k].abs());
        }
        (square.sqrt() * (1.0 - ROUNDING) - ROUNDING * largest).max(0.0)
    }
}

/// A ray, ready to be compared with many boxes.
pub(crate) struct BoxRay {
    origin: [f64; 3],
    inverse: [f64; 3],
    max_distance: f64,
}

impl BoxRay {
    /// `None` of what is no ray, which queries refuse.
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        let direction = DVec3::from_array(ray.direction);
        let largest = direction.abs().max_element();
        // First by the largest, so that no square is 0 or infinite.
        let direction = (direction / largest).normalize();
        let is_ray = direction.is_finite() && DVec3::from_array(ray.origin).is_finite();
        is_ray.then(|| Self {
            origin: ray.origin,
            inverse: direction.to_array().map(f64::recip),
            max_distance: ray.max_distance,
        })
    }

    /// Where the ray enters the box, at least: it meets nothing of it nearer than this. `None` only if it certainly misses
    /// it.
    pub(crate) fn enters(&self, bounds: &DeformedBounds) -> Option<f64> {
        // Beside a ray along an axis, a box begins at infinity.
        let (mut start, mut end) = (0.0_f64, self.max_distance.min(f64::MAX));
        for k in 0..3 {
            let (low, high) = (bounds.min[k], bounds.max[k]);
            let room = ROUNDING * (low.abs().max(high.abs()) + self.origin[k].abs());
            let from = (low - room - self.origin[k]) * self.inverse[k];
            let to = (high + room - self.origin[k]) * self.inverse[k];
            // 0 · ∞ is no number, of an origin on a face that the ray runs along; min and max pass over it.
            let (near, far) = (from.min(to), from.max(to));
            start = start.max(near * (1.0 - ROUNDING));
            end = end.min(far * (1.0 + ROUNDING));
        }
        (start <= end).then_some(start)
    }
}

/// Bevy's box around one of mesh units, so that `center ± half_extents` in f32 holds it.
pub(crate) fn outward(own: &Box64) -> Aabb {
    let (min, max) = (DVec3::from_array(own.min), DVec3::from_array(own.max));
    let center = (0.5 * (min + max)).as_vec3();
    let middle = center.as_dvec3();
    let half = (max - middle).max(middle - min);
    // Twice what half a unit in the last place comes to, of the sum, of this number, and of f64.
    let half = half + (middle.abs() + half) * 2.0 * f64::from(f32::EPSILON);
    Aabb {
        center: center.into(),
        half_extents: Vec3A::from(half.as_vec3()),
    }
}

/// A sphere and a box around an instance in the space of its entity, which is that of its mesh.
fn own_bounds(instance: &Instance) -> Result<(BoundingSphere, Box64), QueryError> {
    match instance.snapshot().placed(Placement::IDENTITY) {
        Ok(pose) => pose.bounds(),
        // The identity is a placement.
        Err(_) => Err(QueryError::Argument("placement")),
    }
}

/// What is around the deformed mesh of an entity.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Around {
    bounds: &'static mut DeformedBounds,
    sphere: &'static mut DeformedSphere,
    aabb: &'static mut Aabb,
}

impl AroundItem<'_, '_> {
    /// Writes what is around an instance as it is now.
    pub(crate) fn update(
        &mut self,
        entity: Entity,
        instance: &Instance,
        faults: &mut Mut<'_, PoseFaults>,
    ) {
        let found = own_bounds(instance);
        if let Ok((around, found)) = &found {
            let at = instance.placement();
            *self.bounds = DeformedBounds::placed(found, &at);
            *self.sphere = DeformedSphere::placed(around, &at);
            *self.aabb = outward(found);
        }
        PoseFaults::tell(faults, entity, PoseStage::Bounds, found.map(|_| ()));
    }
}

/// Writes the boxes of instances that others than [`update_instances`](crate::pose::update_instances) have moved: what that
/// poses has its boxes while it is in the cache.
pub(crate) fn update_bounds(
    ticks: SystemChangeTick,
    mut bodies: Query<
        (Entity, Ref<DeformedInstance>, Around, &mut PoseFaults),
        Changed<DeformedInstance>,
    >,
) {
    let is_behind = |body: &Ref<DeformedInstance>, bounds: Tick| {
        body.last_changed().is_newer_than(bounds, ticks.this_run())
    };
    // Mostly none is: then no thread is woken.
    if !(bodies.iter_mut())
        .any(|(_, body, around, _)| is_behind(&body, around.bounds.last_changed()))
    {
        return;
    }
    bodies
        .par_iter_mut()
        .for_each(|(entity, body, mut around, mut faults)| {
            if is_behind(&body, around.bounds.last_changed()) {
                around.update(entity, &body.instance, &mut faults);
            }
        });
}

/// Gives new instances boxes, of which Bevy's own systems keep their hands.
pub(crate) fn make_bounds(
    mut commands: Commands,
    mut bodies: Query<
        (Entity, &DeformedInstance, &mut PoseFaults),
        Or<(
            Without<DeformedBounds>,
            Without<DeformedSphere>,
            Without<Aabb>,
            Without<NoAutoAabb>,
        )>,
    >,
    skinned: Query<Entity, (With<DeformedInstance>, With<DynamicSkinnedMeshBounds>)>,
) {
    for (entity, body, mut faults) in &mut bodies {
        match own_bounds(&body.instance) {
            Ok((around, found)) => {
                let at = body.instance.placement();
                commands.entity(entity).insert((
                    DeformedBounds::placed(&found, &at),
                    DeformedSphere::placed(&around, &at),
                    outward(&found),
                    NoAutoAabb,
                ));
            }
            Err(why) => PoseFaults::tell(&mut faults, entity, PoseStage::Bounds, Err(why)),
        }
    }
    for entity in &skinned {
        commands.entity(entity).remove::<DynamicSkinnedMeshBounds>();
    }
}

/// Boxes go with what they were made of.
pub(crate) fn drop_bounds(removed: On<Remove<DeformingMesh>>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .try_remove::<(DeformedBounds, DeformedSphere, Aabb, NoAutoAabb)>();
}
