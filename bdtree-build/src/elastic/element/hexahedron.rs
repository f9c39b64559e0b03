//! The eight-node hexahedron with incompatible modes.
//!
//! Trilinear displacements cannot bend without shear; nine more functions of the cell alone
//! (1 − ξ², 1 − η², 1 − ζ² in each direction) let it, and are condensed out. Their gradients are
//! taken with the Jacobian of the cell's middle, scaled by det J₀ / det J, so that they do no work
//! on a constant stress and every cell passes the patch test. E. L. Wilson, R. L. Taylor,
//! W. P. Doherty, J. Ghaboussi, "Incompatible displacement models" (1973); R. L. Taylor,
//! P. J. Beresford, E. L. Wilson, "A non-conforming element for stress analysis" (1976).

use nalgebra::{Matrix3, SMatrix};

use crate::elastic::element::ElementMatrices;
use crate::elastic::element::material::Material;

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

/// Consistent mass.
pub(crate) fn mass(p: &[[f64; 3]; 8], density: f64) -> Vec<f64> {
    let mut mass = vec![0.0; 64];
    for (x, w) in three() {
        let weight = density * w * jacobian(p, x).determinant();
        let values = values(x);
        for (n, m) in mass.iter_mut().enumerate() {
            *m += weight * values[n / 8] * values[n % 8];
        }
    }
    mass
}

