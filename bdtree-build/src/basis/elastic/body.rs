//! What an elastic bake knows of its body's mass.

use super::ElasticOptions;
use crate::elastic::lattice::Subject;
use crate::elastic::lattice::mass::LatticeMass;
use crate::elastic::surface::components::Kind;
use crate::mass::{Body, MassSource};

/// The mass of the filled cells. That of the surface is exact where it encloses all that was filled; sheets are thicker
/// than their surface.
pub(super) fn body(subject: &Subject<'_>, mass: &LatticeMass, options: &ElasticOptions) -> Body {
    let (density, scale) = (options.density_kg_m3, options.scale_m);
    let volume = mass.integrals.whole * mass.frame.length.powi(3);
    let own = (density * volume * scale.powi(3), volume);
    let of_cells =
        (mass.integrals).properties(mass.frame, own, (density, scale), MassSource::Lattice);
    let is_solid = (subject.surface.list.iter()).all(|piece| piece.kind == Kind::Solid);
    Body {
        density_kg_m3: density,
        scale_m: scale,
        known: (!is_solid).then_some(of_cells),
        fallback: Some(of_cells),
    }
}
