//! The motions that cost no energy, known exactly: what remains of the six rigid ones.

use faer::{Mat, MatRef};

use super::system::System;

/// `M`-orthonormal rigid motions (size × count) that the held points allow. (Functions follow lines,
/// so their coefficients move as points at their centres do.)
pub(crate) fn rigid_motions(system: &System) -> Mat<f64> {
    let n = system.nodes.len();
    let mut centre = [0.0; 3];
    for node in &system.nodes {
        for a in 0..3 {
            centre[a] += f64::from(node[a]) / n as f64;
        }
    }
    let reach = system
        .nodes
        .iter()
        .flat_map(|node| (0..3).map(|a| (f64::from(node[a]) - centre[a]).abs()))
        .fold(1.0, f64::max);
    // Rotations are scaled to the size of translations.
    let all = Mat::from_fn(3 * n, 6, |i, j| {
        let p: [f64; 3] =
            std::array::from_fn(|a| (f64::from(system.nodes[i / 3][a]) - centre[a]) / reach);
        let axis = i % 3;
        if j < 3 {
            return f64::from(axis == j);
        }
        let j = j - 3;
        if axis == (j + 1) % 3 {
            -p[(j + 2) % 3]
        } else if axis == (j + 2) % 3 {
            p[(j + 1) % 3]
        } else {
            0.0
        }
    });
    let mut free = all.as_ref() * null_space(system, all.as_ref());
    if free.ncols() == 0 {
        return free;
    }
    // Twice is enough for M-orthonormality to rounding.
    for _ in 0..2 {
        let product = free.transpose() * system.apply_mass(free.as_ref());
        let Ok(eigen) = product.self_adjoint_eigen(faer::Side::Lower) else {
            break;
        };
        let scale = Mat::from_fn(free.ncols(), free.ncols(), |i, j| {
            eigen.U()[(i, j)] / eigen.S()[j].max(f64::MIN_POSITIVE).sqrt()
        });
        free = free.as_ref() * scale;
    }
    free
}

/// Combinations (6 × count) of the rigid motions that leave all held points where they are.
fn null_space(system: &System, all: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::<f64>::zeros(6, 6);
    if system.grips.is_empty() {
        return Mat::identity(6, 6);
    }
    for grip in &system.grips {
        for axis in (0..3).filter(|&a| grip.axes[a]) {
            let nodes = grip.anchor.nodes.iter().zip(grip.anchor.weights);
            let mut motion = [0.0; 6];
            for (&n, w) in nodes {
                for (j, m) in motion.iter_mut().enumerate() {
                    *m += w * all[(3 * n as usize + axis, j)];
                }
            }
            for a in 0..6 {
                for b in 0..6 {
                    product[(a, b)] += motion[a] * motion[b];
                }
            }
        }
    }
    let Ok(eigen) = product.self_adjoint_eigen(faer::Side::Lower) else {
        return Mat::zeros(6, 0);
    };
    // Motions are of size 1 at the body's end: what moves all held points by less than 3e-5 of that in
    // all is free, for a hold of one point or of points on a line.
    let free: Vec<usize> = (0..6).filter(|&j| eigen.S()[j] < 1e-9).collect();
    Mat::from_fn(6, free.len(), |i, j| eigen.U()[(i, free[j])])
}

/// As many unknowns as there are rigid motions, such that holding them holds the body: chosen
/// greedily for the best-conditioned support (heavy nodes far apart).
pub(crate) fn support(system: &System, rigid: MatRef<'_, f64>) -> Vec<usize> {
    let mut rows = Mat::from_fn(rigid.nrows(), rigid.ncols(), |i, j| {
        rigid[(i, j)] * system.mass_diagonal(i / 3).sqrt()
    });
    let mut pins = Vec::new();
    for _ in 0..rigid.ncols() {
        let length = |i: usize| (0..rows.ncols()).map(|j| rows[(i, j)] * rows[(i, j)]).sum();
        let mut best = (0, 0.0f64);
        for i in 0..rows.nrows() {
            let l: f64 = length(i);
            if l > best.1 * (1.0 + 1e-9) {
                best = (i, l);
            }
        }
        if best.1 <= 0.0 {
            break;
        }
        pins.push(best.0);
        let pivot: Vec<f64> = (0..rows.ncols()).map(|j| rows[(best.0, j)]).collect();
        for i in 0..rows.nrows() {
            let along: f64 = (0..rows.ncols())
                .map(|j| rows[(i, j)] * pivot[j])
                .sum::<f64>()
                / best.1;
            for (j, p) in pivot.iter().enumerate() {
                rows[(i, j)] -= along * p;
            }
        }
    }
    pins
}
