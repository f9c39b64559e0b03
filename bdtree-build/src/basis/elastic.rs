//! Elastic (vibration) modes of a body known by its surface only.
//!
//! # Units
//! `p' = p + Σ U_j q_j` is in mesh units; one mesh unit is `scale_m` metres. `q_j = 1` moves the
//! farthest vertex by one mesh unit, so `U_j` is a ratio and q_j is in mesh units. The modal mass
//! `m_j = Σ mass · |U|²` is in kg, ω_j in rad/s. Then
//! `m_j q̈_j + 2ζ m_j ω_j q̇_j + m_j ω_j² q_j = U_jᵀ f` holds with `f` in kg · mesh unit / s², which
//! is newtons divided by `scale_m` (newtons if the mesh is in metres).

mod body;
mod fits;
mod warnings;

use std::time::Instant;

use bdtree_format::MODE_COUNT_MAX;
use serde::Serialize;

use crate::basis::Basis;
use crate::basis::modal::{ModalField, modal_basis};
use crate::basis::volume::silent_warning;
use crate::elastic::assemble::system::System;
use crate::elastic::constraint::fix::constrain_all;
use crate::elastic::element::spline::Element;
use crate::elastic::lattice::locate::anchors;
use crate::elastic::lattice::mass::LatticeMass;
use crate::elastic::lattice::resolution::{
    BYTES_PER_CELL, LatticeError, cell_limit, choose_lattice,
};
use crate::elastic::lattice::{Lattice, Subject};
use crate::elastic::solve::factor::FactorError;
use crate::elastic::solve::{Limits, Solution, SolveError, solve};
use crate::elastic::surface::components::{Kind, find_components};
use crate::error::{BakeError, Part, Place, Problems};
use crate::figures::{counted, digits};
use crate::input::RawMesh;
use crate::mass::Body;
use crate::progress::Progress;
use crate::vec3::{bounds, norm, sub};

pub use crate::elastic::constraint::fix::{Fix, FixRegion};
pub use crate::elastic::lattice::resolution::{NODE_BUDGET, RESOLUTION_MAX};

/// What to bake, and of what.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticOptions {
    /// Number of modes K above the rigid ones, all pieces together. Default 10.
    pub mode_count: usize,
    /// Cells along the longest side; `None` takes as many as [`NODE_BUDGET`] and a budget of work
    /// allow.
    pub resolution: Option<u32>,
    /// Young's modulus in Pa. Default 2e9 (a stiff plastic).
    pub young_pa: f64,
    /// Poisson's ratio, in (-1, 0.5). Default 0.35.
    pub poisson: f64,
    /// Density in kg/m³. Default 1000.
    pub density_kg_m3: f64,
    /// Metres per mesh unit. Default 1.
    pub scale_m: f64,
    /// Thickness of open sheets in mesh units; `None` takes 1 % of the box diagonal and warns.
    pub thickness: Option<f64>,
    /// What is held.
    pub fixes: Vec<Fix>,
    /// Bakes that would take more are refused before they do. Default 4 GiB.
    pub memory_limit_bytes: u64,
    /// Up to this many unknowns per component an inertia count proves that no mode was missed.
    /// Default 70 000.
    pub verify_dof_max: usize,
    /// Threads to work with; the modes do not depend on it. Default 1.
    pub threads: usize,
}

impl Default for ElasticOptions {
    fn default() -> Self {
        Self {
            mode_count: 10,
            resolution: None,
            young_pa: 2e9,
            poisson: 0.35,
            density_kg_m3: 1000.0,
            scale_m: 1.0,
            thickness: None,
            fixes: Vec::new(),
            memory_limit_bytes: 4 << 30,
            verify_dof_max: 70_000,
            threads: 1,
        }
    }
}

/// A surface component, named by its triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SurfaceComponentId {
    /// Lowest triangle id.
    pub first_triangle: u32,
    /// Number of triangles.
    #[serde(rename = "triangles")]
    pub triangle_count: u32,
}

/// How the modes were found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ElasticReport {
    /// Cells along the longest side.
    pub resolution: u32,
    /// Cells that are filled, at least in part.
    pub cells: usize,
    /// Unknowns.
    pub dofs: usize,
    /// Bodies that vibrate on their own.
    pub components: usize,
    /// Edge of a cell (mesh units).
    pub cell_size: f64,
    /// Memory that the solution was predicted to take.
    pub predicted_bytes: u64,
    /// Total mass in kg.
    pub mass_kg: f64,
    /// Worst ‖Kx − λMx‖ / (λ‖Mx‖) of the modes.
    pub residual_max: f64,
    /// Whether inertia counts proved that no mode was missed.
    pub inertia_checked: bool,
    /// Surface components that move in none of the modes.
    pub pieces_without_mode: Vec<SurfaceComponentId>,
    /// What is known of the body's mass: that of the cells holds where the surface is not closed.
    #[serde(skip)]
    pub body: Body,
    /// Stage name and seconds.
    #[serde(skip)]
    pub stages: Vec<(&'static str, f64)>,
}

