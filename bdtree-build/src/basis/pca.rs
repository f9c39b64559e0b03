//! Compressed animation: the principal components of a sequence of frames.
//!
//! `x_t ≈ p + U q_t` for every frame t, in the coordinates of the frame's rigid motion if those are
//! taken out (`--align`). With p the mean of the frames, U their M leading left singular vectors
//! and q_t = Uᵀ(x_t − p), no other M fields leave less squared error. The frames are read in
//! chunks of vertices, several times; memory follows the chunk, the square of the number of frames
//! and the modes that are kept. docs/reference/animation.md has accuracy, times and limits.

mod align;
mod choose;
mod fields;
mod measure;
mod motion;
mod rank;
mod reduction;
mod snapshots;
mod tsqr;

use bdtree_format::MODE_COUNT_MAX;

use super::{Basis, BasisError};
use crate::error::{BakeError, Place};
use crate::input::RawMesh;
use crate::input::sequence::FrameSequence;
use crate::progress::Progress;
use crate::words::words;
use reduction::Reduction;

/// How many modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Modes {
    /// This many, or as many as there are.
    Count(usize),
    /// The fewest whose largest vertex error, as stored, is at most this share of the diagonal of
    /// the box around the rest positions.
    Auto {
        /// The share, greater than 0.
        max_error_rel: f64,
    },
}

/// What the frames are differences to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// The mean of the frames.
    Mean,
    /// The positions of the mesh.
    Input,
}

words!(
    About,
    "is neither mean nor input",
    Mean = "mean",
    Input = "input"
);

/// How a sequence becomes a basis.
#[derive(Debug, Clone, PartialEq)]
pub struct PcaOptions {
    /// How many modes.
    pub modes: Modes,
    /// What the rest positions are.
    pub about: About,
    /// Takes the rigid motion out of each frame; playback puts it back.
    pub align: bool,
    /// Predicted memory beyond which the work is refused.
    pub memory_limit_bytes: u64,
    /// Measures with [`Modes::Count`] every smaller number of modes, too: the curve then begins with none.
    pub measures_all: bool,
    /// Vertices that are read at a time; `None`: as many as 32 MiB hold.
    pub chunk_vertices: Option<usize>,
}

impl Default for PcaOptions {
    fn default() -> Self {
        Self {
            modes: Modes::Count(10),
            about: About::Mean,
            align: false,
            memory_limit_bytes: 4 << 30,
            measures_all: false,
            chunk_vertices: None,
        }
    }
}

/// A sequence as a mesh and a basis.
#[derive(Debug, Clone, PartialEq)]
pub struct Pca {
    /// The mesh with the rest positions.
    pub mesh: RawMesh,
    /// Number of components that the frames have above rounding, and that a file holds.
    pub available: usize,
    /// Orthonormal fields, the strongest first; `q_range` is the largest |q_j| of all frames; q per
    /// frame and motions in `animation`.
    pub basis: Basis,
    /// What the file is off by.
    pub error: BasisError,
    /// Errors for the numbers of modes that were tried, ascending.
    pub curve: Vec<CurvePoint>,
    /// All singular values of the frames, descending (mesh units): M modes leave a root mean
    /// square of √(Σ_{j ≥ M} σ_j² / (N T)), and no M fields leave less about the same rest
    /// positions.
    pub singular_values: Vec<f64>,
}

/// The error of a number of modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Number of modes.
    pub modes: usize,
    /// The error with them, as stored.
    pub error: BasisError,
}

/// The sequence as modes of `mesh`, whose faces and groups stay.
///
/// Singular values at or below the rounding of the data make no mode: what float32 rounds off
/// ((√n + √T) × its root mean square, for n coordinates that move), what the factorisation cannot
/// tell, and what rounding of the stored positions hides (2⁻²⁵ of the diagonal). Fewer modes than
/// asked for, and frames that do not differ, are warnings.
///
/// The root mean square of the error falls with every mode; the largest error need not, so that
/// [`Modes::Auto`] takes the first number that is good enough.
///
/// # Errors
/// Another number of vertices than `mesh`, more than 512 modes, an error bound that is not
/// positive or that no number of modes reaches, frames so far away that no limit of q holds them,
/// a mesh that cannot be stored, more memory than the limit, files that cannot be read
/// any more.
pub fn pca_basis(
    mesh: &RawMesh,
    sequence: &FrameSequence,
    options: &PcaOptions,
    progress: &dyn Progress,
    warnings: &mut Vec<String>,
) -> Result<Pca, BakeError> {
    check(mesh, sequence, options)?;
    let reduction = Reduction::new(mesh, sequence, options, progress)?;
    let (basis, curve) = match options.modes {
        Modes::Count(count) => {
            reduction.warn(count, warnings);
            let basis = reduction.basis(count.min(reduction.rank.modes), progress)?;
            let modes = basis.mode_count();
            let from = if options.measures_all { 0 } else { modes };
            let errors = reduction.errors(&basis, from, progress)?;
            let point = |(modes, error)| CurvePoint { modes, error };
            (basis, (from..).zip(errors).map(point).collect())
        }
        Modes::Auto { max_error_rel } => {
            reduction.warn(0, warnings);
            choose::fewest(&reduction, max_error_rel, progress)?
        }
    };
    let modes = basis.mode_count();
    let Some(point) = curve.iter().find(|point| point.modes == modes) else {
        return Err(BakeError::one(
            "basis",
            Place::file(&sequence.name),
            "no error was measured",
        ));
    };
    Ok(Pca {
        error: point.error,
        available: reduction.rank.modes.min(MODE_COUNT_MAX),
        mesh: reduction.mesh,
        basis,
        curve,
        singular_values: reduction.spectrum.values,
    })
}

fn check(mesh: &RawMesh, sequence: &FrameSequence, options: &PcaOptions) -> Result<(), BakeError> {
    let fail = |place: Place, message| Err(BakeError::one("basis", place, message));
    match options.modes {
        Modes::Count(count) if count > MODE_COUNT_MAX => {
            let message = format!("{count} modes: a file holds at most {MODE_COUNT_MAX}");
            return fail(Place::option("--modes"), message);
        }
        Modes::Auto { max_error_rel: e } if !(e > 0.0 && e.is_finite()) => {
            let message = format!("{e} is not a share of the diagonal (greater than 0)");
            return fail(Place::option("--max-error-rel"), message);
        }
        _ => {}
    }
    let (vertices, found) = (mesh.positions.len(), sequence.vertex_count());
    if vertices != found {
        let message = format!("{found} vertices per frame, the mesh has {vertices}");
        return fail(Place::file(&sequence.name), message);
    }
    Ok(())
}
