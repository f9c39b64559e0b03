//! Vibration modes of a given volume mesh. Units are those of [`elastic`](super::elastic).

mod check;
mod tell;

pub(super) use tell::silent_warning;

use std::time::Instant;

use serde::Serialize;

use super::elastic::{ElasticOptions, Fix};
use super::modal::ModalField;
use crate::elastic::constraint::nodes::constrain_nodes;
use crate::elastic::lattice::mass::momentum;
use crate::elastic::solve::{Limits, solve};
use crate::elastic::volume::ModelMass;
use crate::error::{BakeError, Place};
use crate::input::volume::RawVolume;
use crate::mass::{Body, DENSITY_KG_M3, MassSource, Momentum};
use crate::progress::Progress;
use crate::words::words;

/// How elements carry their mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MassMatrix {
    /// With the functions that carry the displacement.
    #[default]
    Consistent,
    /// At the nodes: the sums of the consistent matrix's rows.
    Lumped,
}

words!(
    MassMatrix,
    "is neither consistent nor lumped",
    Consistent = "consistent",
    Lumped = "lumped"
);

/// What to compute of a volume mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeOptions {
    /// Number of modes K above those without strain, all components together. Default 10.
    pub mode_count: usize,
    /// Young's modulus in Pa of all elements; `None`: the file's, 2e9 where it has none.
    pub young_pa: Option<f64>,
    /// Poisson's ratio of all elements, in (-1, 0.5); `None`: the file's, 0.35 where it has none.
    pub poisson: Option<f64>,
    /// Density of all elements in kg/m³; `None`: the file's, 1000 where it has none.
    pub density_kg_m3: Option<f64>,
    /// Metres per mesh unit. Default 1.
    pub scale_m: f64,
    /// How elements carry their mass.
    pub mass: MassMatrix,
    /// What is held, exactly.
    pub fixes: Vec<Fix>,
    /// Bakes that would take more are refused before they do. Default 4 GiB.
    pub memory_limit_bytes: u64,
    /// Up to this many unknowns per component an inertia count proves that no mode was missed.
    /// Default 70 000.
    pub verify_dof_max: usize,
    /// Threads to work with; the modes do not depend on it. Default 1.
    pub threads: usize,
}

impl Default for VolumeOptions {
    fn default() -> Self {
        let elastic = ElasticOptions::default();
        Self {
            mode_count: elastic.mode_count,
            young_pa: None,
            poisson: None,
            density_kg_m3: None,
            scale_m: elastic.scale_m,
            mass: MassMatrix::Consistent,
            fixes: Vec::new(),
            memory_limit_bytes: elastic.memory_limit_bytes,
            verify_dof_max: elastic.verify_dof_max,
            threads: elastic.threads,
        }
    }
}

/// Modes on the nodes of a volume mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VolumeModes {
    /// Ascending in frequency.
    pub modes: Vec<VolumeMode>,
}

/// One of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VolumeMode {
    /// Angular frequency in rad/s.
    pub omega_rad_s: f64,
    /// Displacement of each node of the mesh, for a modal mass Σ mass · |U|² of 1 kg; zero where
    /// the node is held or belongs to no element.
    pub field: Vec<[f64; 3]>,
    /// Momentum of all elements at unit speed, of the same length; of the mass matrix that the mode was found with.
    pub momentum: Option<Momentum>,
}

impl VolumeModes {
    /// The modes on the vertices of a mesh, `embed` being what carries a field of the nodes there:
    /// what [`modal_basis`](super::modal::modal_basis) takes.
    pub fn on_vertices<'a>(
        &'a self,
        embed: impl Fn(&[[f64; 3]]) -> Vec<[f64; 3]> + 'a,
    ) -> impl Iterator<Item = ModalField> + 'a {
        self.modes.iter().map(move |mode| ModalField {
            field: embed(&mode.field),
            omega_rad_s: mode.omega_rad_s,
            modal_mass_kg: 1.0,
            momentum: mode.momentum,
        })
    }
}

/// How the modes were found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct VolumeReport {
    /// Elements.
    pub elements: usize,
    /// Nodes that belong to elements.
    pub nodes: usize,
    /// Unknowns that are not held.
    pub dofs: usize,
    /// Components: they share no node, so each vibrates on its own.
    pub components: usize,
    /// Memory that the solution was predicted to take.
    pub predicted_bytes: u64,
    /// Total mass in kg.
    pub mass_kg: f64,
    /// Worst ‖Kx − λMx‖ / (λ‖Mx‖) of the modes.
    pub residual_max: f64,
    /// Whether inertia counts proved that no mode was missed.
    pub inertia_checked: bool,
    /// The mass of the elements.
    #[serde(skip)]
    pub body: Body,
    /// Stage name and seconds.
    #[serde(skip)]
    pub stages: Vec<(&'static str, f64)>,
}

