//! Mass properties of what is baked (SPEC 7.10): of the solid inside a closed surface, else of what a basis was
//! computed with.

pub(crate) mod integrals;
mod surface;

use bdtree_format::{MASS_TOLERANCE, MassRecord, ModeMomentum, mass_source};
use bdtree_runtime::math::second_moment_pivot;
use serde::Serialize;

use crate::basis::Basis;
use crate::vec3::{add, cross, sub};
use surface::Enclosed;

/// Density in kg/m³ where nothing else is said: that of water, and of most plastics.
pub const DENSITY_KG_M3: f64 = 1000.0;

/// What has the mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MassSource {
    /// The solid inside a closed surface.
    Surface,
    /// The filled cells of the lattice of an elastic bake.
    Lattice,
    /// The elements of a volume mesh.
    Elements,
}

impl MassSource {
    /// The source of a record, if it is known.
    pub fn of(number: u32) -> Option<Self> {
        match number {
            mass_source::SURFACE => Some(Self::Surface),
            mass_source::LATTICE => Some(Self::Lattice),
            mass_source::ELEMENTS => Some(Self::Elements),
            _ => None,
        }
    }
}

/// Mass, center and inertia of a body at rest. Coordinates are the source's, in mesh units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MassProperties {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Center of mass (mesh units).
    pub center_of_mass: [f64; 3],
    /// The inertia tensor about the center of mass, xx yy zz xy xz yz (kg · mesh unit²), its entries: xy = −∫ x y dm.
    pub inertia: [f64; 6],
    /// Mean density in kg/m³: mass over volume.
    pub density_kg_m3: f64,
    /// Meters per mesh unit.
    pub scale_m: f64,
    /// Volume (mesh units³).
    pub volume: f64,
    /// What has the mass.
    pub source: MassSource,
}

impl MassProperties {
    /// What a file says; `None` where its source is none that this version knows.
    pub fn of_record(record: &MassRecord) -> Option<Self> {
        Some(Self {
            mass_kg: record.mass_kg.get(),
            center_of_mass: record.center_of_mass.map(|x| x.get()),
            inertia: record.inertia.map(|x| x.get()),
            density_kg_m3: record.density_kg_m3.get(),
            scale_m: record.scale_m.get(),
            volume: record.volume.get(),
            source: MassSource::of(record.source.get())?,
        })
    }

    pub(crate) fn record(&self) -> MassRecord {
        MassRecord {
            mass_kg: self.mass_kg.into(),
            center_of_mass: self.center_of_mass.map(Into::into),
            inertia: self.inertia.map(Into::into),
            density_kg_m3: self.density_kg_m3.into(),
            scale_m: self.scale_m.into(),
            volume: self.volume.into(),
            source: match self.source {
                MassSource::Surface => mass_source::SURFACE,
                MassSource::Lattice => mass_source::LATTICE,
                MassSource::Elements => mass_source::ELEMENTS,
            }
            .into(),
            reserved: [0; 20],
        }
    }

    /// Whether readers accept it (SPEC 7.10), with some room.
    pub(crate) fn is_sound(&self) -> bool {
        let positive = [self.mass_kg, self.density_kg_m3, self.scale_m, self.volume];
        let numbers = self.center_of_mass.iter().chain(&self.inertia);
        let of_volume = self.density_kg_m3 * self.volume * self.scale_m.powi(3);
        positive.iter().all(|x| x.is_finite() && *x > 0.0)
            && numbers.into_iter().all(|x| x.is_finite())
            && (self.mass_kg - of_volume).abs() <= 0.5 * MASS_TOLERANCE * self.mass_kg
            && self.inertia[..3].iter().all(|x| *x > 0.0)
            && second_moment_pivot(self.inertia, 0.5 * MASS_TOLERANCE) > 0.0
    }
}

/// The momentum of a body that moves along one mode with q̇ = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Momentum {
    /// The point that the angular momentum is about (mesh units).
    pub about: [f64; 3],
    /// ∫ u dm (kg · mesh unit per unit of q).
    pub linear: [f64; 3],
    /// ∫ (x − about) × u dm (kg · mesh unit² per unit of q).
    pub angular: [f64; 3],
}

impl Momentum {
    /// That of `factor` times the field.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            linear: self.linear.map(|x| factor * x),
            angular: self.angular.map(|x| factor * x),
            ..self
        }
    }

    /// As the file holds it: about the center of mass.
    fn record(&self, center: [f64; 3]) -> ModeMomentum {
        let angular = add(self.angular, cross(sub(self.about, center), self.linear));
        ModeMomentum {
            linear: self.linear.map(Into::into),
            angular: angular.map(Into::into),
        }
    }
}

/// What is known of the body, before its surface is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Density in kg/m³ of what a closed surface encloses. Default 1000.
    pub density_kg_m3: f64,
    /// Meters per mesh unit. Default 1.
    pub scale_m: f64,
    /// The mass properties, if they are known: the surface is not looked at.
    pub known: Option<MassProperties>,
    /// The mass properties where the surface encloses nothing.
    pub fallback: Option<MassProperties>,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            density_kg_m3: DENSITY_KG_M3,
            scale_m: 1.0,
            known: None,
            fallback: None,
        }
    }
}

impl Body {
    /// The mass properties of the body whose surface this is; `None` without any.
    pub(crate) fn properties(
        &self,
        positions: &[[f64; 3]],
        triangles: &[[u32; 3]],
        warnings: &mut Vec<String>,
    ) -> Option<MassProperties> {
        if let Some(known) = self.known.filter(MassProperties::is_sound) {
            return Some(known);
        }
        let fallback = self.fallback.filter(MassProperties::is_sound);
        let instead = match fallback {
            Some(_) => "the mass is that of the lattice's cells",
            None => "the file has no mass",
        };
        let found = match surface::enclosed(positions, triangles) {
            Enclosed::Nothing => None,
            Enclosed::InsideOut => {
                warnings.push(format!(
                    "the mesh is inside out (the volume that its triangles enclose is negative): {instead}; reverse \
                     its triangles"
                ));
                None
            }
            Enclosed::Solid(integrals) => {
                let found = integrals.of_solid(self.density_kg_m3, self.scale_m);
                let found = found.filter(MassProperties::is_sound);
                if found.is_none() {
                    warnings.push(format!(
                        "what the mesh encloses has no inertia that a body can have (parts of it may be inside out): \
                         {instead}"
                    ));
                }
                found
            }
        };
        found.or(fallback)
    }
}

/// The momenta of a basis about the center of mass, where every mode has one and a modal mass, and there are modes.
pub(crate) fn momenta(basis: &Basis, mass: &MassProperties) -> Option<Vec<ModeMomentum>> {
    let record = |mode: &crate::basis::BasisMode| {
        mode.modal_mass_kg?;
        let record = mode.momentum?.record(mass.center_of_mass);
        let mut numbers = record.linear.iter().chain(&record.angular);
        numbers.all(|x| x.get().is_finite()).then_some(record)
    };
    let all: Option<Vec<ModeMomentum>> = basis.modes.iter().map(record).collect();
    all.filter(|all| !all.is_empty())
}
