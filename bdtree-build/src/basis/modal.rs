//! Vibration modes as a basis.

use super::{Basis, BasisMode};
use crate::elastic::solve::canonical::normalise;
use crate::mass::Momentum;

/// A vibration mode on the vertices of a mesh, of whatever length.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalField {
    /// Displacement of each vertex.
    pub field: Vec<[f64; 3]>,
    /// Angular frequency in rad/s.
    pub omega_rad_s: f64,
    /// Modal mass Σ mass · |field|² of the whole body, in kg.
    pub modal_mass_kg: f64,
    /// Momentum of the whole body at unit speed, if it is known.
    pub momentum: Option<Momentum>,
}

/// The basis of these modes, in their order: each field is scaled so that the farthest vertex
/// moves by 1, its leading component positive, and the modal mass with it. A mode that moves no
/// vertex stays as it is, with a warning.
pub fn modal_basis(
    vertex_count: usize,
    modes: impl IntoIterator<Item = ModalField>,
    warnings: &mut Vec<String>,
) -> Basis {
    let mut basis = Basis {
        vertex_count,
        ..Basis::default()
    };
    for (j, mut mode) in modes.into_iter().enumerate() {
        let name = format!("elastic {}", j + 1);
        let factor = normalise(&mut mode.field).unwrap_or_else(|| {
            warnings.push(format!("mode `{name}` moves no vertex"));
            1.0
        });
        basis.fields.extend(mode.field);
        basis.modes.push(BasisMode {
            name: Some(name),
            omega_rad_s: Some(mode.omega_rad_s),
            modal_mass_kg: Some(mode.modal_mass_kg * factor * factor),
            momentum: mode.momentum.map(|momentum| momentum.scaled(factor)),
            q_range: None,
            default_q: None,
        });
    }
    basis
}