/// The K lowest elastic modes of a surface mesh, ascending in frequency, each with ω and modal mass.
///
/// Time grows with the cells (see docs/reference/elastic.md), hardly with the triangles.
///
/// # Errors
/// Bad options (all of them at once), a mesh without area, a fix that holds nothing or everything,
/// more modes than the lattice has, memory beyond the limit.
pub fn elastic_basis(
    mesh: &RawMesh,
    options: &ElasticOptions,
    progress: &dyn Progress,
    warnings: &mut Vec<String>,
) -> Result<(Basis, ElasticReport), BakeError> {
    check_options(options)?;
    check_mesh(mesh)?;
    let mut report = ElasticReport::default();
    let mut clock = Instant::now();
    let mut lap = |report: &mut ElasticReport, name| {
        report.stages.push((name, clock.elapsed().as_secs_f64()));
        clock = Instant::now();
    };

    progress.stage("pieces", None);
    let subject = read_subject(mesh, options, warnings)?;
    lap(&mut report, "pieces");

    progress.stage("lattice", None);
    let (lattice, resolution) =
        choose_lattice(&subject, options.resolution, options.memory_limit_bytes).map_err(
            |error| match error {
                LatticeError::TooManyCells(resolution) => too_many_cells(
                    options,
                    resolution,
                    fits::finest(&subject, options, resolution, None, progress),
                ),
                LatticeError::Bake(error) => error,
            },
        )?;
    warnings::thin(&subject, &lattice, resolution, warnings);
    let constraints = constrain_all(&subject, &lattice, &options.fixes)?;
    report.resolution = resolution;
    report.cells = lattice.parts.len();
    report.dofs = 3 * lattice.node_count();
    report.components = lattice.components.len();
    report.cell_size = lattice.grid.cell_size;
    lap(&mut report, "lattice");

    let element = Element::new(options.poisson);
    let system = |c: usize| System::of_lattice(&lattice.components[c], &element, &constraints[c]);
    let solution = solve(&lattice.sizes(), system, limits(options), progress);
    let solution = solution.map_err(|error| {
        // Only what is refused is worth the search.
        let finest = match error {
            SolveError::Memory(bytes) => {
                fits::finest(&subject, options, resolution, Some(bytes), progress)
            }
            _ => None,
        };
        solve_error(error, options, resolution, finest)
    })?;
    if solution.modes.len() < options.mode_count {
        return Err(BakeError::one(
            "basis",
            Place::option("--modes"),
            format!(
                "{} modes asked for, but the lattice of {} has only {}; raise --resolution \
                 (now {resolution})",
                options.mode_count,
                counted(report.cells, "cell"),
                solution.available
            ),
        ));
    }
    report.predicted_bytes = solution.bytes + BYTES_PER_CELL * report.cells as u64;
    report.residual_max = solution.residual;
    report.inertia_checked = solution.checked;
    lap(&mut report, "modes");

    progress.stage("vertices", None);
    let size_m = lattice.grid.cell_size * options.scale_m;
    let cell_mass = options.density_kg_m3 * size_m.powi(3);
    let shares = lattice.components.iter().flat_map(|c| &c.moments);
    report.mass_kg = cell_mass * shares.map(|m| m[0]).sum::<f64>();
    warnings::size(mesh, options, report.mass_kg, warnings);
    let mass = LatticeMass::new(&lattice);
    report.body = body::body(&subject, &mass, options);
    let basis = to_vertices(&subject, &lattice, &solution, &mass, options, warnings);
    list_silent_pieces(&subject, &lattice, &solution, &mut report, warnings);
    lap(&mut report, "vertices");
    Ok((basis, report))
}

fn limits(options: &ElasticOptions) -> Limits {
    Limits {
        wanted: options.mode_count,
        bytes: options.memory_limit_bytes,
        verify_dof_max: options.verify_dof_max,
        threads: options.threads,
    }
}

