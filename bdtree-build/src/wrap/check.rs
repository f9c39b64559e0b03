//! What a shape must satisfy before it is stored.

use bdtree_format::MODE_COUNT_MAX;

use crate::basis::Basis;
use crate::error::{BakeError, Part, Place, Problems};
use crate::input::RawMesh;

/// Problems listed before the rest is only counted.
const PROBLEMS_MAX: usize = 20;

/// Counts that fit the file and each other.
pub(super) fn check_counts(mesh: &RawMesh, basis: &Basis) -> Result<(), BakeError> {
    let fail = |message: String| Err(BakeError::one("encode", Place::file(&mesh.name), message));
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    if triangles == 0 {
        return fail("the mesh has no triangles".to_string());
    }
    if u32::try_from(vertices).is_err() || u32::try_from(triangles).is_err() {
        return fail(format!(
            "{vertices} vertices and {triangles} triangles: a file holds fewer than 2^32 of each"
        ));
    }
    if basis.mode_count() > MODE_COUNT_MAX {
        return fail(format!(
            "{} modes: a file holds at most {MODE_COUNT_MAX}",
            basis.mode_count()
        ));
    }
    let whole = basis.vertex_count.checked_mul(basis.mode_count());
    if (basis.mode_count() > 0 && basis.vertex_count != vertices)
        || whole != Some(basis.fields.len())
    {
        return fail(format!(
            "the basis has {} displacements for {} modes of {} vertices, the mesh has {vertices} \
             vertices",
            basis.fields.len(),
            basis.mode_count(),
            basis.vertex_count,
        ));
    }
    Ok(())
}

/// Numbers that are numbers, corners and groups that exist.
pub(super) fn check_numbers(mesh: &RawMesh, basis: &Basis) -> Result<(), BakeError> {
    let mut problems = none_yet();
    let vertices = mesh.positions.len();
    for (i, p) in mesh.positions.iter().enumerate() {
        if !p.iter().all(|x| x.is_finite()) {
            problems.add(|| (Part::Vertex(i), format!("position {p:?} is not finite")));
        }
    }
    for (i, corners) in mesh.triangles.iter().enumerate() {
        if corners.iter().any(|&corner| corner as usize >= vertices) {
            let message = format!("corners {corners:?} are not all below {vertices} vertices");
            problems.add(|| (Part::Triangle(i), message));
        }
    }
    for group in &mesh.groups {
        let end = u64::from(group.first_triangle) + u64::from(group.triangle_count);
        if end > mesh.triangles.len() as u64 {
            let message = format!("ends at triangle {end} of {}", mesh.triangles.len());
            problems.add(|| (Part::Group(group.name.clone()), message));
        }
    }
    for (j, mode) in basis.modes.iter().enumerate() {
        // As `Asset::open` asks of the mode table.
        let (omega, mass) = (mode.omega_rad_s, mode.modal_mass_kg);
        let omega = omega.filter(|x| !(*x >= 0.0 && x.is_finite()));
        let mass = mass.filter(|x| !(*x > 0.0 && x.is_finite()));
        let weight = mode.default_q.filter(|x| !x.is_finite());
        let refused = [
            omega.map(|x| format!("angular frequency {x} rad/s is not a number of at least 0")),
            mass.map(|x| format!("modal mass {x} kg is not a positive number")),
            weight.map(|x| format!("default weight {x} is not finite")),
        ];
        for message in refused.into_iter().flatten() {
            problems.add(|| (Part::Mode(j), message));
        }
        for (i, u) in basis.field(j).iter().enumerate() {
            if !u.iter().all(|x| x.is_finite()) {
                let message = format!("displacement {u:?} is not finite");
                problems.add(|| (Place::from(Part::Mode(j)).at(Part::Vertex(i)), message));
            }
        }
        if mode
            .q_range
            .is_some_and(|range| !(range > 0.0 && range.is_finite()))
        {
            let message = format!(
                "range of q {} is not a positive number",
                mode.q_range.unwrap_or(f64::NAN)
            );
            problems.add(|| (Part::Mode(j), message));
        }
    }
    problems.into_result(Place::NOWHERE)
}

/// For the problems of this stage, the first few in full.
pub(super) fn none_yet() -> Problems {
    Problems::listing(PROBLEMS_MAX, "encode", |more| {
        format!("and {more} more of this kind")
    })
}
