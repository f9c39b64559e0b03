//! As few modes as an error allows.

use bdtree_format::MODE_COUNT_MAX;

use super::CurvePoint;
use super::reduction::Reduction;
use crate::basis::Basis;
use crate::error::{BakeError, Place};
use crate::figures::{counted, digits};
use crate::progress::Progress;

/// Modes that are tried at first; twice as many each time.
const FIRST_BATCH: usize = 16;

/// The basis of the fewest modes whose largest error as stored is at most `max_error_rel`, and the
/// errors that were measured on the way.
///
/// The largest error is at least the root mean square, so the search begins where that is small
/// enough. From there one reading of the frames measures many numbers of modes: the sum over
/// modes is formed in order, so that the first K modes of a basis are, but for rounding, the basis
/// of K modes.
pub(super) fn fewest(
    reduction: &Reduction<'_>,
    max_error_rel: f64,
    progress: &dyn Progress,
) -> Result<(Basis, Vec<CurvePoint>), BakeError> {
    /// Of the bound, for rounding of the singular values.
    const MARGIN: f64 = 1e-6;
    let cap = reduction.rank.modes.min(MODE_COUNT_MAX);
    let bound = max_error_rel * (1.0 + MARGIN);
    let mut from = (0..cap)
        .find(|&modes| reduction.rms_rel(modes) <= bound)
        .unwrap_or(cap);
    let mut batch = FIRST_BATCH;
    let mut curve: Vec<CurvePoint> = Vec::new();
    loop {
        let to = (from + batch).min(cap);
        let basis = reduction.basis(to, progress)?;
        let errors = reduction.errors(&basis, from, progress)?;
        for (modes, error) in (from..).zip(errors) {
            curve.push(CurvePoint { modes, error });
            if error.max_rel > max_error_rel {
                continue;
            }
            // Made anew, so that it is the same to the last bit as if this many had been asked
            // for; then what counts is measured on it.
            let basis = reduction.basis(modes, progress)?;
            let again = reduction.errors(&basis, modes, progress)?;
            if let (Some(point), Some(&error)) = (curve.last_mut(), again.first()) {
                point.error = error;
                if error.max_rel <= max_error_rel {
                    return Ok((basis, curve));
                }
            }
        }
        if to == cap {
            return Err(unreachable(reduction, max_error_rel, &curve));
        }
        (from, batch) = (to + 1, 2 * batch);
    }
}

fn unreachable(reduction: &Reduction<'_>, max_error_rel: f64, curve: &[CurvePoint]) -> BakeError {
    let sequence = reduction.sequence();
    let best = curve
        .iter()
        .min_by(|a, b| a.error.max_rel.total_cmp(&b.error.max_rel));
    let Some(CurvePoint { modes, error }) = best else {
        return BakeError::one(
            "basis",
            Place::file(&sequence.name),
            "no error was measured",
        );
    };
    let frame = match error.frame.map(|t| sequence.place(t)) {
        // A frame that is a file of its own.
        Some(place) if place.file.is_none() => format!(", frame {place}"),
        Some(place) => format!(", {place}"),
        None => String::new(),
    };
    let which = match reduction.rank.modes {
        all if *modes == all => format!("all {}", counted(all, "mode")),
        all => format!("{modes} of the {}", counted(all, "mode")),
    };
    let message = format!(
        "{} cannot be reached: with {which} the largest error is {} of the diagonal (vertex {}{frame})",
        digits(max_error_rel, 4),
        digits(error.max_rel, 4),
        error.vertex
    );
    // Without a colon, as a sentence.
    BakeError::one(
        "basis",
        Place::NOWHERE,
        format!("--max-error-rel {message}"),
    )
}