fn check_options(options: &ElasticOptions) -> Result<(), BakeError> {
    let mut problems = check_values(
        &[
            ("--young", Some(options.young_pa)),
            ("--density", Some(options.density_kg_m3)),
            ("--scale", Some(options.scale_m)),
            ("--thickness", options.thickness),
        ],
        Some(options.poisson),
    );
    let mut add = |name, message: String| problems.add(|| (Place::option(name), message));
    if options.mode_count == 0 {
        add("--modes", "no elastic mode is asked for".to_owned());
    }
    if options.mode_count > MODE_COUNT_MAX {
        let message = format!("{} is more than {MODE_COUNT_MAX}", options.mode_count);
        add("--modes", message);
    }
    if let Some(r) = options.resolution
        && !(1..=RESOLUTION_MAX).contains(&r)
    {
        let message = format!("{r} is not between 1 and {RESOLUTION_MAX}");
        add("--resolution", message);
    }
    check_axes(&options.fixes, &mut problems);
    problems.into_result(Place::NOWHERE)
}

/// What is wrong with options that surfaces and volumes have: numbers that must be positive, Poisson's ratio.
pub(super) fn check_values(
    positive: &[(&'static str, Option<f64>)],
    poisson: Option<f64>,
) -> Problems {
    let mut problems = Problems::new("basis");
    for (name, value) in positive {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            let message = format!("{value} is not a positive number");
            problems.add(|| (Place::option(name), message));
        }
    }
    if let Some(value) = poisson.filter(|v| !(*v > -1.0 && *v < 0.5)) {
        let message = format!("{value} is not between -1 and 0.5");
        problems.add(|| (Place::option("--poisson"), message));
    }
    problems
}

/// Adds the fixes that hold no axis.
pub(super) fn check_axes(fixes: &[Fix], problems: &mut Problems) {
    for _ in fixes.iter().filter(|fix| fix.axes == [false; 3]) {
        problems.add(|| (Place::option("--fix"), "no axis is named"));
    }
}

fn check_mesh(mesh: &RawMesh) -> Result<(), BakeError> {
    let bad = |part: Part, message: &str| Err(BakeError::one("basis", part, message));
    for (i, p) in mesh.positions.iter().enumerate() {
        // Products of three lengths must stay finite.
        if p.iter().any(|x| x.is_nan() || x.abs() > 1e90) {
            return bad(Part::Vertex(i), "its position is not a number below 1e90");
        }
    }
    for (i, t) in mesh.triangles.iter().enumerate() {
        if t.iter().any(|&v| v as usize >= mesh.positions.len()) {
            return bad(Part::Triangle(i), "a corner index is out of range");
        }
    }
    Ok(())
}

fn read_subject<'a>(
    mesh: &'a RawMesh,
    options: &ElasticOptions,
    warnings: &mut Vec<String>,
) -> Result<Subject<'a>, BakeError> {
    let surface = find_components(&mesh.positions, &mesh.triangles);
    if surface.list.is_empty() {
        return Err(BakeError::one(
            "basis",
            Place::file(&mesh.name),
            "no triangle has an area, so there is no mass to vibrate (--modes 0 bakes it rigid)",
        ));
    }
    let corners = mesh.triangles.iter().flatten();
    let (min, max) = bounds(corners.map(|&v| mesh.positions[v as usize]));
    let diagonal = norm(sub(max, min));
    let thickness = options.thickness.unwrap_or(0.01 * diagonal);
    if thickness > diagonal {
        return Err(BakeError::one(
            "basis",
            Place::option("--thickness"),
            format!("{thickness} is more than the mesh's diagonal, {diagonal}"),
        ));
    }
    let sheets = surface
        .list
        .iter()
        .filter(|p| p.kind != Kind::Solid)
        .count();
    if sheets > 0 && options.thickness.is_none() {
        let pieces = match (sheets, surface.list.len()) {
            (1, 1) => "the mesh encloses no volume and is taken as a sheet".to_string(),
            (1, all) => format!("1 of {all} pieces encloses no volume and is taken as a sheet"),
            (_, all) => {
                format!("{sheets} of {all} pieces enclose no volume and are taken as sheets")
            }
        };
        warnings.push(format!(
            "{pieces} {} thick (1 % of the diagonal); set --thickness",
            digits(thickness, 3)
        ));
    }
    let mut subject = Subject::new(mesh, surface, thickness);
    subject.threads = options.threads;
    Ok(subject)
}

/// What to do where memory does not suffice: `finest` cells along the longest side fit.
fn instead(finest: Option<u32>) -> String {
    match finest {
        Some(finest) => format!("--resolution {finest} fits"),
        None => "raise the limit".to_string(),
    }
}

fn too_many_cells(options: &ElasticOptions, resolution: u32, finest: Option<u32>) -> BakeError {
    let limit = options.memory_limit_bytes;
    let message = format!(
        "{resolution} cells along the longest side make more than {}, which do not fit in {} MiB (--memory-limit); {}",
        counted(cell_limit(limit), "cell"),
        limit >> 20,
        instead(finest)
    );
    BakeError::one("basis", Place::option("--resolution"), message)
}

