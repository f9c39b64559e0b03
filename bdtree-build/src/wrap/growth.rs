//! How far one unit of a step δq can move a vertex: the paper's δR (eq. 11).

use nalgebra::{Matrix3, Vector3};

use super::round::round_up;
use super::stored::StoredShape;
use crate::parallel;

/// Vertices that a thread takes at a time.
const VERTICES: usize = 1024;

/// Two bounds per vertex, N: ‖U_i:‖₂ and ‖U_i: S‖₂ (spectral norms of 3×M blocks), rounded up.
///
/// The largest eigenvalue of the 3×3 Gram matrix is the square of the norm.
pub(super) fn step_bounds(shape: &StoredShape, threads: usize) -> Vec<[f32; 2]> {
    let mode_count = shape.mode_count();
    let mut bounds = vec![[0.0; 2]; shape.positions.len()];
    if mode_count == 0 {
        return bounds;
    }
    let scales: Vec<f64> = shape
        .limits
        .iter()
        .map(|l| f64::from(l.step_scale))
        .collect();
    let runs = shape.displacements.chunks(VERTICES * mode_count);
    let jobs = bounds.chunks_mut(VERTICES).zip(runs);
    let mut nothing = parallel::states(threads, || ());
    parallel::for_each(jobs, &mut nothing, |(), (bounds, rows)| {
        for (bound, row) in bounds.iter_mut().zip(rows.chunks_exact(mode_count)) {
            let mut plain = Matrix3::zeros();
            let mut scaled = Matrix3::zeros();
            for (u, s) in row.iter().zip(&scales) {
                let u = Vector3::from(u.map(f64::from));
                plain += u * u.transpose();
                let u = u * *s;
                scaled += u * u.transpose();
            }
            *bound = [plain, scaled].map(norm_from_gram);
        }
    });
    bounds
}

/// √λ_max, rounded up. Forming the matrix loses at most 512 · 3 · 2⁻⁵³ of λ_max, the eigenvalue
/// iteration a few times 2⁻⁵²: together far below 2⁻³⁸.
fn norm_from_gram(gram: Matrix3<f64>) -> f32 {
    if gram.trace() == 0.0 {
        return 0.0;
    }
    let largest = gram.symmetric_eigenvalues().max().max(0.0);
    round_up(largest.sqrt() * (1.0 + 1.0 / (1u64 << 38) as f64))
}
