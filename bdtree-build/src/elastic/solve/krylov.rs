//! The lowest modes of one component by a block Krylov iteration on the inverse.
//!
//! The operator is the exact pseudo-inverse: forces that balance are applied to the body held at
//! a statically determinate support, where the reactions vanish, and the rigid part is projected
//! out. So no shift has to be chosen, and slender bodies whose first frequency is tiny converge as
//! fast as stout ones. (faer's partial eigensolver hangs and loses modes of symmetric bodies.)

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};

use crate::elastic::assemble::system::System;
use crate::elastic::solve::factor::{Factor, FactorError};

/// Eigenpairs, ascending.
#[derive(Debug, Clone)]
pub(crate) struct Modes {
    /// Eigenvalues of K x = λ M x in cell units.
    pub values: Vec<f64>,
    /// `M`-orthonormal eigenvectors, one per column.
    pub vectors: Mat<f64>,
    /// Worst ‖Kx − λMx‖ / (λ‖Mx‖) among them; where that is above [`RESIDUAL_MAX`], worst
    /// ‖x − λ K⁻¹ M x‖ if it is less.
    pub residual: f64,
}

/// Right-hand sides per solve: a supernodal solve of eight costs about twice that of one.
const BLOCK: usize = 8;
/// Residual above which modes are not good enough.
pub(crate) const RESIDUAL_MAX: f64 = 1e-6;
/// Ritz residual, relative to the Ritz value, at which the iteration ends.
const RITZ_TOLERANCE: f64 = 1e-9;

/// The pieces of the pseudo-inverse.
pub(crate) struct Inverse<'a> {
    /// The component.
    pub system: &'a System,
    /// Factor of its stiffness, held at `pins`.
    pub factor: &'a Factor<'a>,
    /// The statically determinate support.
    pub pins: &'a [usize],
    /// `M`-orthonormal rigid motions.
    pub rigid: MatRef<'a, f64>,
    /// `M` times them.
    pub rigid_mass: MatRef<'a, f64>,
}

impl Inverse<'_> {
    /// Removes the rigid part, `M`-orthogonally.
    fn project(&self, x: &mut Mat<f64>) {
        let share = self.rigid_mass.transpose() * x.as_ref();
        matmul(
            x.as_mut(),
            Accum::Add,
            self.rigid,
            share.as_ref(),
            -1.0,
            Par::Seq,
        );
    }

    /// The pseudo-inverse applied to `M x`, given `m = M x`.
    fn apply(&self, mut m: Mat<f64>) -> Result<Mat<f64>, FactorError> {
        for &p in self.pins {
            for j in 0..m.ncols() {
                m[(p, j)] = 0.0;
            }
        }
        self.factor.solve(m.as_mut())?;
        self.project(&mut m);
        Ok(m)
    }
}

/// The lowest `wanted` modes (fewer if the body has fewer); `reach` is told what share of the iteration is over, by
/// guess.
pub(crate) fn lowest_modes(
    inverse: &Inverse<'_>,
    wanted: usize,
    reach: &mut dyn FnMut(f64),
) -> Result<Modes, FactorError> {
    let system = inverse.system;
    let free = system.free_count().saturating_sub(inverse.rigid.ncols());
    let wanted = wanted.min(free);
    // 14 modes were found in 88 to 104 dimensions, 34 in 136.
    let dimension_typical = (72 + 2 * wanted) as f64;
    let dimension_max = free.min(40 * BLOCK + 6 * wanted);
    let mut basis: Vec<Mat<f64>> = Vec::new();
    let mut size = 0;
    // Projection of the operator, column block by column block.
    let room = dimension_max + 2 * BLOCK;
    let mut projected = Mat::<f64>::zeros(room, room);
    let mut block = start_block(system, BLOCK.min(free), 0);
    inverse.project(&mut block);
    let mut fresh = true;
    let mut last = 0;
    for round in 1u64.. {
        let added = orthonormalise(inverse, &basis, size, block);
        let coefficients = &added.coefficients;
        if !fresh {
            // What Op V_last has along the basis so far and along the new block.
            for j in 0..coefficients.ncols() {
                for i in 0..coefficients.nrows() {
                    projected[(i, last + j)] = coefficients[(i, j)];
                }
            }
        }
        let exhausted = added.block.ncols() == 0;
        let enough = size >= dimension_max;
        if exhausted && size < wanted {
            if fresh {
                return Err(FactorError::Pivot); // random directions add nothing: no such modes
            }
            // An invariant space that is too small: start anew beside it.
            block = start_block(system, BLOCK, round);
            inverse.project(&mut block);
            fresh = true;
            continue;
        }
        let due = round % 2 == 0 && size >= wanted + BLOCK;
        if size >= wanted && (exhausted || enough || due) {
            let (theta, s) = ritz(projected.as_ref(), size)?;
            let converged = exhausted
                || (0..wanted).all(|k| {
                    // ‖Op x − θ x‖ = ‖R s_last‖: the part that leaves the basis.
                    let mut residual = 0.0f64;
                    for i in size..coefficients.nrows() {
                        let r: f64 = (0..coefficients.ncols())
                            .map(|j| coefficients[(i, j)] * s[(last + j, k)])
                            .sum();
                        residual += r * r;
                    }
                    residual.sqrt() <= RITZ_TOLERANCE * theta[k].abs()
                });
            if converged || enough {
                return refine(inverse, combine(&basis, s.as_ref().subcols(0, wanted)));
            }
        }
        last = size;
        size += added.block.ncols();
        block = inverse.apply(added.mass)?;
        basis.push(added.block);
        reach((size as f64 / dimension_typical).min(1.0));
        fresh = false;
    }
    Err(FactorError::Pivot)
}

