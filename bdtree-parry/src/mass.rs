//! Mass, center and inertia from the bake.

use super::parry::mass_properties::MassProperties;
use super::parry::math::{Matrix, Real, Vector};
use super::shape::DeformingMesh;

impl DeformingMesh {
    /// Mass (kg), center and inertia of the body at rest as its bake has them, in the shape's frame and world units; `None`
    /// where the bake knows none, because the mesh is not closed.
    pub fn baked_mass_properties(&self) -> Option<MassProperties> {
        let record = self.model().model().asset().mass_properties()?;
        Some(self.with_mass(record.mass_kg.get()))
    }

    /// Of a homogeneous body.
    pub(super) fn mass_of_density(&self, density: Real) -> MassProperties {
        let Some(record) = self.model().model().asset().mass_properties() else {
            return MassProperties::default();
        };
        let volume = record.volume.get() * self.model().scale().powi(3);
        self.with_mass(volume * f64::from(density))
    }

    /// The baked distribution with another mass.
    fn with_mass(&self, mass_kg: f64) -> MassProperties {
        let Some(record) = self.model().model().asset().mass_properties() else {
            return MassProperties::default();
        };
        let scale = self.model().scale();
        let center = record.center_of_mass.map(|x| (x.get() * scale) as Real);
        let share = mass_kg / record.mass_kg.get() * scale * scale;
        let [xx, yy, zz, xy, xz, yz] = record.inertia.map(|x| (x.get() * share) as Real);
        let inertia = Matrix::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let center = Vector::from_array(center);
        MassProperties::with_inertia_matrix(center, mass_kg as Real, inertia)
    }
}
