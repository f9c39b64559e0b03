//! The mass of an opened file: of the whole body, and what its modes carry of it.

use bdtree_format::{MassRecord, ModeMomentum};

use super::Asset;

impl<'a> Asset<'a> {
    /// Mass (kg), center of mass and volume (mesh units, in the source's coordinates) and inertia about that center (kg
    /// · mesh unit²) of the body at rest; of a file with a skin, of the bind pose. `None` where the body is unknown:
    /// its surface is open, and nothing else says what it is made of. Multiply the inertia by `scale_m`² for kg m². A
    /// pose with the scale s does not change the mass; the caller says what else scaling shall do.
    pub fn mass_properties(&self) -> Option<&'a MassRecord> {
        self.mass
    }

    /// For every mode j the linear momentum (kg · mesh unit) and the angular momentum about
    /// [`MassRecord::center_of_mass`] (kg · mesh unit²) that the body has at q = 0 when q̇_j = 1 and nothing else moves, in
    /// mesh coordinates, per unit of q. Times `scale_m` and `scale_m`² they are in SI units. Gravity g (mesh units/s²)
    /// does the generalized force `linear · g` on the mode. `None` where no mass moves with the modes: only vibration
    /// modes have it.
    pub fn mode_momenta(&self) -> Option<&'a [ModeMomentum]> {
        (!self.momenta.is_empty()).then_some(self.momenta)
    }
}
