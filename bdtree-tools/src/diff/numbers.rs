//! Numbers, compared against the largest magnitude of their quantity in both files.
//!
//! | numbers | scale |
//! |---|---|
//! | origin | origin and size of the mesh |
//! | mode table, each column | its largest entry |
//! | rest positions; sphere centers and radii | their largest |
//! | U_ij; Ū_j and ΔR_j; b⁺_j and b⁻_j (the last two: beyond what their grids explain) | the largest of the mode |
//! | δR; δR of scaled steps | their largest |
//! | mass properties and momenta | see `mass` |
//! | times and rotations of frames; q of a mode in all frames | their largest |
//! | translations of frames | their largest and the size of the mesh |

use bdtree_format::{Header, LANES, ModeRecord, ROW_RADIUS, ROWS_LEADING};
use bdtree_runtime::{Asset, FormatError, NodeRows, VertexId};

use super::findings::{Findings, Numbers, largest};
use super::words::known;
use crate::AssetFile;
use crate::error::ToolError;
use crate::output::digits;

/// Names of the components of a vector.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// Compares the header's real numbers.
pub(super) fn compare_header(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let sizes = [mesh_size(a), mesh_size(b)];
    let scale = largest(a.origin().into_iter().chain(b.origin()).chain(sizes));
    let mut numbers = findings.numbers("header: origin", scale);
    for (axis, (x, y)) in a.origin().into_iter().zip(b.origin()).enumerate() {
        numbers.compare(x, y, || AXES[axis].to_string());
    }
    numbers.finish(findings);

    let norm = |header: &Header| f64::from(header.position_norm_max.get());
    let (x, y) = (norm(a.header()), norm(b.header()));
    let mut numbers = findings.numbers("header: position_norm_max", largest([x, y]));
    numbers.compare(x, y, || {
        "farthest position from the origin, stored units".to_string()
    });
    numbers.finish(findings);
}

/// How far the mesh reaches from its origin (mesh units).
pub(super) fn mesh_size(asset: &Asset<'_>) -> f64 {
    f64::from(asset.header().position_norm_max.get()) * asset.unit()
}

