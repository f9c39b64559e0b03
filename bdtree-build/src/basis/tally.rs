//! The largest and the mean of many distances.

use super::BasisError;

/// Squared distances so far.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Tally {
    largest: f64,
    frame: Option<usize>,
    vertex: usize,
    sum: f64,
}

impl Tally {
    /// Of distances in frames: that of the first, as long as all are 0.
    pub(crate) fn of_frames() -> Self {
        Self {
            frame: Some(0),
            ..Self::default()
        }
    }

    /// Of equal distances that of the first frame, then of the first vertex: the order of calls must not matter.
    pub(crate) fn add(&mut self, square: f64, frame: Option<usize>, vertex: usize) {
        self.sum += square;
        if square > self.largest
            || (square == self.largest && (frame, vertex) < (self.frame, self.vertex))
        {
            *self = Self {
                largest: square,
                frame,
                vertex,
                ..*self
            };
        }
    }

    /// The error over `count` distances, relative to `size`.
    pub(crate) fn error(&self, count: usize, size: f64) -> BasisError {
        BasisError {
            max_rel: self.largest.sqrt() / size,
            rms_rel: (self.sum / count as f64).sqrt() / size,
            frame: self.frame,
            vertex: self.vertex,
        }
    }
}
