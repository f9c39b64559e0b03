//! All modes of a small component at once: the oracle of tests. (Whitening by the mass loses the
//! low modes of cut cells, whose mass matrix is nearly singular; the iteration does not.)

use faer::{Mat, Side};

use crate::elastic::assemble::system::System;
use crate::elastic::solve::factor::FactorError;
use crate::elastic::solve::krylov::{Modes, worst_residual};

/// Every elastic mode, ascending; `rigid_count` zero modes come before them and are left out.
pub(crate) fn all_modes(system: &System, rigid_count: usize) -> Result<Modes, FactorError> {
    let free: Vec<usize> = (0..system.size())
        .filter(|i| system.held.binary_search(i).is_err())
        .collect();
    let n = free.len();
    let unit = Mat::from_fn(system.size(), n, |i, j| f64::from(i == free[j]));
    let k = unit.transpose() * system.apply_stiffness(unit.as_ref());
    let m = unit.transpose() * system.apply_mass(unit.as_ref());
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
    let vectors = unit * whiten * eigen.U().subcols(first, n - first);
    let values: Vec<f64> = (first..n).map(|j| eigen.S()[j]).collect();
    let residual = worst_residual(system, &vectors, &values);
    Ok(Modes {
        values,
        vectors,
        residual,
    })
}