/// Compares the mode tables. An unknown frequency or mass (−1) equals only an unknown one.
pub(super) fn compare_modes(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    type Column = (&'static str, fn(&ModeRecord) -> f64);
    let columns: [Column; 6] = [
        ("q_limit", |m| m.q_limit.get().into()),
        ("q_range", |m| m.q_range.get().into()),
        ("step_scale", |m| m.step_scale.get().into()),
        ("field_norm_max", |m| m.field_norm_max.get().into()),
        ("omega_rad_s", |m| m.omega_rad_s.get()),
        ("modal_mass_kg", |m| m.modal_mass_kg.get()),
    ];
    for (name, value) in columns {
        let scale = largest(a.modes().iter().chain(b.modes()).map(value));
        let what = format!("mode table: {name}");
        let mut numbers = findings.numbers(&what, scale);
        for (j, (x, y)) in a.modes().iter().zip(b.modes()).enumerate() {
            let (x, y) = (value(x), value(y));
            if (x == -1.0) == (y == -1.0) {
                numbers.compare(x, y, || format!("mode {j}"));
            } else {
                let told = [x, y].map(|x| known((x != -1.0).then(|| digits(x))));
                findings.compare(&format!("{what}: known or not, mode {j}"), told);
            }
        }
        numbers.finish(findings);
    }
}

/// Compares rest positions.
pub(super) fn compare_positions(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let all = |asset: &Asset<'_>| largest(asset.positions().as_flattened().iter().map(widen));
    let scale = largest([all(a), all(b)]);
    let mut numbers = findings.numbers("section VERT: rest positions", scale);
    for (i, (x, y)) in a.positions().iter().zip(b.positions()).enumerate() {
        compare_vectors(&mut numbers, i, *x, *y);
    }
    numbers.finish(findings);
}

fn compare_vectors(numbers: &mut Numbers, vertex: usize, x: [f32; 3], y: [f32; 3]) {
    for (axis, name) in AXES.into_iter().enumerate() {
        let place = || format!("vertex {vertex} {name}");
        numbers.compare(x[axis].into(), y[axis].into(), place);
    }
}

/// Compares displacements, each mode against its own scale. What one file stores and the other
/// leaves out is compared with zero.
///
/// # Errors
/// Displacements or mode lists outside their sections, in the file that is named.
pub(super) fn compare_displacements(
    files: [&AssetFile; 2],
    findings: &mut Findings,
) -> Result<(), ToolError> {
    let first = files[0].asset();
    let vertices = || (0..first.vertex_count() as u32).map(VertexId);
    let fields = |which: usize, vertex: VertexId| {
        let own = files[which].asset().displacements(vertex);
        own.map_err(|error| files[which].error(error))
    };
    let mut scales = vec![0.0; first.mode_count()];
    for vertex in vertices() {
        for which in 0..2 {
            for (mode, u) in fields(which, vertex)?.iter() {
                // A mode that does not exist is in the lists, which are compared as they are.
                if let Some(scale) = scales.get_mut(mode) {
                    *scale = largest(u.iter().map(widen).chain([*scale]));
                }
            }
        }
    }
    let mut modes: Vec<Numbers> = scales
        .into_iter()
        .enumerate()
        .map(|(j, scale)| {
            let what = format!("section DISP: displacements of mode {j}");
            findings.numbers(what, scale)
        })
        .collect();
    for vertex in vertices() {
        let (a, b) = (fields(0, vertex)?, fields(1, vertex)?);
        let only_b = b.iter().filter(|(mode, _)| !a.has(*mode));
        for (mode, _) in a.iter().chain(only_b) {
            let Some(numbers) = modes.get_mut(mode) else {
                continue;
            };
            compare_vectors(numbers, vertex.0 as usize, a.of(mode), b.of(mode));
        }
    }
    for numbers in modes {
        numbers.finish(findings);
    }
    Ok(())
}

/// Compares the rows of nodes that are equal in both files.
///
/// # Errors
/// Rows or mode lists outside their sections.
pub(super) fn compare_rows(
    a: &Asset<'_>,
    b: &Asset<'_>,
    findings: &mut Findings,
) -> Result<(), FormatError> {
    let m = a.mode_count();
    let mut scales = vec![0.0_f64; quantity_count(m)];
    for asset in [a, b] {
        for node in asset.nodes() {
            let modes = asset.node_modes(node)?;
            for (r, row) in numbers(&asset.node_rows(node)?, modes.len())
                .iter()
                .enumerate()
            {
                if let Some(scale) = scales.get_mut(quantity(r, modes, m)) {
                    *scale = scale.max(largest(row.iter().copied()));
                }
            }
        }
    }
    let mut quantities: Vec<Numbers> = scales
        .into_iter()
        .enumerate()
        .map(|(k, scale)| findings.numbers(quantity_name(k, m), scale))
        .collect();
    for (i, (node_a, node_b)) in a.nodes().iter().zip(b.nodes()).enumerate() {
        let modes = a.node_modes(node_a)?;
        let (own_a, own_b) = (a.node_rows(node_a)?, b.node_rows(node_b)?);
        let (rows_a, rows_b) = (numbers(&own_a, modes.len()), numbers(&own_b, modes.len()));
        let units = [0, 1, 2].map(|k| f64::from(own_a.units[k].max(own_b.units[k])));
        for (r, (x, y)) in rows_a.iter().zip(&rows_b).enumerate() {
            if let Some(numbers) = quantities.get_mut(quantity(r, modes, m)) {
                for k in 0..LANES {
                    let larger = |row: usize| rows_a[row][k].max(rows_b[row][k]);
                    let grid = grid(r, modes.len(), units, larger);
                    numbers
                        .compare_rounded(x[k], y[k], grid, || format!("node {i} row {r} lane {k}"));
                }
            }
        }
    }
    for numbers in quantities {
        numbers.finish(findings);
    }
    Ok(())
}

fn widen(x: &f32) -> f64 {
    f64::from(*x)
}

/// Ū_x, Ū_y, Ū_z, ΔR, b⁺ and b⁻.
const NUMBERS_PER_MODE: usize = 6;

/// The numbers of a node, one row of lanes each: the f32 rows as they are, those of the modes in
/// stored units for a q at its limit.
fn numbers(rows: &NodeRows<'_>, mode_count: usize) -> Vec<[f64; LANES]> {
    let [center, growth, cross] = rows.units.map(f64::from);
    let units = [center, center, center, growth, cross, cross];
    let mut all: Vec<_> = rows.leading.iter().map(|row| row.map(f64::from)).collect();
    for k in 0..mode_count {
        let lanes: [_; LANES] = std::array::from_fn(|lane| rows.numbers(k, lane));
        for (which, unit) in units.iter().enumerate() {
            all.push(lanes.map(|numbers| f64::from(numbers[which]) * unit));
        }
    }
    all.extend(rows.steps.iter().map(|row| row.map(f64::from)));
    all
}

/// By how much a lane's numbers of row `row` may differ between two files whose unrounded numbers
/// agree; `larger` is the larger of both files in a row.
///
/// Ū is half a unit off in each coordinate, so each w_ij less than one; ΔR follows that and is
/// rounded up. In b⁺ and b⁻ the product x·w moves by R times that, and √(d e) by the root of the
/// change of e = ΔR² − ‖w‖², times R at most.
fn grid(row: usize, mode_count: usize, units: [f64; 3], larger: impl Fn(usize) -> f64) -> f64 {
    let Some(behind) = row.checked_sub(ROWS_LEADING) else {
        return 0.0;
    };
    let (k, which) = (behind / NUMBERS_PER_MODE, behind % NUMBERS_PER_MODE);
    if k >= mode_count {
        return 0.0;
    }
    let [center, growth, cross] = units;
    match which {
        0..3 => center,
        3 => 2.0 * center + growth,
        _ => {
            let widest = larger(ROWS_LEADING + NUMBERS_PER_MODE * k + 3);
            let root = (2.0 * widest * (2.0 * center + growth)).sqrt();
            2.0 * larger(ROW_RADIUS) * (center + root) + cross
        }
    }
}

/// Centers and radii, two per mode, δR, δR of scaled steps.
fn quantity_count(mode_count: usize) -> usize {
    3 + 2 * mode_count
}

/// Which quantity a node's row holds; out of range when its mode does not exist.
fn quantity(row: usize, modes: &[u16], mode_count: usize) -> usize {
    let Some(behind) = row.checked_sub(ROWS_LEADING) else {
        return 0;
    };
    match modes.get(behind / NUMBERS_PER_MODE) {
        Some(mode) if usize::from(*mode) < mode_count => {
            1 + 2 * usize::from(*mode) + usize::from(behind % NUMBERS_PER_MODE >= 4)
        }
        Some(_) => usize::MAX,
        None => 1 + 2 * mode_count + (behind - NUMBERS_PER_MODE * modes.len()),
    }
}

fn quantity_name(quantity: usize, mode_count: usize) -> String {
    let name = match quantity {
        0 => "centers and radii".to_string(),
        k if k == 1 + 2 * mode_count => "radius growth delta-R".to_string(),
        k if k == 2 + 2 * mode_count => "radius growth delta-R of scaled steps".to_string(),
        k if k % 2 == 1 => format!("mean displacement and growth of mode {}", (k - 1) / 2),
        k => format!("b+ and b- of mode {}", (k - 1) / 2),
    };
    format!("section ROWS: {name}")
}
