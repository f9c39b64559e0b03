//! The collider: a shape of avian's or a deforming mesh.

use avian3d::collision::collider::{
    AnyCollider, ColliderContext, ColliderPairContext, ScalableCollider, SimpleCollider,
};
use avian3d::parry::mass_properties::MassProperties;
use avian3d::parry::math::Pose3 as Pose;
use avian3d::parry::shape::{Shape, SharedShape};
use avian3d::prelude::{
    Collider, ColliderAabb, ComputeMassProperties3d, ContactManifold, MassProperties3d,
};
use bdtree_parry::{DeformingMesh, DeformingModel, ShapeError};
use bdtree_runtime::{CacheSize, Instance, PoseError, Transform as Placement};
use bevy_ecs::prelude::*;
use bevy_log::error;
use bevy_math::{Quat, Vec3};

use super::contacts;
use crate::pose::{Deformation, set_pose};

/// A collider of avian that may deform.
///
/// Entities with avian's `Collider` get one by themselves, and so do entities with a
/// [`DeformingCollider`](super::DeformingCollider); a program inserts one for shapes that it deforms itself.
///
/// Its mass is that of avian's `Collider`, or of the mesh's bake: `ColliderDensity` then is a multiple of it, so that its
/// default of 1 gives the bake's own mass. A mesh without mass in its bake has none.
#[derive(Component, Debug, Clone)]
pub enum BdtCollider {
    /// A shape of avian's, also a `Compound` that holds deforming meshes.
    Rigid(Collider),
    /// A mesh at one pose.
    Deforming(MeshCollider),
}

/// A deforming mesh as a collider, at the scale of its entity.
#[derive(Debug, Clone)]
pub struct MeshCollider {
    /// At the scale.
    mesh: DeformingMesh,
    shape: SharedShape,
    /// World units per mesh unit where the entity's scale is 1.
    unscaled: f64,
    /// Of the entity.
    scale: Vec3,
    /// What it was deformed by, where an entity says so.
    pose: Option<Deformation>,
}

impl MeshCollider {
    /// The mesh at the scale of the entity.
    pub fn mesh(&self) -> &DeformingMesh {
        &self.mesh
    }
}

/// avian's default `Collider`: some of its plugins ask for one.
impl Default for BdtCollider {
    fn default() -> Self {
        Self::Rigid(Collider::default())
    }
}

impl From<Collider> for BdtCollider {
    fn from(collider: Collider) -> Self {
        Self::Rigid(collider)
    }
}

impl From<SharedShape> for BdtCollider {
    fn from(shape: SharedShape) -> Self {
        Self::Rigid(shape.into())
    }
}

/// At the scale that it has, which the scale of the entity multiplies; a mesh with bones refuses other scales than 1, since
/// what moved them is not known.
impl From<DeformingMesh> for BdtCollider {
    fn from(mesh: DeformingMesh) -> Self {
        let unscaled = mesh.model().scale();
        Self::deforming(mesh, unscaled, Vec3::ONE, None)
    }
}

impl BdtCollider {
    /// `mesh` is at `unscaled` times the entity's scale.
    pub(super) fn deforming(
        mesh: DeformingMesh,
        unscaled: f64,
        scale: Vec3,
        pose: Option<Deformation>,
    ) -> Self {
        Self::Deforming(MeshCollider {
            shape: SharedShape::new(mesh.clone()),
            mesh,
            unscaled,
            scale,
            pose,
        })
    }

    /// The shape at the scale of the entity.
    pub fn shape(&self) -> &dyn Shape {
        match self {
            Self::Rigid(collider) => &*collider.shape_scaled().0,
            Self::Deforming(collider) => &*collider.shape.0,
        }
    }

    /// The deforming mesh, if it is one.
    pub fn mesh(&self) -> Option<&DeformingMesh> {
        match self {
            Self::Rigid(_) => None,
            Self::Deforming(collider) => Some(&collider.mesh),
        }
    }

    /// Mass (kg), center and inertia for a density.
    fn parry_mass(&self, density: f32) -> MassProperties {
        match self {
            Self::Rigid(collider) => collider.shape_scaled().mass_properties(density),
            Self::Deforming(collider) => {
                let mut mass = collider.mesh.baked_mass_properties().unwrap_or_default();
                mass.set_mass(mass.mass() * density, true);
                mass
            }
        }
    }
}

/// A model at the pose of an entity.
///
/// # Errors
/// Coordinates or joints that the file refuses; a damaged file.
pub(super) fn deformed(
    model: &DeformingModel,
    deformation: &Deformation,
) -> Result<DeformingMesh, ShapeError> {
    let mut instance = Instance::with_cache(model.model(), CacheSize::NONE)?;
    set_pose(&mut instance, deformation, Placement::IDENTITY)?;
    DeformingMesh::of_instance(model.clone(), instance)
}

/// Where a collider stands.
pub(super) fn pose(position: Vec3, rotation: Quat) -> Pose {
    Pose::from_parts(position, rotation)
}

impl AnyCollider for BdtCollider {
    type Context = ();

    fn aabb_with_context(
        &self,
        position: Vec3,
        rotation: impl Into<Quat>,
        margin: f32,
        _: ColliderContext<()>,
    ) -> ColliderAabb {
        let rotation: Quat = rotation.into();
        match self {
            Self::Rigid(collider) => collider.aabb(position, rotation, margin),
            Self::Deforming(_) => {
                let aabb = self.shape().compute_aabb(&pose(position, rotation));
                ColliderAabb::from_min_max(aabb.mins - margin, aabb.maxs + margin)
            }
        }
    }