/// The mass of a volume mesh's elements, for bakes that ask for no modes.
///
/// # Errors
/// Those of the elements and materials that [`volume_modes`] has.
pub fn volume_body(volume: &RawVolume, options: &VolumeOptions) -> Result<Body, BakeError> {
    check::values(options)?;
    let (model, units) = check::model(volume, options, &mut Vec::new())?;
    Ok(body(&model.mass_sums(), units, options))
}

fn body(mass: &ModelMass, units: check::Units, options: &VolumeOptions) -> Body {
    let frame = units.frame();
    let mass_kg = units.mass_kg * mass.integrals.whole;
    let volume = mass.volume * frame.length.powi(3);
    let density = mass_kg / (volume * options.scale_m.powi(3));
    let own = (density, options.scale_m);
    let known = (mass.integrals).properties(frame, (mass_kg, volume), own, MassSource::Elements);
    // Beyond the range of numbers there is no mass, and no density that a bake could be asked with.
    let is_number = density.is_finite() && density > 0.0;
    Body {
        density_kg_m3: if is_number { density } else { DENSITY_KG_M3 },
        scale_m: options.scale_m,
        known: Some(known),
        fallback: None,
    }
}

/// The K lowest vibration modes of a volume mesh: linear tetrahedra, hexahedra with incompatible
/// modes, and held nodes that do not move at all (docs/reference/volumes.md).
///
/// # Errors
/// Bad options (all of them at once), elements that are turned inside out or flat, materials that
/// are none, a fix that holds nothing or everything, more modes than the mesh has, memory beyond
/// the limit.
pub fn volume_modes(
    volume: &RawVolume,
    options: &VolumeOptions,
    progress: &dyn Progress,
    warnings: &mut Vec<String>,
) -> Result<(VolumeModes, VolumeReport), BakeError> {
    let mut report = VolumeReport::default();
    let mut clock = Instant::now();
    let mut lap = |report: &mut VolumeReport, name| {
        report.stages.push((name, clock.elapsed().as_secs_f64()));
        clock = Instant::now();
    };
    progress.stage("elements", None);
    check::options(options)?;
    let (model, units) = check::model(volume, options, warnings)?;
    let components = model
        .components()
        .map_err(|(node, blocks)| tell::joints_error(volume, node, blocks))?;
    let mut used = vec![false; volume.nodes.len()];
    for &n in components.iter().flat_map(|p| &p.nodes) {
        used[n as usize] = true;
    }
    let held = constrain_nodes(volume, &used, units.length, &options.fixes)?;
    report.elements = model.elements.len();
    report.nodes = components.iter().map(|p| p.nodes.len()).sum();
    let held_count = held.iter().flatten().filter(|h| **h).count();
    report.dofs = 3 * report.nodes - held_count;
    report.components = components.len();
    report.mass_kg = units.mass_kg
        * (0..model.elements.len())
            .map(|e| model.mass(e, model.shape(e).0))
            .sum::<f64>();
    let mass = model.mass_sums();
    report.body = body(&mass, units, options);
    tell::joints(&components, warnings);
    lap(&mut report, "elements");

    let limits = Limits {
        wanted: options.mode_count,
        bytes: options.memory_limit_bytes,
        verify_dof_max: options.verify_dof_max,
        threads: options.threads,
    };
    let sizes: Vec<usize> = components.iter().map(|p| p.nodes.len()).collect();
    let system = |c: usize| model.system(&components[c], &held);
    let solution = solve(&sizes, system, limits, progress)
        .map_err(|e| tell::solve_error(e, volume, &components, options))?;
    if solution.modes.len() < options.mode_count {
        let message = format!(
            "{} modes asked for, but the volume mesh has only {}",
            options.mode_count, solution.available
        );
        return Err(BakeError::one("basis", Place::option("--modes"), message));
    }
    report.predicted_bytes = solution.bytes;
    report.residual_max = solution.residual;
    report.inertia_checked = solution.checked;
    tell::silent(&components, &solution, warnings);
    lap(&mut report, "modes");

    let scale = 1.0 / units.mass_kg.sqrt();
    let frame = units.frame();
    let modes = solution.modes.iter().map(|mode| {
        let mut field = vec![[0.0; 3]; volume.nodes.len()];
        let values = mode.vector.as_chunks::<3>().0.iter();
        for (&n, u) in components[mode.component].nodes.iter().zip(values) {
            field[n as usize] = u.map(|x| x * scale);
        }
        let momentum = momentum(&mass.nodes, &field, frame, units.mass_kg);
        VolumeMode {
            omega_rad_s: mode.value.max(0.0).sqrt() * units.omega_rad_s,
            field,
            momentum: Some(momentum),
        }
    });
    let modes = modes.collect();
    Ok((VolumeModes { modes }, report))
}
