//! Mass, center of mass and inertia of a body at rest.

use bdtree_runtime::Asset;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::error::DynamicsError;
use crate::rotation::principal_axes;

/// Mass properties of a body at rest, in mesh units as an asset has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// kg.
    pub mass_kg: f64,
    /// Center of mass, mesh units.
    pub center: [f64; 3],
    /// Inertia about the center of mass, kg · mesh unit²: xx, yy, zz, xy, xz, yz of the tensor (`xy` is −∫ x y dm).
    pub inertia: [f64; 6],
}

/// Mass properties in the frame of the principal axes, and where that lies in the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMass {
    /// kg.
    pub mass_kg: f64,
    /// Center of mass, mesh units.
    pub center: Vector3<f64>,
    /// Principal moments, kg · mesh unit², ascending.
    pub moments: Vector3<f64>,
    /// From the principal axes to the mesh's.
    pub axes: UnitQuaternion<f64>,
}

impl MassProperties {
    /// Those that the bake has written, if it has.
    pub fn of(asset: &Asset<'_>) -> Option<Self> {
        let record = asset.mass_properties()?;
        Some(Self {
            mass_kg: record.mass_kg.get(),
            center: record.center_of_mass.map(|x| x.get()),
            inertia: record.inertia.map(|x| x.get()),
        })
    }

    /// Those of a homogeneous ball.
    pub fn ball(mass_kg: f64, radius: f64, center: [f64; 3]) -> Self {
        let moment = 0.4 * mass_kg * radius * radius;
        Self {
            mass_kg,
            center,
            inertia: [moment, moment, moment, 0.0, 0.0, 0.0],
        }
    }

    /// Those of a homogeneous box with its edges along the axes.
    pub fn cuboid(mass_kg: f64, sides: [f64; 3], center: [f64; 3]) -> Self {
        let [x, y, z] = sides.map(|side| mass_kg * side * side / 12.0);
        Self {
            mass_kg,
            center,
            inertia: [y + z, x + z, x + y, 0.0, 0.0, 0.0],
        }
    }

    /// In the frame of the principal axes.
    ///
    /// # Errors
    /// Numbers that no body has.
    pub fn rigid(&self) -> Result<RigidMass, DynamicsError> {
        let [xx, yy, zz, xy, xz, yz] = self.inertia;
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let is_sound = self.mass_kg > 0.0
            && self.mass_kg.is_finite()
            && self.center.iter().all(|x| x.is_finite())
            && self.inertia.iter().all(|x| x.is_finite());
        if !is_sound {
            return Err(DynamicsError::Mass);
        }
        let (moments, axes) = principal_axes(&tensor).ok_or(DynamicsError::Mass)?;
        Ok(RigidMass {
            mass_kg: self.mass_kg,
            center: self.center.into(),
            moments,
            axes,
        })
    }
}
