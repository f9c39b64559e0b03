//! What is odd about a body, for the warnings: its size, walls that are thin beside a cell.

use super::{ElasticOptions, RESOLUTION_MAX};
use crate::elastic::lattice::{Lattice, Subject};
use crate::elastic::surface::components::{Kind, SurfaceComponent};
use crate::figures::digits;
use crate::input::RawMesh;

/// Surface components thinner than this share of a cell are warned about.
const THIN_SHARE: f64 = 0.25;

/// Sizes in meters beyond which the unit of the mesh is more likely another.
const SIZES_M: [f64; 2] = [0.001, 100.0];

/// A mesh in millimeters that is taken for meters weighs as much as a mountain.
pub(super) fn size(
    mesh: &RawMesh,
    options: &ElasticOptions,
    mass_kg: f64,
    warnings: &mut Vec<String>,
) {
    let size_m = mesh.diagonal() * options.scale_m;
    let [least, most] = SIZES_M;
    if options.scale_m == ElasticOptions::default().scale_m && !(least..=most).contains(&size_m) {
        warnings.push(format!(
            "with 1 mesh unit taken as 1 m the mesh's diagonal is {} m and its mass {} kg; give --scale (meters per mesh \
             unit) if that is wrong",
            digits(size_m, 3),
            digits(mass_kg, 3)
        ));
    }
}

/// Folds between walls much thinner than a cell are too stiff: docs/reference/elastic.md.
pub(super) fn thin(
    subject: &Subject<'_>,
    lattice: &Lattice,
    resolution: u32,
    warnings: &mut Vec<String>,
) {
    let least = THIN_SHARE * lattice.grid.cell_size;
    let thickness = |p: &SurfaceComponent| match p.kind {
        Kind::Solid => 2.0 * p.volume.abs() / p.area,
        _ => subject.thickness,
    };
    let thin = subject.surface.list.iter().map(thickness);
    let thin: Vec<f64> = thin.filter(|t| *t < least).collect();
    let Some(thinnest) = thin.iter().copied().min_by(f64::total_cmp) else {
        return;
    };
    let cell_size = lattice.grid.cell_size;
    // Cells of four times the least thickness, one more for what rounding takes.
    let enough = (f64::from(resolution) * THIN_SHARE * cell_size / thinnest).floor() + 1.0;
    let all = subject.surface.list.len();
    warnings.push(thin_text([thin.len(), all], cell_size, enough));
}

/// That `count` of `all` pieces are thin; `enough` is the resolution at which none is.
fn thin_text([count, all]: [usize; 2], cell_size: f64, enough: f64) -> String {
    let (pieces, whose) = match (count, all) {
        (1, 1) => ("The body is".to_string(), "Its"),
        (1, _) => (format!("1 of {all} pieces is"), "Its"),
        _ => (format!("{count} of {all} pieces are"), "Their"),
    };
    let remedy = if enough <= f64::from(RESOLUTION_MAX) {
        format!("From --resolution {enough} on no piece is so thin.")
    } else {
        "Raise --resolution.".to_string()
    };
    // 8 to 18 %: what the chairs that were measured had above twice as many cells along each side.
    format!(
        "{pieces} thinner than a quarter of a cell (cell size {} mesh units). {whose} folds and joints come out too \
         stiff: frequencies may be 8 to 18 % too high at the default resolution, and more below it. {remedy}",
        digits(cell_size, 3)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thin_pieces_are_told_with_the_size_of_a_cell() {
        let thin_text = |count, all, size| thin_text([count, all], size, 64.0);
        let rest = "thinner than a quarter of a cell (cell size 12.4 mesh units).";
        let more = "folds and joints come out too stiff: frequencies may be 8 to 18 % too high at the default resolution, and more below it. From --resolution 64 on no piece is so thin.";
        assert_eq!(
            thin_text(2, 3, 12.39),
            format!("2 of 3 pieces are {rest} Their {more}")
        );
        assert_eq!(
            thin_text(1, 3, 12.39),
            format!("1 of 3 pieces is {rest} Its {more}")
        );
        assert_eq!(
            thin_text(1, 1, 12.39),
            format!("The body is {rest} Its {more}")
        );
    }
}
