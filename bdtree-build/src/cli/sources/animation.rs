//! `--animation`: the principal components of a sequence of frames.

use std::path::Path;

use bdtree_build::basis::pca::{self, Pca, PcaOptions, pca_basis};
use bdtree_build::error::BakeError;
use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Progress;
use bdtree_format::MODE_COUNT_MAX;

use super::{MODES_DEFAULT, Source, hexadecimal, name};
use crate::cli::Arguments;
use crate::cli::arguments::{About, Modes};

/// The frames at `path`, and the mesh that they move: INPUT, or the first frame of a folder.
pub(super) fn read(
    arguments: &Arguments,
    path: &Path,
    progress: &dyn Progress,
) -> Result<(FrameSequence, Source), BakeError> {
    let input = arguments.input.as_deref().map(read_mesh).transpose()?;
    let sequence = FrameSequence::open(path, input.as_ref(), arguments.fps, progress)?;
    let Some(mesh) = input.or_else(|| sequence.first_mesh().cloned()) else {
        let message = "has no faces: name the mesh whose vertices it moves (INPUT)";
        return Err(BakeError::one("input", path.display().to_string(), message));
    };
    let mut source = Source::rigid(mesh);
    source.warnings.extend_from_slice(sequence.warnings());
    source.set("animation", name(path));
    source.set("animation-sha256", hexadecimal(sequence.hash()));
    Ok((sequence, source))
}

/// Replaces the mesh by the rest positions and adds the components.
pub(super) fn add(
    arguments: &Arguments,
    sequence: &FrameSequence,
    source: &mut Source,
    progress: &dyn Progress,
) -> Result<(), BakeError> {
    let about = arguments.about.unwrap_or(About::Mean);
    let options = PcaOptions {
        modes: match arguments.modes() {
            Modes::Unsaid => pca::Modes::Count(MODES_DEFAULT),
            Modes::Count(count) => pca::Modes::Count(count),
            Modes::Auto(max_error_rel) => pca::Modes::Auto { max_error_rel },
        },
        about: match about {
            About::Mean => pca::About::Mean,
            About::Input => pca::About::Input,
        },
        align: arguments.align,
        measures_all: arguments.advise,
        memory_limit_bytes: arguments.memory_limit.saturating_mul(1 << 20),
        ..PcaOptions::default()
    };
    let reduce = |modes, warnings: &mut Vec<String>| {
        let options = PcaOptions {
            modes,
            ..options.clone()
        };
        pca_basis(&source.mesh, sequence, &options, progress, warnings)
    };
    let mut warnings = Vec::new();
    let mut pca = reduce(options.modes, &mut warnings)?;
    let goal = arguments.goal();
    let is_short = |pca: &Pca| pca.curve.iter().all(|point| point.error.max_rel > goal);
    if arguments.advise && arguments.modes() == Modes::Unsaid && is_short(&pca) {
        // As many as it takes; where even all there are do not do, all that are worth having.
        let auto = pca::Modes::Auto {
            max_error_rel: goal,
        };
        let count = match reduce(auto, &mut Vec::new()) {
            Ok(enough) => enough.basis.mode_count(),
            Err(_) => MODE_COUNT_MAX,
        };
        warnings.clear();
        pca = reduce(pca::Modes::Count(count), &mut warnings)?;
    }
    source.warnings.extend(warnings);
    if arguments.advise {
        let errors = pca.curve.iter().map(|point| point.error);
        source.errors_of_first = Some(errors.collect());
    }
    source.mesh = pca.mesh;
    source.basis = pca.basis;
    source.error = Some(pca.error);
    source.kind = "pca";
    source.set("about", about);
    source.set("align", arguments.align);
    if let Modes::Auto(max_error_rel) = arguments.modes() {
        source.set("max-error-rel", max_error_rel);
    }
    if let Some(fps) = arguments.fps {
        source.set("fps", fps);
    }
    Ok(())
}
