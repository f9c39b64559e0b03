//! Morph targets of the mesh's own file.

use super::Moving;
use crate::basis::dropped::Keep;
use crate::basis::morph::morph_basis;
use crate::error::{BakeError, Part, Place};
use crate::input::{RawMesh, RawMorphs, RawSkin};
use crate::recipe::Morphs;

/// The mesh with its morph targets, and their weights over time if the file has some: as frames, or in the clips of its
/// skin.
pub(super) fn moving(
    mesh: RawMesh,
    morphs: &RawMorphs,
    mut skin: Option<RawSkin>,
    asked: &Morphs,
) -> Result<Moving, BakeError> {
    let mut warnings = Vec::new();
    let limit = asked.memory_limit_bytes;
    let morph = morph_basis(&mesh, morphs, asked.keep, limit, &mut warnings)?;
    if let Some(skin) = &mut skin {
        skin.keep_targets(&morph.targets);
    }
    let mut moving = Moving::new(mesh, morph.basis, "morph");
    moving.skin = skin;
    for (mode, weight) in moving.basis.modes.iter_mut().zip(morph.default_weights) {
        mode.default_q = Some(weight);
    }
    moving.modes_available = Some(morphs.targets.len());
    moving.provenance.error = Some(morph.error);
    moving.provenance.warnings = warnings;
    moving.set_some("clip", morphs.clip.as_ref().map(|clip| &clip.name));
    Ok(moving)
}

/// Why a mesh without morph targets does not do.
pub(super) fn missing(mesh: &RawMesh, asked: &Morphs) -> BakeError {
    if let Keep::Auto { .. } = asked.keep {
        // Vibration modes, which other meshes get, have no end and nothing to be compared with.
        let option = Part::Option("--max-error-rel", None);
        let message = "the mesh has no frames or morph targets, and a bake measures no error for vibration modes: give \
                       --modes K (0: rigid); --advise tells what fewer modes leave out";
        return BakeError::one("basis", option, message);
    }
    let place = Place::file(&mesh.name);
    BakeError::one("basis", place, "has no morph targets")
}
