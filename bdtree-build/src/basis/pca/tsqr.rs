//! The singular values and right singular vectors of a tall matrix that comes in pieces.
//!
//! QR of the triangle so far on top of the next rows (Demmel, Grigori, Hoemmen, Langou,
//! "Communication-optimal parallel and sequential QR and LU factorizations", 2012), then the SVD of
//! the last triangle. Unlike a Gram matrix it does not square the condition number, and it is fast
//! enough for all sizes (docs/reference/animation.md).

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::qr::no_pivoting::factor::{
    qr_in_place, qr_in_place_scratch, recommended_block_size,
};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::{Mat, Par, Spec};

/// New rows per factorisation, as a multiple of the columns. Few: that keeps the rows in cache.
const ROWS_PER_COLUMN: usize = 4;
/// The least number of new rows.
const ROWS_MIN: usize = 256;
/// Entries beyond which new rows are only as many as columns.
const ENTRIES_MAX: usize = 1 << 23;

/// A matrix that is being factorised.
pub(super) struct Tsqr {
    /// The triangle so far, then rows that wait.
    work: Mat<f64>,
    triangle_rows: usize,
    waiting: usize,
}

/// What remains of the matrix.
pub(super) struct Spectrum {
    /// Singular values, descending.
    pub(super) values: Vec<f64>,
    /// Right singular vectors, one per column.
    pub(super) vectors: Mat<f64>,
}

impl Tsqr {
    /// Rows and columns that are held at a time for a matrix of this shape.
    pub(super) fn held(rows: usize, columns: usize) -> (usize, usize) {
        let wanted = ROWS_PER_COLUMN.saturating_mul(columns).max(ROWS_MIN);
        let fitting = ENTRIES_MAX / columns.max(1);
        let new = wanted.min(fitting.max(columns)).min(rows);
        (columns.min(rows) + new, columns)
    }

    /// For a matrix of `rows` × `columns`.
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let (rows, columns) = Self::held(rows, columns);
        Self {
            work: Mat::zeros(rows, columns),
            triangle_rows: 0,
            waiting: 0,
        }
    }

    /// What singular values may be off by, relative to the largest: faer drops the rest of a column
    /// below 16 ε × rows of its norm.
    pub(super) fn resolution(&self) -> f64 {
        16.0 * f64::EPSILON * self.work.nrows() as f64
    }

    /// Adds rows, given column after column.
    pub(super) fn add(&mut self, values: &[f64]) {
        let rows = values.len() / self.work.ncols().max(1);
        let mut done = 0;
        while done < rows {
            let first = self.triangle_rows + self.waiting;
            let count = (rows - done).min(self.work.nrows() - first);
            for (j, column) in values.chunks_exact(rows).enumerate() {
                let target = self.work.col_as_slice_mut(j);
                target[first..first + count].copy_from_slice(&column[done..done + count]);
            }
            self.waiting += count;
            done += count;
            if self.triangle_rows + self.waiting == self.work.nrows() {
                self.factorise();
            }
        }
    }

    fn factorise(&mut self) {
        let (rows, columns) = (self.triangle_rows + self.waiting, self.work.ncols());
        let block = recommended_block_size::<f64>(rows, columns);
        let mut householder = Mat::<f64>::zeros(block, rows.min(columns));
        let scratch = qr_in_place_scratch::<f64>(rows, columns, block, Par::Seq, Spec::default());
        qr_in_place(
            self.work.as_mut().subrows_mut(0, rows),
            householder.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Spec::default(),
        );
        self.triangle_rows = rows.min(columns);
        self.waiting = 0;
        for j in 0..columns {
            let column = &mut self.work.col_as_slice_mut(j)[..rows];
            column[(j + 1).min(rows)..].fill(0.0);
        }
    }

    /// The spectrum of all rows; `None` if the iteration does not converge.
    pub(super) fn finish(mut self) -> Option<Spectrum> {
        if self.waiting > 0 {
            self.factorise();
        }
        let triangle = self.work.as_ref().subrows(0, self.triangle_rows);
        let (rows, columns) = triangle.shape();
        let mut values = Diag::<f64>::zeros(rows.min(columns));
        let mut vectors = Mat::<f64>::zeros(columns, values.dim());
        // The left vectors are not needed, which saves time and memory.
        let (left, right) = (ComputeSvdVectors::No, ComputeSvdVectors::Thin);
        let scratch = svd_scratch::<f64>(rows, columns, left, right, Par::Seq, Spec::default());
        svd(
            triangle,
            values.as_mut(),
            None,
            Some(vectors.as_mut()),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Spec::default(),
        )
        .ok()?;
        Some(Spectrum {
            values: values.column_vector().iter().copied().collect(),
            vectors,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// `rank` random directions with singular values from 1 down by `ratio` each.
    fn graded(rows: usize, columns: usize, rank: usize, ratio: f64) -> Mat<f64> {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        let mut random = |n, m| {
            let a = Mat::from_fn(n, m, |_, _| rng.random_range(-1.0..1.0));
            a.qr().compute_thin_Q()
        };
        let (u, v) = (random(rows, rank), random(columns, rank));
        let s = Mat::from_fn(
            rank,
            rank,
            |i, j| {
                if i == j { ratio.powi(i as i32) } else { 0.0 }
            },
        );
        u * s * v.transpose()
    }

    fn in_pieces(a: &Mat<f64>, piece: usize) -> Spectrum {
        let mut tsqr = Tsqr::new(a.nrows(), a.ncols());
        for first in (0..a.nrows()).step_by(piece) {
            let rows = piece.min(a.nrows() - first);
            let part = a.as_ref().subrows(first, rows);
            let values: Vec<f64> = (0..a.ncols())
                .flat_map(|j| (0..rows).map(move |i| part[(i, j)]))
                .collect();
            tsqr.add(&values);
        }
        tsqr.finish().expect("converges")
    }

    #[test]
    fn pieces_have_the_singular_values_of_the_whole() {
        for (rows, columns) in [(3000, 20), (700, 100), (30, 50), (6, 40), (5, 1), (1, 1)] {
            let rank = rows.min(columns);
            let a = graded(rows, columns, rank, 0.5);
            let whole = a.thin_svd().expect("converges");
            let tolerance = Tsqr::new(rows, columns).resolution();
            assert!(tolerance < 1e-11);
            for piece in [1, 7, 300, 5000] {
                let found = in_pieces(&a, piece);
                assert_eq!(found.values.len(), rank);
                for j in 0..rank {
                    let off = (found.values[j] - whole.S()[j]).abs();
                    assert!(off < tolerance, "{rows} x {columns}, {piece}: {off}");
                }
                // Right singular vectors: A v_j has the length σ_j.
                let moved = &a * &found.vectors;
                for j in 0..rank.min(20) {
                    let off = (moved.col(j).norm_l2() - found.values[j]).abs();
                    assert!(off < tolerance, "{rows} x {columns}, {piece}: {off}");
                }
            }
        }
    }

    #[test]
    fn a_low_rank_leaves_rounding_only() {
        for rank in [0, 1, 3, 12] {
            let a = match rank {
                0 => Mat::zeros(4000, 60),
                _ => graded(4000, 60, rank, 0.1),
            };
            let found = in_pieces(&a, 100);
            for (j, value) in found.values.iter().enumerate() {
                let expected = if j < rank { 0.1f64.powi(j as i32) } else { 0.0 };
                assert!((value - expected).abs() < 1e-14, "{rank}: {j} {value}");
            }
        }
    }
}
