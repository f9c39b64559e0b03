//! The snapshot matrix: three rows per vertex, one column per frame, read in chunks of rows.

use std::ops::Range;

use super::motion::Motion;
use crate::error::BakeError;
use crate::input::sequence::FrameSequence;

/// Numbers that a chunk holds unless told otherwise (32 MiB).
const CHUNK_NUMBERS: usize = 1 << 22;

/// Frames without their rigid motions.
pub(super) struct Snapshots<'a> {
    pub(super) sequence: &'a FrameSequence,
    /// What is taken out of each frame; empty: nothing.
    pub(super) motions: Vec<Motion>,
    chunk_vertices: usize,
}

impl<'a> Snapshots<'a> {
    /// All frames as they are; `chunk_vertices` per chunk, or as many as 32 MiB hold.
    pub(super) fn new(sequence: &'a FrameSequence, chunk_vertices: Option<usize>) -> Self {
        let fitting = CHUNK_NUMBERS / 3 / sequence.frame_count().max(1);
        Self {
            sequence,
            motions: Vec::new(),
            chunk_vertices: chunk_vertices.unwrap_or(fitting).max(1),
        }
    }

    /// Ranges of vertices, in order, that cover all of them.
    pub(super) fn chunks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let (count, step) = (self.sequence.vertex_count(), self.chunk_vertices);
        (0..count)
            .step_by(step)
            .map(move |first| first..count.min(first.saturating_add(step)))
    }

    /// The rows of `vertices` as the source has them, column after column.
    pub(super) fn read(
        &self,
        vertices: &Range<usize>,
        values: &mut Vec<f64>,
    ) -> Result<(), BakeError> {
        values.resize(3 * vertices.len() * self.sequence.frame_count(), 0.0);
        self.sequence.read(vertices.clone(), values)
    }

    /// Takes the motions out of rows that were read.
    pub(super) fn align(&self, values: &mut [f64]) {
        if self.motions.is_empty() {
            return;
        }
        let rows = values.len() / self.motions.len();
        for (column, motion) in values.chunks_exact_mut(rows.max(1)).zip(&self.motions) {
            for point in column.as_chunks_mut().0 {
                *point = motion.undo(*point);
            }
        }
    }

    /// The rows of `vertices`, aligned, minus their rest positions.
    pub(super) fn read_centered(
        &self,
        vertices: &Range<usize>,
        rest: &[[f64; 3]],
        values: &mut Vec<f64>,
    ) -> Result<(), BakeError> {
        self.read(vertices, values)?;
        self.align(values);
        center(values, &rest[vertices.clone()]);
        Ok(())
    }
}

/// Subtracts `rest` from every column.
pub(super) fn center(values: &mut [f64], rest: &[[f64; 3]]) {
    let rest = rest.as_flattened();
    for column in values.chunks_exact_mut(rest.len().max(1)) {
        for (value, rest) in column.iter_mut().zip(rest) {
            *value -= rest;
        }
    }
}

/// The mean column: exactly the column that all are equal to, if they are.
pub(super) fn mean(values: &[f64], rows: usize, out: &mut [[f64; 3]]) {
    let Some(first) = values.get(..rows) else {
        return;
    };
    let mut sums = vec![0.0; rows];
    let mut columns = 0.0;
    for column in values.chunks_exact(rows.max(1)) {
        columns += 1.0;
        for ((sum, value), first) in sums.iter_mut().zip(column).zip(first) {
            *sum += value - first;
        }
    }
    for ((mean, first), sum) in out.as_flattened_mut().iter_mut().zip(first).zip(sums) {
        *mean = first + sum / columns;
    }
}
