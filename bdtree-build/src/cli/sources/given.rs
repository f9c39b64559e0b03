//! `--basis`: fields made elsewhere.

use std::path::Path;

use bdtree_build::basis::given::given_basis;
use bdtree_build::error::BakeError;

use super::{Source, name};
use crate::cli::Arguments;
use crate::cli::arguments::Modes;

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
    let mut basis = given.basis;
    if let Modes::Count(count) = arguments.modes() {
        let found = basis.mode_count();
        if count > found {
            let message = format!("--modes {count}, but the array holds {found} fields");
            let place = path.display().to_string();
            return Err(BakeError::one("basis", place, message));
        }
        basis.modes.truncate(count);
        basis.fields.truncate(count * basis.vertex_count);
    }
    source.basis = basis;
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
