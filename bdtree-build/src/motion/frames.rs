//! The principal components of a sequence of frames.

use bdtree_format::MODE_COUNT_MAX;

use super::{Moving, Read, hexadecimal};
use crate::basis::pca::{Modes, PcaOptions, pca_basis};
use crate::error::BakeError;
use crate::input::sequence::FrameSequence;
use crate::input::{BadFaces, RawMesh, RawModel, read_model};
use crate::progress::Progress;
use crate::recipe::Frames;

/// The frames, and the mesh that they move.
pub(super) fn read<'r>(
    frames: &'r Frames,
    bad_faces: BadFaces,
    progress: &dyn Progress,
) -> Result<Read<'r>, BakeError> {
    let path = frames.path.as_path();
    let read = |path| read_model(path, None, bad_faces).map(RawModel::into_mesh);
    let surface = frames.surface.as_deref().map(read).transpose()?;
    let sequence = FrameSequence::open(path, surface.as_ref(), frames.fps, progress)?;
    let Some(mesh) = surface.or_else(|| sequence.first_mesh.clone()) else {
        let message = "has no faces: name the mesh whose vertices it moves (INPUT)";
        return Err(BakeError::one("input", path, message));
    };
    Ok(Read::Frames(Box::new(sequence), mesh, frames))
}

/// The mesh at the rest positions of the frames, with their components: `modes`, whatever the options say.
pub(super) fn moving(
    sequence: &FrameSequence,
    mesh: &RawMesh,
    frames: &Frames,
    modes: Modes,
    progress: &dyn Progress,
) -> Result<Moving, BakeError> {
    let options = PcaOptions {
        modes,
        ..frames.options.clone()
    };
    let mut warnings = sequence.warnings.to_vec();
    let pca = pca_basis(mesh, sequence, &options, progress, &mut warnings)?;
    let mut moving = Moving::new(pca.mesh, pca.basis, "pca");
    moving.modes_available = Some(pca.available);
    moving.provenance.error = Some(pca.error);
    moving.provenance.warnings = warnings;
    if options.measures_all {
        let errors = pca.curve.iter().map(|point| point.error);
        moving.errors_of_first = Some(errors.collect());
    }
    moving.set("animation", &sequence.name);
    moving.set("animation-sha256", hexadecimal(sequence.hash));
    moving.set("about", options.about);
    moving.set("align", options.align);
    match frames.options.modes {
        Modes::Count(count) => moving.set("modes", count),
        Modes::Auto { max_error_rel } => {
            moving.set("modes", "auto");
            moving.set("max-error-rel", max_error_rel);
        }
    }
    moving.set_some("fps", frames.fps);
    Ok(moving)
}

/// The same with as many components as keep the error, where the number in the options does not; where even all there
/// are do not, with all that are worth having.
pub(super) fn within(
    sequence: &FrameSequence,
    mesh: &RawMesh,
    frames: &Frames,
    max_error_rel: f64,
    progress: &dyn Progress,
) -> Result<Moving, BakeError> {
    let first = moving(sequence, mesh, frames, frames.options.modes, progress)?;
    let mut errors = first.errors_of_first.iter().flatten();
    if errors.any(|error| error.max_rel <= max_error_rel) {
        return Ok(first);
    }
    let auto = Modes::Auto { max_error_rel };
    let count = match moving(sequence, mesh, frames, auto, progress) {
        Ok(enough) => enough.basis.mode_count(),
        Err(_) => MODE_COUNT_MAX,
    };
    moving(sequence, mesh, frames, Modes::Count(count), progress)
}