/// Stiffness and consistent mass, or `None` if rounding leaves nothing of the incompatible
/// functions' stiffness. [`least_determinant`] must be positive.
pub(crate) fn matrices(
    p: &[[f64; 3]; 8],
    material: &Material,
    density: f64,
) -> Option<ElementMatrices> {
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
                material.add(&mut blocks[a][b], ga, gb, w * determinant);
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
    Some(ElementMatrices {
        stiffness: stiffness.collect(),
        mass: mass(p, density),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::assemble::energy;

    type V3 = [f64; 3];

    fn boxed(size: V3) -> [V3; 8] {
        CORNERS.map(|c| std::array::from_fn(|a| 0.5 * size[a] * c[a]))
    }

    /// The inner nodes of R. H. MacNeal, R. L. Harder, "A proposed standard set of problems to
    /// test finite element accuracy" (1985), in VTK's order.
    const INNER: [V3; 8] = [
        [0.249, 0.342, 0.192],
        [0.826, 0.288, 0.288],
        [0.850, 0.649, 0.263],
        [0.273, 0.750, 0.230],
        [0.320, 0.186, 0.643],
        [0.677, 0.305, 0.683],
        [0.788, 0.693, 0.644],
        [0.165, 0.745, 0.702],
    ];

    /// The inner cell and the six around it in the unit cube: nodes 0 to 7 inside, 8 to 15 outside.
    fn patch() -> Vec<[usize; 8]> {
        let faces = [
            [0, 1, 2, 3],
            [4, 7, 6, 5],
            [0, 4, 5, 1],
            [1, 5, 6, 2],
            [2, 6, 7, 3],
            [3, 7, 4, 0],
        ];
        // Seen from inside the inner cell a face runs so that the cell beyond it is upright.
        let around = faces
            .map(|f: [usize; 4]| std::array::from_fn(|n| if n < 4 { 8 + f[n] } else { f[n - 4] }));
        let inner = std::array::from_fn(|n| n);
        [vec![inner], around.to_vec()].concat()
    }

    fn patch_nodes() -> Vec<V3> {
        let outer = CORNERS.map(|c| c.map(|x| 0.5 + 0.5 * x));
        [INNER, outer].concat()
    }

    #[test]
    fn skewed_cells_pass_the_patch_test() {
        let nodes = patch_nodes();
        for material in [
            Material::new(1e6, 0.25),
            Material::new(1.0, 0.499),
            Material::new(1.0, -0.5),
        ] {
            let u = |[x, y, z]: V3| {
                [
                    1e-3 * (x + 0.5 * y + 0.5 * z),
                    1e-3 * (0.5 * x + y + 0.5 * z),
                    1e-3 * (0.5 * x + 0.5 * y + z),
                ]
            };
            let mut forces = [[0.0; 3]; 16];
            let (mut total, mut largest) = (0.0, 0.0f64);
            for cell in patch() {
                let p = cell.map(|n| nodes[n]);
                assert!(least_determinant(&p) > 0.0, "{cell:?}");
                total += volume(&p);
                let own = matrices(&p, &material, 1.0).expect("a sound cell");
                for i in 0..8 {
                    for j in 0..8 {
                        let uj = u(p[j]);
                        for (n, k) in own.stiffness[8 * i + j].iter().enumerate() {
                            forces[cell[i]][n / 3] += k * uj[n % 3];
                            largest = largest.max((k * uj[n % 3]).abs());
                        }
                    }
                }
            }
            assert!((total - 1.0).abs() < 1e-12);
            for f in forces[..8].iter().flatten() {
                assert!(f.abs() < 1e-12 * largest, "{f} of {largest}");
            }
        }
    }

    /// Pure bending of a box: the energy of beam theory, which trilinear functions miss by far.
    #[test]
    fn boxes_bend_without_locking() {
        let (size, poisson) = ([4.0, 0.5, 2.0], 0.3);
        let p = boxed(size);
        let own = matrices(&p, &Material::new(1.0, poisson), 1.0).expect("a sound cell");
        // u = xy, v = −(x² + ν (y² − z²)) / 2, which is a constant at the corners, w = −νyz.
        let bending = energy(&own, &p.map(|[x, y, z]| [x * y, 0.0, -poisson * y * z]));
        let inertia = size[2] * size[1].powi(3) / 12.0;
        assert!((bending / (0.5 * inertia * size[0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rigid_motions_cost_nothing_and_nothing_else_does() {
        let p: [V3; 8] = std::array::from_fn(|n| patch_nodes()[patch()[3][n]]);
        let own = matrices(&p, &Material::new(1.0, 0.3), 2.0).expect("a sound cell");
        let full = nalgebra::DMatrix::from_fn(24, 24, |i, j| {
            own.stiffness[8 * (i / 3) + j / 3][3 * (i % 3) + j % 3]
        });
        let mut values: Vec<f64> = full.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        assert!(values[5].abs() < 1e-14 && values[6] > 1e-3, "{values:?}");
        let mass: f64 = own.mass.iter().sum();
        assert!((mass - 2.0 * volume(&p)).abs() < 1e-14);
    }

    /// Its mass is that of many small boxes at the places where they lie.
    #[test]
    fn mass_is_the_integral_of_the_functions() {
        let p: [V3; 8] = std::array::from_fn(|n| patch_nodes()[patch()[1][n]]);
        let own = matrices(&p, &Material::new(1.0, 0.3), 1.0).expect("a sound cell");
        let steps = 40;
        let mut sums = [0.0; 64];
        for n in 0..steps * steps * steps {
            let x = [n % steps, n / steps % steps, n / (steps * steps)]
                .map(|k| (2 * k + 1) as f64 / steps as f64 - 1.0);
            let weight = jacobian(&p, x).determinant() * (2.0 / steps as f64).powi(3);
            let values = values(x);
            for (n, s) in sums.iter_mut().enumerate() {
                *s += weight * values[n / 8] * values[n % 8];
            }
        }
        for (m, s) in own.mass.iter().zip(sums) {
            // The midpoint rule's error is of second order in the step.
            assert!((m - s).abs() < 2e-3 * own.mass[0], "{m} {s}");
        }
    }

    #[test]
    fn cells_turned_inside_out_are_told() {
        let mut p = boxed([1.0; 3]);
        assert!((least_determinant(&p) - 0.125).abs() < 1e-15);
        p.swap(0, 6);
        assert!(least_determinant(&p) < 0.0);
        let mut p = boxed([1.0; 3]);
        p[6] = [-0.6, -0.6, -0.6];
        assert!(least_determinant(&p) < 0.0);
    }
}