/// Basis times coefficients.
fn combine(basis: &[Mat<f64>], coefficients: MatRef<'_, f64>) -> Mat<f64> {
    let rows = basis.first().map_or(0, Mat::nrows);
    let mut x = Mat::<f64>::zeros(rows, coefficients.ncols());
    let mut at = 0;
    for v in basis {
        let part = coefficients.subrows(at, v.ncols());
        matmul(x.as_mut(), Accum::Add, v.as_ref(), part, 1.0, Par::Seq);
        at += v.ncols();
    }
    x
}

/// Ritz values, largest first, with their vectors in the basis.
fn ritz(projected: MatRef<'_, f64>, size: usize) -> Result<(Vec<f64>, Mat<f64>), FactorError> {
    let t = Mat::from_fn(size, size, |i, j| {
        0.5 * (projected[(i, j)] + projected[(j, i)])
    });
    let eigen = t
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| FactorError::Pivot)?;
    let theta = (0..size).rev().map(|k| eigen.S()[k]).collect();
    let s = Mat::from_fn(size, size, |i, k| eigen.U()[(i, size - 1 - k)]);
    Ok((theta, s))
}

/// One more inverse iteration takes the rough part out of the Ritz vectors; then a last
/// Rayleigh-Ritz step in their span.
fn refine(inverse: &Inverse<'_>, x: Mat<f64>) -> Result<Modes, FactorError> {
    let system = inverse.system;
    let mut x = x;
    inverse.project(&mut x);
    let mut y = inverse.apply(system.apply_mass(x.as_ref()))?;
    // Columns come out scaled by 1/λ; bring them to a common length first.
    let m = system.apply_mass(y.as_ref());
    for j in 0..y.ncols() {
        let length: f64 = (0..y.nrows())
            .map(|i| y[(i, j)] * m[(i, j)])
            .sum::<f64>()
            .sqrt();
        for i in 0..y.nrows() {
            y[(i, j)] /= length;
        }
    }
    let (vectors, values) = rayleigh_ritz(system, y)?;
    let mut residual = worst_residual(system, &vectors, &values);
    if residual > RESIDUAL_MAX {
        residual = residual.min(worst_inverse_residual(inverse, &vectors, &values)?);
    }
    Ok(Modes {
        values,
        vectors,
        residual,
    })
}

fn rayleigh_ritz(system: &System, y: Mat<f64>) -> Result<(Mat<f64>, Vec<f64>), FactorError> {
    let m = y.transpose() * system.apply_mass(y.as_ref());
    let k = y.transpose() * system.apply_stiffness(y.as_ref());
    let size = y.ncols();
    let eigen = m
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| FactorError::Pivot)?;
    let whiten = Mat::from_fn(size, size, |i, j| {
        eigen.U()[(i, j)] / eigen.S()[j].max(f64::MIN_POSITIVE).sqrt()
    });
    let k = whiten.transpose() * k * &whiten;
    let k = Mat::from_fn(size, size, |i, j| 0.5 * (k[(i, j)] + k[(j, i)]));
    let eigen = k
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| FactorError::Pivot)?;
    let values = (0..size).map(|j| eigen.S()[j]).collect();
    Ok((y * whiten * eigen.U(), values))
}

/// Worst ‖Kx − λMx‖ / (λ‖Mx‖).
pub(crate) fn worst_residual(system: &System, vectors: &Mat<f64>, values: &[f64]) -> f64 {
    let k = system.apply_stiffness(vectors.as_ref());
    let m = system.apply_mass(vectors.as_ref());
    let mut worst = 0.0f64;
    for (j, &value) in values.iter().enumerate() {
        let (mut difference, mut size) = (0.0, 0.0);
        for i in 0..vectors.nrows() {
            difference += (k[(i, j)] - value * m[(i, j)]).powi(2);
            size += m[(i, j)].powi(2);
        }
        worst = worst.max(difference.sqrt() / (value.abs() * size.sqrt()));
    }
    worst
}

