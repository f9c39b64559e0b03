//! As few modes as an error allows.

use bdtree_format::MODE_COUNT_MAX;

use super::CurvePoint;
use super::reduction::Reduction;
use crate::basis::Basis;
use crate::error::BakeError;
use crate::progress::Progress;

/// Modes that are tried at first; twice as many each time.
const FIRST_BATCH: usize = 16;

/// The basis of the fewest modes whose largest error as stored is at most `max_error_rel`, and the
/// errors that were measured on the way.
///
/// The largest error is at least the root mean square, so the search begins where that is small
/// enough. From there one reading of the frames measures many numbers of modes: the sum over
/// modes is formed in order, so that the first K modes of a basis are the basis of K modes.
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
        let mut basis = reduction.basis(to, progress)?;
        let errors = reduction.errors(&basis, from, progress)?;
        for (modes, error) in (from..).zip(errors) {
            curve.push(CurvePoint { modes, error });
            if error.max_rel > max_error_rel {
                continue;
            }
            if modes < to {
                truncate(&mut basis, modes);
                // A smaller basis may be stored in another unit: what counts is measured on it.
                let again = reduction.errors(&basis, modes, progress)?;
                if let (Some(point), Some(&error)) = (curve.last_mut(), again.first()) {
                    point.error = error;
                    if error.max_rel > max_error_rel {
                        basis = reduction.basis(to, progress)?;
                        continue;
                    }
                }
            }
            return Ok((basis, curve));
        }
        if to == cap {
            return Err(unreachable(reduction, max_error_rel, &curve));
        }
        (from, batch) = (to + 1, 2 * batch);
    }
}

/// Keeps the first `count` modes.
fn truncate(basis: &mut Basis, count: usize) {
    let before = basis.mode_count().max(1);
    basis.modes.truncate(count);
    basis.fields.truncate(count * basis.vertex_count);
    if let Some(animation) = &mut basis.animation {
        let rows = animation.q.chunks_exact(before);
        animation.q = rows.flat_map(|q| &q[..count]).copied().collect();
    }
}

fn unreachable(reduction: &Reduction<'_>, max_error_rel: f64, curve: &[CurvePoint]) -> BakeError {
    let sequence = reduction.sequence();
    let best = curve
        .iter()
        .min_by(|a, b| a.error.max_rel.total_cmp(&b.error.max_rel));
    let Some(CurvePoint { modes, error }) = best else {
        return BakeError::one("basis", sequence.name(), "no error was measured");
    };
    let place = error.frame.map_or_else(String::new, |t| sequence.place(t));
    let message = format!(
        "a largest error of {max_error_rel:e} of the diagonal cannot be reached: {modes} of the {} \
         modes there are leave {:.3e} at vertex {}",
        reduction.rank.modes, error.max_rel, error.vertex
    );
    BakeError::one("basis", place, message)
}
