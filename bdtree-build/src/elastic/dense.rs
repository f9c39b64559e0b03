//! All modes of a small component at once.

use faer::{Mat, Side};

use super::factor::FactorError;
use super::krylov::{Modes, worst_residual};
use super::system::System;

/// Components of at most this many unknowns are solved densely.
pub(crate) const DENSE_MAX: usize = 240;

/// Every elastic mode, ascending; `rigid_count` zero modes come before them and are left out.
pub(crate) fn all_modes(system: &System, rigid_count: usize) -> Result<Modes, FactorError> {
    let free: Vec<usize> = (0..system.size()).filter(|&i| !system.held[i]).collect();
    let n = free.len();
    let unit = Mat::from_fn(system.size(), n, |i, j| f64::from(free[j] == i));
    let pick = |full: Mat<f64>| Mat::from_fn(n, n, |i, j| full[(free[i], j)]);
    let k = pick(system.apply_stiffness(unit.as_ref()));
    let m = pick(system.apply_mass(unit.as_ref()));
    let eigen = m
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| FactorError::Pivot)?;
    let whiten = Mat::from_fn(n, n, |i, j| {
        eigen.U()[(i, j)] / eigen.S()[j].max(f64::MIN_POSITIVE).sqrt()
    });
    let a = whiten.transpose() * k * &whiten;
    let a = Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)]));
    let eigen = a
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| FactorError::Pivot)?;
    let first = rigid_count.min(n);
    let x = whiten * eigen.U().subcols(first, n - first);
    let mut vectors = Mat::zeros(system.size(), n - first);
    for j in 0..n - first {
        for (i, &at) in free.iter().enumerate() {
            vectors[(at, j)] = x[(i, j)];
        }
    }
    let values: Vec<f64> = (first..n).map(|j| eigen.S()[j]).collect();
    let residual = worst_residual(system, &vectors, &values);
    Ok(Modes {
        values,
        vectors,
        residual,
    })
}
