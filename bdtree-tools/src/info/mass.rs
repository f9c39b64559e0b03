//! Mass properties as `info` tells them.

use bdtree_format::{MassRecord, mass_source};
use serde::Serialize;

/// Mass, center of mass and inertia of the body at rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mass {
    /// In kg.
    pub mass_kg: f64,
    /// In mesh units, in the source's coordinates.
    pub center_of_mass: [f64; 3],
    /// The inertia tensor about the center of mass: xx yy zz xy xz yz, kg · mesh unit²; xy = −∫ x y dm.
    pub inertia: [f64; 6],
    /// Mean density.
    pub density_kg_m3: f64,
    /// Meters per mesh unit.
    pub scale_m: f64,
    /// In mesh units³.
    pub volume: f64,
    /// What has the mass: `surface`, `lattice` or `elements`; other numbers as they are.
    pub source: String,
}

impl Mass {
    pub(crate) fn of(record: &MassRecord) -> Self {
        Self {
            mass_kg: record.mass_kg.get(),
            center_of_mass: record.center_of_mass.map(|x| x.get()),
            inertia: record.inertia.map(|x| x.get()),
            density_kg_m3: record.density_kg_m3.get(),
            scale_m: record.scale_m.get(),
            volume: record.volume.get(),
            source: match record.source.get() {
                mass_source::SURFACE => "surface".to_string(),
                mass_source::LATTICE => "lattice".to_string(),
                mass_source::ELEMENTS => "elements".to_string(),
                other => other.to_string(),
            },
        }
    }

    /// The lines that people read: mass with what has it, center, inertia.
    pub(super) fn lines(&self) -> [(&'static str, String); 3] {
        use crate::output::digits;
        let of = match self.source.as_str() {
            "surface" => "of what the mesh encloses",
            "lattice" => "of the lattice's cells",
            "elements" => "of the elements",
            other => other,
        };
        let (kg, density) = (digits(self.mass_kg), digits(self.density_kg_m3));
        let (volume, scale) = (digits(self.volume), digits(self.scale_m));
        let mass =
            format!("{kg} kg {of}: {density} kg/m³, {volume} mesh units³, 1 mesh unit = {scale} m");
        let list = |numbers: &[f64]| {
            numbers
                .iter()
                .copied()
                .map(digits)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let inertia = format!(
            "{} kg mesh units² (xx yy zz xy xz yz, about the center)",
            list(&self.inertia)
        );
        [
            ("mass", mass),
            ("center", list(&self.center_of_mass)),
            ("inertia", inertia),
        ]
    }
}
