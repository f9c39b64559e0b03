//! `--basis`: fields made elsewhere.

use std::path::Path;

use bdtree_build::basis::dropped::{Keep, keep_fields};
use bdtree_build::basis::given::given_basis;
use bdtree_build::error::BakeError;

use super::morph::keep;
use super::{Source, name};
use crate::cli::Arguments;

/// Adds the fields at `path` to a mesh.
pub(super) fn add(
    arguments: &Arguments,
    path: &Path,
    source: &mut Source,
) -> Result<(), BakeError> {
    let frequencies = arguments.frequencies.as_deref();
    let given = given_basis(
        path,
        arguments.basis_layout,
        frequencies,
        source.mesh.positions.len(),
    )?;
    source.warnings.extend(given.warnings);
    let found = given.basis.mode_count();
    if let Keep::First(count) = keep(arguments)
        && count > found
    {
        let message = format!("--modes {count}, but the array holds {found} fields");
        let place = path.display().to_string();
        return Err(BakeError::one("basis", place, message));
    }
    source.basis = given.basis;
    source.set_ranges(arguments);
    let kept = keep_fields(
        &source.mesh,
        std::mem::take(&mut source.basis),
        keep(arguments),
    )?;
    source.basis = kept.basis;
    source.error = Some(kept.error);
    source.kind = "given";
    source.set("basis", name(path));
    if let Some(layout) = arguments.basis_layout {
        source.set("basis-layout", layout);
    }
    if let Some(frequencies) = frequencies {
        source.set("frequencies", name(frequencies));
    }
    Ok(())
}