/// `finest`: the most cells along the longest side that are known to fit, where memory does not suffice.
fn solve_error(
    error: SolveError,
    options: &ElasticOptions,
    resolution: u32,
    finest: Option<u32>,
) -> BakeError {
    let message = match error {
        SolveError::Memory(bytes) => {
            // The number of cells is only the option's where that was given.
            let place = match options.resolution {
                Some(_) => Place::option("--resolution"),
                None => Place::NOWHERE,
            };
            let limit = options.memory_limit_bytes;
            let message = format!(
                "{resolution} cells along the longest side need about {} MiB, the limit is {} MiB (--memory-limit); {}",
                bytes.div_ceil(1 << 20),
                limit >> 20,
                instead(finest)
            );
            return BakeError::one("basis", place, message);
        }
        SolveError::Factor(c, FactorError::Memory) => {
            format!("component {c}: not enough memory at resolution {resolution}")
        }
        SolveError::Factor(c, FactorError::Pivot) => format!(
            "component {c}: its stiffness is not positive definite to rounding; try another \
             --resolution, or a --poisson farther from -1 and 0.5 (now {})",
            options.poisson
        ),
        SolveError::Missed(c, counted, found) => format!(
            "component {c}: the inertia count finds {counted} modes where the iteration found \
             {found}; try another --resolution"
        ),
        SolveError::Residual(worst) => {
            format!(
                "the modes converged to a residual of {worst:.1e} only; try another --resolution"
            )
        }
        SolveError::Element(c, cell) => format!("component {c}: cell {cell} has no stiffness"),
    };
    BakeError::one("basis", Part::The("elastic modes"), message)
}

fn to_vertices(
    subject: &Subject<'_>,
    lattice: &Lattice,
    solution: &Solution,
    mass: &LatticeMass,
    options: &ElasticOptions,
    warnings: &mut Vec<String>,
) -> Basis {
    let anchors = anchors(subject, lattice);
    let size_m = lattice.grid.cell_size * options.scale_m;
    let cell_mass = options.density_kg_m3 * size_m.powi(3);
    let speed = (options.young_pa / options.density_kg_m3).sqrt();
    let fields = solution.modes.iter().map(|mode| ModalField {
        field: anchors
            .iter()
            .map(|anchor| {
                let mut u = [0.0; 3];
                for a in anchor.iter().filter(|a| a.component == mode.component) {
                    for (&n, w) in a.nodes.iter().zip(a.weights) {
                        for (axis, x) in u.iter_mut().enumerate() {
                            *x += w * mode.vector[3 * n as usize + axis];
                        }
                    }
                }
                u
            })
            .collect(),
        omega_rad_s: mode.value.max(0.0).sqrt() * speed / size_m,
        modal_mass_kg: cell_mass,
        momentum: Some(mass.momentum(mode, cell_mass)),
    });
    modal_basis(subject.mesh.positions.len(), fields, warnings)
}

fn list_silent_pieces(
    subject: &Subject<'_>,
    lattice: &Lattice,
    solution: &Solution,
    report: &mut ElasticReport,
    warnings: &mut Vec<String>,
) {
    let mut moving = vec![false; lattice.components.len()];
    for mode in &solution.modes {
        moving[mode.component] = true;
    }
    let mut body_moves = vec![false; subject.surface.list.len()];
    for (body, component) in lattice.bodies() {
        body_moves[body as usize] |= moving[component];
    }
    for component in subject.surface.list.iter().filter(|p| !body_moves[p.body]) {
        report.pieces_without_mode.push(SurfaceComponentId {
            first_triangle: component.triangles[0].0,
            triangle_count: component.triangles.len() as u32,
        });
    }
    let silent = report.pieces_without_mode.iter();
    let triangles = silent.map(|p| format!("triangle {}", p.first_triangle));
    let count = subject.surface.list.len();
    warnings.extend(silent_warning(triangles, count, "pieces", solution));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_told_in_mebibytes_and_the_option_only_where_it_was_given() {
        let mut options = ElasticOptions {
            memory_limit_bytes: 200 << 20,
            ..ElasticOptions::default()
        };
        let told = |options: &ElasticOptions, finest| {
            solve_error(SolveError::Memory(300 << 20), options, 57, finest).to_string()
        };
        let text = "57 cells along the longest side need about 300 MiB, the limit is 200 MiB (--memory-limit); ";
        assert_eq!(
            told(&options, Some(46)),
            format!("{text}--resolution 46 fits")
        );
        options.resolution = Some(57);
        assert_eq!(
            told(&options, None),
            format!("--resolution: {text}raise the limit")
        );
    }
}
