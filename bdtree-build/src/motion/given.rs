//! Fields made elsewhere.

use bdtree_format::MODE_COUNT_MAX;

use super::{Moving, name};
use crate::basis::dropped::keep_fields;
use crate::basis::given::given_basis;
use crate::error::BakeError;
use crate::input::RawMesh;
use crate::recipe::Given;

/// The mesh with the given fields.
pub(super) fn moving(mesh: RawMesh, given: &Given) -> Result<Moving, BakeError> {
    let path = given.path.as_path();
    let frequencies = given.frequencies.as_deref();
    let read = given_basis(path, given.layout, frequencies, mesh.positions.len())?;
    let too_few = given.keep.warning(&name(path), read.basis.mode_count());
    let mut moving = Moving::new(mesh, read.basis, "given");
    moving.provenance.warnings = read.warnings;
    moving.provenance.warnings.extend(too_few);
    moving.modes_available = Some(moving.basis.mode_count());
    // Before fields are left out: ranges say which matter least.
    moving.set_ranges(given.range_rel);
    let kept = keep_fields(&moving.mesh, moving.basis, given.keep)?;
    let count = kept.basis.mode_count();
    if count > MODE_COUNT_MAX {
        let message = format!(
            "{count} fields, but a .bdt file holds at most {MODE_COUNT_MAX} modes (--modes {MODE_COUNT_MAX} keeps the \
             first)"
        );
        return Err(BakeError::one("basis", path, message));
    }
    moving.basis = kept.basis;
    moving.provenance.error = Some(kept.error);
    moving.set("basis", name(path));
    moving.set_some("basis-layout", given.layout);
    moving.set_some("frequencies", frequencies.map(name));
    Ok(moving)
}
