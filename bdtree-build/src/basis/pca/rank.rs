//! How many modes the data has: what lies below its rounding is no motion.

use super::tsqr::Spectrum;

/// Rounding error of one number in units of its size.
const SINGLE: f64 = f32::EPSILON as f64 / 2.0;
const DOUBLE: f64 = f64::EPSILON / 2.0;
/// Of double precision, the mean and the differences to it are rounded as well.
const DOUBLE_STEPS: f64 = 4.0;

/// The size of the numbers that move, row by row.
#[derive(Debug, Default)]
pub(super) struct Rounding {
    /// Rows in which two frames differ.
    rows: usize,
    /// Sum of the squares of their numbers.
    squares: f64,
}

impl Rounding {
    /// Adds rows as the source has them, column after column.
    pub(super) fn add(&mut self, values: &[f64], rows: usize) {
        let Some(first) = values.get(..rows) else {
            return;
        };
        let mut moves = vec![false; rows];
        let mut squares = vec![0.0; rows];
        for column in values.chunks_exact(rows.max(1)) {
            for (i, value) in column.iter().enumerate() {
                moves[i] |= *value != first[i];
                squares[i] += value * value;
            }
        }
        for (moves, squares) in moves.iter().zip(&squares) {
            if *moves {
                self.rows += 1;
                self.squares += squares;
            }
        }
    }

    /// The singular value that rounding of the source makes by itself, over `frame_count` frames.
    ///
    /// float32: n × T independent errors of up to ½ ulp have a largest singular value of about
    /// (√n + √T) times their root mean square. float64: the Frobenius norm of all errors, which
    /// also bounds those that frames share through the mean.
    pub(super) fn singular_value(&self, is_single: bool, frame_count: usize) -> f64 {
        let (rows, frames) = (self.rows as f64, frame_count as f64);
        if self.rows == 0 {
            0.0
        } else if is_single {
            SINGLE * (self.squares / rows / frames).sqrt() * (rows.sqrt() + frames.sqrt())
        } else {
            DOUBLE_STEPS * DOUBLE * self.squares.sqrt()
        }
    }
}

/// Number of modes, and the value that the others do not exceed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rank {
    pub(super) modes: usize,
    pub(super) floor: f64,
}

/// The number of singular values above the largest of: what the source's rounding makes
/// (`rounding`), what the factorisation can tell (`resolution`, relative to the largest), and the
/// rounding of stored positions (2⁻²⁵ of `diagonal`): a mode with a smaller singular value moves no
/// vertex of any frame by more than that.
pub(super) fn rank(spectrum: &Spectrum, rounding: f64, resolution: f64, diagonal: f64) -> Rank {
    let largest = spectrum.values.first().copied().unwrap_or(0.0);
    let floor = rounding
        .max(resolution * largest)
        .max(0.5 * SINGLE * diagonal);
    Rank {
        modes: spectrum.values.iter().filter(|&&s| s > floor).count(),
        floor,
    }
}