    fn swept_aabb_with_context(
        &self,
        start_position: Vec3,
        start_rotation: impl Into<Quat>,
        end_position: Vec3,
        end_rotation: impl Into<Quat>,
        margin: f32,
        _: ColliderContext<()>,
    ) -> ColliderAabb {
        let (start, end): (Quat, Quat) = (start_rotation.into(), end_rotation.into());
        let at = |position, rotation| self.aabb(position, rotation, margin);
        at(start_position, start).merged(at(end_position, end))
    }

    fn contact_manifolds_with_context(
        &self,
        other: &Self,
        position1: Vec3,
        rotation1: impl Into<Quat>,
        position2: Vec3,
        rotation2: impl Into<Quat>,
        prediction_distance: f32,
        manifolds: &mut Vec<ContactManifold>,
        _: ColliderPairContext<()>,
    ) {
        let (rotation1, rotation2): (Quat, Quat) = (rotation1.into(), rotation2.into());
        if let (Self::Rigid(one), Self::Rigid(two)) = (self, other)
            && !contacts::holds_mesh(self.shape())
            && !contacts::holds_mesh(other.shape())
        {
            one.contact_manifolds(
                two,
                position1,
                rotation1,
                position2,
                rotation2,
                prediction_distance,
                manifolds,
            );
            return;
        }
        contacts::manifolds(
            [self.shape(), other.shape()],
            [pose(position1, rotation1), pose(position2, rotation2)],
            prediction_distance,
            manifolds,
        );
    }

    /// Infinite for meshes, which avian does not sweep.
    fn ccd_thickness_with_context(&self, _: ColliderContext<()>) -> f32 {
        match self {
            Self::Rigid(collider) => collider.ccd_thickness(),
            Self::Deforming(_) => f32::INFINITY,
        }
    }

    fn max_distance_to_point_with_context(&self, point: Vec3, _: ColliderContext<()>) -> f32 {
        let sphere = self.shape().compute_local_bounding_sphere();
        point.distance(sphere.center) + sphere.radius
    }

    fn bounding_radius_with_context(&self, _: ColliderContext<()>) -> f32 {
        self.max_distance_to_point(self.center_of_mass())
    }
}

impl ScalableCollider for BdtCollider {
    fn scale(&self) -> Vec3 {
        match self {
            Self::Rigid(collider) => collider.scale(),
            Self::Deforming(collider) => collider.scale,
        }
    }

    /// Meshes have one scale along all axes; they keep their own, with an error in the log, where the entity has another.
    fn set_scale(&mut self, scale: Vec3, detail: u32) {
        let collider = match self {
            Self::Rigid(collider) => return collider.set_scale(scale, detail),
            Self::Deforming(collider) => collider,
        };
        // A transform that is not there yet has the scale 0.
        if scale == collider.scale || scale == Vec3::ZERO {
            return;
        }
        let asked = std::mem::replace(&mut collider.scale, scale);
        match collider.rescaled() {
            Ok(made) => *self = made,
            Err(why) => error!("a deforming mesh stays at the scale {asked}, not {scale}: {why}"),
        }
    }
}

impl MeshCollider {
    /// The same pose, bones and all, at the scale that is asked for.
    fn rescaled(&self) -> Result<BdtCollider, ShapeError> {
        let factor = uniform(self.scale).ok_or(PoseError::Scale)?;
        let model = self.mesh.model().scaled(self.unscaled * factor)?;
        let mesh = match &self.pose {
            Some(pose) => deformed(&model, pose)?,
            None if model.model().asset().joint_count() > 0 => return Err(PoseError::Scale.into()),
            None => DeformingMesh::new(&model, self.mesh.q())?,
        };
        let pose = self.pose.clone();
        Ok(BdtCollider::deforming(
            mesh,
            self.unscaled,
            self.scale,
            pose,
        ))
    }
}

/// The factor of a scale that meshes can have.
pub(super) fn uniform(scale: Vec3) -> Option<f64> {
    let spread = scale.max_element() - scale.min_element();
    let is_uniform = scale.is_finite() && scale.x > 0.0 && spread <= 1e-5 * scale.x;
    is_uniform.then_some(f64::from(scale.x))
}

impl ComputeMassProperties3d for BdtCollider {
    fn mass(&self, density: f32) -> f32 {
        self.parry_mass(density).mass()
    }

    fn unit_principal_angular_inertia(&self) -> Vec3 {
        self.principal_angular_inertia(1.0)
    }

    fn principal_angular_inertia(&self, mass: f32) -> Vec3 {
        let own = self.parry_mass(1.0);
        if own.mass() > 0.0 {
            own.principal_inertia() * (mass / own.mass())
        } else {
            Vec3::ZERO
        }
    }

    fn local_inertial_frame(&self) -> Quat {
        self.parry_mass(1.0).principal_inertia_local_frame
    }

    fn center_of_mass(&self) -> Vec3 {
        self.parry_mass(1.0).local_com
    }

    fn mass_properties(&self, density: f32) -> MassProperties3d {
        let own = self.parry_mass(density);
        MassProperties3d {
            mass: own.mass(),
            principal_angular_inertia: own.principal_inertia(),
            local_inertial_frame: own.principal_inertia_local_frame,
            center_of_mass: own.local_com,
        }
    }
}
