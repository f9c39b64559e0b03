//! The eight-node hexahedron with incompatible modes.
//!
//! Trilinear displacements cannot bend without shear; nine more functions of the cell alone
//! (1 − ξ², 1 − η², 1 − ζ² in each direction) let it, and are condensed out. Their gradients are
//! taken with the Jacobian of the cell's middle, scaled by det J₀ / det J, so that they do no work
//! on a constant stress and every cell passes the patch test. E. L. Wilson, R. L. Taylor,
//! W. P. Doherty, J. Ghaboussi, "Incompatible displacement models" (1973); R. L. Taylor,
//! P. J. Beresford, E. L. Wilson, "A non-conforming element for stress analysis" (1976).

use nalgebra::{Matrix3, SMatrix};

use super::assemble::ElementMatrices;
use super::law::Law;

/// Corners of the cube [-1, 1]³ in VTK's order.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
/// Trilinear functions and incompatible ones.
const FUNCTIONS: usize = 11;

/// The trilinear functions at a point of the cube.
fn values(x: [f64; 3]) -> [f64; 8] {
    CORNERS.map(|c| 0.125 * (0..3).map(|a| 1.0 + c[a] * x[a]).product::<f64>())
}

/// Their derivatives there.
fn slopes(x: [f64; 3]) -> [[f64; 3]; 8] {
    CORNERS.map(|c| {
        let f: [f64; 3] = std::array::from_fn(|a| 1.0 + c[a] * x[a]);
        std::array::from_fn(|a| 0.125 * c[a] * f[(a + 1) % 3] * f[(a + 2) % 3])
    })
}

/// Derivative of position by cube coordinates: column a is ∂p/∂x_a.
fn jacobian(p: &[[f64; 3]; 8], x: [f64; 3]) -> Matrix3<f64> {
    let slopes = slopes(x);
    Matrix3::from_fn(|i, a| (0..8).map(|n| p[n][i] * slopes[n][a]).sum())
}

/// The points of the tensor product of a rule in one dimension, with their weights.
fn rule<const N: usize>(one: [(f64, f64); N]) -> impl Iterator<Item = ([f64; 3], f64)> {
    (0..N * N * N).map(move |n| {
        let [a, b, c] = [n % N, n / N % N, n / (N * N)].map(|k| one[k]);
        ([a.0, b.0, c.0], a.1 * b.1 * c.1)
    })
}

/// Gauss' rule with two points per axis.
fn two() -> impl Iterator<Item = ([f64; 3], f64)> {
    let x = (1.0f64 / 3.0).sqrt();
    rule([(-x, 1.0), (x, 1.0)])
}

/// Gauss' rule with three points per axis: exact for the mass, whose integrand is of fourth degree
/// in each coordinate.
fn three() -> impl Iterator<Item = ([f64; 3], f64)> {
    let x = 0.6f64.sqrt();
    rule([(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)])
}

/// Smallest determinant of the Jacobian in the middle and at the points of both rules: not
/// positive for a cell that is turned inside out.
pub(crate) fn least_determinant(p: &[[f64; 3]; 8]) -> f64 {
    two()
        .chain(three())
        .map(|(x, _)| jacobian(p, x).determinant())
        .fold(f64::INFINITY, f64::min)
}

/// Volume.
pub(crate) fn volume(p: &[[f64; 3]; 8]) -> f64 {
    two().map(|(x, w)| w * jacobian(p, x).determinant()).sum()
}

/// Stiffness and consistent mass, or `None` if rounding leaves nothing of the incompatible
/// functions' stiffness. [`least_determinant`] must be positive.
pub(crate) fn matrices(p: &[[f64; 3]; 8], law: &Law, density: f64) -> Option<ElementMatrices> {
    let mut blocks = [[[0.0; 9]; FUNCTIONS]; FUNCTIONS];
    let middle = jacobian(p, [0.0; 3]);
    let (inner, inner_inverse) = (middle.determinant(), middle.try_inverse()?.transpose());
    for (x, w) in two() {
        let j = jacobian(p, x);
        let (determinant, inverse) = (j.determinant(), j.try_inverse()?.transpose());
        let slopes = slopes(x);
        let gradients: [[f64; 3]; FUNCTIONS] = std::array::from_fn(|n| match n {
            0..8 => (inverse * nalgebra::Vector3::from(slopes[n])).into(),
            _ => {
                let slope = -2.0 * x[n - 8] * inner / determinant;
                (inner_inverse.column(n - 8) * slope).into()
            }
        });
        for a in 0..FUNCTIONS {
            for b in 0..=a {
                let (ga, gb) = (gradients[a], gradients[b]);
                law.add(&mut blocks[a][b], ga, gb, w * determinant);
            }
        }
    }
    let entry = |row: usize, column: usize| {
        let (a, b) = (row / 3, column / 3);
        if a >= b {
            blocks[a][b][3 * (row % 3) + column % 3]
        } else {
            blocks[b][a][3 * (column % 3) + row % 3]
        }
    };
    let coupling = SMatrix::<f64, 9, 24>::from_fn(|i, j| entry(24 + i, j));
    let own = SMatrix::<f64, 9, 9>::from_fn(|i, j| entry(24 + i, 24 + j));
    let relief = coupling.transpose() * own.cholesky()?.solve(&coupling);
    let stiffness = (0..64).map(|n| {
        let (a, b) = (n / 8, n % 8);
        std::array::from_fn(|k| {
            let (row, column) = (3 * a + k / 3, 3 * b + k % 3);
            // Both sums are symmetric but for rounding.
            let relief = 0.5 * (relief[(row, column)] + relief[(column, row)]);
            entry(row, column) - relief
        })
    });
    let mut mass = vec![0.0; 64];
    for (x, w) in three() {
        let weight = density * w * jacobian(p, x).determinant();
        let values = values(x);
        for (n, m) in mass.iter_mut().enumerate() {
            *m += weight * values[n / 8] * values[n % 8];
        }
    }
    Some(ElementMatrices {
        stiffness: stiffness.collect(),
        mass,
    })
}