/// Worst ‖x − λ K⁻¹ M x‖ in the norm of `M`: it bounds the relative error of λ as the other one
/// does, without what rounding leaves of the stiffest motions.
fn worst_inverse_residual(
    inverse: &Inverse<'_>,
    vectors: &Mat<f64>,
    values: &[f64],
) -> Result<f64, FactorError> {
    let system = inverse.system;
    let mut difference = inverse.apply(system.apply_mass(vectors.as_ref()))?;
    for (j, &value) in values.iter().enumerate() {
        for i in 0..vectors.nrows() {
            difference[(i, j)] = vectors[(i, j)] - value * difference[(i, j)];
        }
    }
    let mass = system.apply_mass(difference.as_ref());
    let square = |j: usize| -> f64 {
        let column = (0..mass.nrows()).map(|i| difference[(i, j)] * mass[(i, j)]);
        column.sum()
    };
    let worst = (0..values.len()).map(|j| square(j).sqrt());
    Ok(worst.fold(0.0, |a, b| if b.is_nan() { b } else { a.max(b) }))
}

/// Random numbers from a fixed seed (SplitMix64, Steele et al. 2014), zero where held.
fn start_block(system: &System, columns: usize, seed: u64) -> Mat<f64> {
    let mut state = 0x5EED_u64 ^ (seed << 32);
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut block = Mat::from_fn(system.size(), columns, |_, _| next());
    system.clear_held(&mut block);
    block
}

/// Takes the basis (`size` columns in all) out of `block`, whose product with `M` is `mass`; returns the coefficients.
fn remove(
    inverse: &Inverse<'_>,
    basis: &[Mat<f64>],
    size: usize,
    block: &mut Mat<f64>,
    mass: &Mat<f64>,
) -> Mat<f64> {
    let mut all = Mat::zeros(size, block.ncols());
    let mut at = 0;
    for v in basis {
        let share = v.transpose() * mass.as_ref();
        matmul(
            block.as_mut(),
            Accum::Add,
            v.as_ref(),
            share.as_ref(),
            -1.0,
            Par::Seq,
        );
        all.as_mut().subrows_mut(at, v.ncols()).copy_from(&share);
        at += v.ncols();
    }
    inverse.project(block);
    all
}

/// New directions beside the basis.
struct Directions {
    /// `M`-orthonormal, against the basis too.
    block: Mat<f64>,
    /// `M` times them.
    mass: Mat<f64>,
    /// Coefficients of the block that they come from, in basis and new directions together.
    coefficients: Mat<f64>,
}

/// What `block` has beside the basis (`size` columns in all).
fn orthonormalise(
    inverse: &Inverse<'_>,
    basis: &[Mat<f64>],
    size: usize,
    mut block: Mat<f64>,
) -> Directions {
    let width = block.ncols();
    let system = inverse.system;
    let mut mass = system.apply_mass(block.as_ref());
    let square = |j: usize| -> f64 {
        (0..block.nrows())
            .map(|i| block[(i, j)] * mass[(i, j)])
            .sum()
    };
    let largest = (0..width).map(square).fold(0.0f64, f64::max);
    let mut along = remove(inverse, basis, size, &mut block, &mass);
    mass = system.apply_mass(block.as_ref());
    // By the eigenvectors of the small Gram matrix, which also shows lost directions.
    let mut upper = Mat::<f64>::identity(width, width);
    for pass in 0..3 {
        if block.ncols() == 0 {
            break;
        }
        let Ok(eigen) = (block.transpose() * &mass).self_adjoint_eigen(Side::Lower) else {
            break;
        };
        let floor = if pass == 0 { 1e-24 * largest } else { 1e-4 };
        let kept: Vec<usize> = (0..block.ncols())
            .filter(|&j| eigen.S()[j] > floor)
            .collect();
        let down = Mat::from_fn(block.ncols(), kept.len(), |i, j| {
            eigen.U()[(i, kept[j])] / eigen.S()[kept[j]].sqrt()
        });
        let up = Mat::from_fn(kept.len(), block.ncols(), |i, j| {
            eigen.U()[(j, kept[i])] * eigen.S()[kept[i]].sqrt()
        });
        block = block * &down;
        upper = up * upper;
        if pass == 0 {
            // A second time, as rounding left some of the basis, which is much of a nearly lost direction by now
            // ("twice is enough": Parlett, The Symmetric Eigenvalue Problem, 6.9).
            mass = system.apply_mass(block.as_ref());
            along += remove(inverse, basis, size, &mut block, &mass) * &upper;
            mass = system.apply_mass(block.as_ref());
        } else {
            // Nearly orthonormal by now, so that nothing cancels in the combination.
            mass = mass * &down;
        }
    }
    let coefficients = Mat::from_fn(size + upper.nrows(), width, |i, j| {
        if i < size {
            along[(i, j)]
        } else {
            upper[(i - size, j)]
        }
    });
    Directions {
        block,
        mass,
        coefficients,
    }
}
