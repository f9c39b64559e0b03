//! Morph targets of the input itself.

use bdtree_build::basis::dropped::Keep;
use bdtree_build::basis::morph::morph_basis;
use bdtree_build::error::BakeError;
use bdtree_build::input::RawMorphs;

use super::Source;
use crate::cli::Arguments;
use crate::cli::arguments::Modes;

/// Adds morph targets, and their weights over time if the file has some.
pub(super) fn add(
    arguments: &Arguments,
    morphs: &RawMorphs,
    source: &mut Source,
) -> Result<(), BakeError> {
    let limit_bytes = arguments.memory_limit.saturating_mul(1 << 20);
    let warnings = &mut source.warnings;
    let morph = morph_basis(&source.mesh, morphs, keep(arguments), limit_bytes, warnings)?;
    source.basis = morph.basis;
    for (mode, weight) in source.basis.modes.iter_mut().zip(morph.default_weights) {
        mode.default_q = Some(weight);
    }
    source.kind = "morph";
    source.error = Some(morph.error);
    if let Some(clip) = &morphs.clip {
        source.set("clip", &clip.name);
    }
    Ok(())
}

/// What `--modes` says of fields that are already there.
pub(super) fn keep(arguments: &Arguments) -> Keep {
    match arguments.modes() {
        Modes::Unsaid => Keep::All,
        Modes::Count(count) => Keep::First(count),
        Modes::Auto(max_error_rel) => Keep::Auto { max_error_rel },
    }
}
