//! The finite element of one cell: trilinear displacement with three incompatible modes.
//!
//! A plain trilinear cube locks in bending: it cannot curve. Wilson's incompatible modes 1 − ξ²,
//! 1 − η², 1 − ζ² per direction let it, and are condensed inside the cell; with them the cell
//! holds every quadratic displacement, so pure bending is exact in any direction. Taylor's
//! correction (their strains are shifted to zero mean over the *filled* part) keeps constant
//! strain exact in cut cells too. E. L. Wilson et al., "Incompatible displacement models" (1973);
//! R. L. Taylor, P. J. Beresford, E. L. Wilson, "A non-conforming element for stress analysis"
//! (1976); J. Parvizian, A. Düster, E. Rank, "Finite cell method" (2007).
//!
//! Everything is in cell units: edge 1, Young's modulus 1, density 1.

use super::moments::{Moments, full_cell};

/// Stiffness, 24 × 24: node-major, x y z within a node.
pub(crate) type Stiffness = [[f64; 24]; 24];
/// Mass per direction, 8 × 8.
pub(crate) type Mass = [[f64; 8]; 8];

/// A cell's filling is thinned out over the whole cell by this share of itself, so that nodes far
/// from the filled part do not come loose. It stiffens a wall of t cell sizes by 1e-4 / t².
const SPREAD: f64 = 1e-4;

/// Exponents of the monomials that strains and shape functions consist of.
const MONOMIALS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [0, 1, 1],
    [1, 0, 1],
    [1, 1, 1],
];

/// Makes element matrices from moments, for one Poisson's ratio.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    lambda: f64,
    mu: f64,
    /// Share of the row-sum lumped mass in the mass matrix; the rest is consistent.
    lumped: f64,
    shapes: [[f64; 8]; 8],
    gradients: [[f64; 8]; 24],
    full: Box<(Stiffness, Mass)>,
}

impl Element {
    /// For Poisson's ratio in (-1, 0.5).
    pub(crate) fn new(poisson: f64, lumped: f64) -> Self {
        let mut shapes = [[0.0; 8]; 8];
        let mut gradients = [[0.0; 8]; 24];
        for i in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|a| if i >> a & 1 == 1 { 0.125 } else { -0.125 });
            let s = [x, y, z].map(|v| 8.0 * v);
            shapes[i] = [
                1.0,
                s[0],
                s[1],
                s[2],
                s[0] * s[1],
                s[1] * s[2],
                s[0] * s[2],
                s[0] * s[1] * s[2],
            ]
            .map(|v| 0.125 * v);
            // d/dx = 2 d/dξ, for the cell has edge 1 and ξ runs from -1 to 1.
            let g = [x, y, z].map(|v| 2.0 * v);
            gradients[3 * i][0] = g[0];
            gradients[3 * i][2] = g[0] * s[1];
            gradients[3 * i][3] = g[0] * s[2];
            gradients[3 * i][5] = g[0] * s[1] * s[2];
            gradients[3 * i + 1][0] = g[1];
            gradients[3 * i + 1][1] = g[1] * s[0];
            gradients[3 * i + 1][3] = g[1] * s[2];
            gradients[3 * i + 1][6] = g[1] * s[0] * s[2];
            gradients[3 * i + 2][0] = g[2];
            gradients[3 * i + 2][1] = g[2] * s[0];
            gradients[3 * i + 2][2] = g[2] * s[1];
            gradients[3 * i + 2][4] = g[2] * s[0] * s[1];
        }
        let mut element = Self {
            lambda: poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
            mu: 0.5 / (1.0 + poisson),
            lumped,
            shapes,
            gradients,
            full: Box::new(([[0.0; 24]; 24], [[0.0; 8]; 8])),
        };
        *element.full = element.integrate(&full_cell());
        element
    }

    /// Stiffness and mass of a cell with this filling.
    pub(crate) fn matrices(&self, moments: &Moments) -> (Stiffness, Mass) {
        if moments[0] >= 1.0 {
            return *self.full;
        }
        let full = full_cell();
        let share = moments[0];
        let mut spread: Moments =
            std::array::from_fn(|n| (moments[n] + SPREAD * share * full[n]) / (1.0 + SPREAD));
        if !is_positive(&spread) {
            // Surfaces that cross themselves can leave sums that no filling has.
            spread = full.map(|m| share * m);
        }
        self.integrate(&spread)
    }

    fn integrate(&self, moments: &Moments) -> (Stiffness, Mass) {
        let gram = gram(moments);
        let share = moments[0];
        let mut gradients = [[0.0; 8]; 27];
        gradients[..24].copy_from_slice(&self.gradients);
        for (a, at) in [1usize, 3, 9].into_iter().enumerate() {
            gradients[24 + a][1 + a] = -4.0;
            gradients[24 + a][0] = 4.0 * moments[at] / share;
        }
        let mut s = [[0.0; 27]; 27];
        for i in 0..27 {
            let half: [f64; 8] =
                std::array::from_fn(|q| (0..7).map(|p| gradients[i][p] * gram[p][q]).sum());
            for j in 0..=i {
                let value: f64 = (0..7).map(|q| half[q] * gradients[j][q]).sum();
                s[i][j] = value;
                s[j][i] = value;
            }
        }
        (condense(&self.combine(&s)), self.mass(&gram))
    }

    /// The isotropic law: λ ∂ᵢu ∂ⱼv + μ (∇u·∇v δ + ∂ⱼu ∂ᵢv).
    fn combine(&self, s: &[[f64; 27]; 27]) -> Vec<[f64; 33]> {
        // Gradient number of function f along `a`; a bubble varies along its own axis only.
        let at = |f: usize, a: usize| match f {
            0..8 => Some(3 * f + a),
            _ => (f - 8 == a).then_some(16 + f),
        };
        let value = |i: Option<usize>, j: Option<usize>| match (i, j) {
            (Some(i), Some(j)) => s[i][j],
            _ => 0.0,
        };
        let mut k = vec![[0.0; 33]; 33];
        for f in 0..11 {
            for g in 0..11 {
                let along: f64 = (0..3).map(|a| value(at(f, a), at(g, a))).sum();
                for d in 0..3 {
                    for e in 0..3 {
                        let mut x = self.lambda * value(at(f, d), at(g, e))
                            + self.mu * value(at(f, e), at(g, d));
                        if d == e {
                            x += self.mu * along;
                        }
                        k[3 * f + d][3 * g + e] = x;
                    }
                }
            }
        }
        k
    }

    fn mass(&self, gram: &[[f64; 8]; 8]) -> Mass {
        let mut mass = [[0.0; 8]; 8];
        for (i, (shape, row)) in self.shapes.iter().zip(&mut mass).enumerate() {
            let half: [f64; 8] =
                std::array::from_fn(|q| (0..8).map(|p| shape[p] * gram[p][q]).sum());
            for (j, other) in self.shapes.iter().enumerate() {
                let value: f64 = half.iter().zip(other).map(|(a, b)| a * b).sum();
                row[j] += (1.0 - self.lumped) * value;
                // The shape functions add up to 1, so this is the row sum.
                row[i] += self.lumped * value;
            }
        }
        mass
    }
}

/// Integrals of all products of two monomials.
fn gram(m: &Moments) -> [[f64; 8]; 8] {
    std::array::from_fn(|p| {
        std::array::from_fn(|q| {
            let [a, b, c] = [0, 1, 2].map(|axis| MONOMIALS[p][axis] + MONOMIALS[q][axis]);
            m[a + 3 * b + 9 * c]
        })
    })
}

/// Whether the moments give positive energies: their Gram matrix has a Cholesky factor.
fn is_positive(m: &Moments) -> bool {
    let mut g = gram(m);
    for j in 0..8 {
        for k in 0..j {
            for i in j..8 {
                g[i][j] -= g[i][k] * g[j][k];
            }
        }
        if g[j][j].is_nan() || g[j][j] <= 1e-9 * m[0] {
            return false;
        }
        let root = g[j][j].sqrt();
        for row in g.iter_mut().skip(j) {
            row[j] /= root;
        }
    }
    true
}

/// Takes the nine incompatible unknowns out of a 33 × 33 stiffness.
fn condense(k: &[[f64; 33]]) -> Stiffness {
    let mut k: Vec<[f64; 33]> = k.to_vec();
    let trace: f64 = (24..33).map(|i| k[i][i]).sum();
    for pivot in (24..33).rev() {
        let row = k[pivot];
        if row[pivot] <= 1e-12 * trace {
            continue; // no energy in it, so nothing to give
        }
        for other in k.iter_mut().take(pivot) {
            let factor = other[pivot] / row[pivot];
            for (x, r) in other.iter_mut().zip(row).take(pivot) {
                *x -= factor * r;
            }
        }
    }
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (k[i][j] + k[j][i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of the box [lo, hi] inside the cell [-1, 1]³.
    fn filled_box(lo: [f64; 3], hi: [f64; 3]) -> Moments {
        std::array::from_fn(|n| {
            [n % 3, n / 3 % 3, n / 9]
                .into_iter()
                .enumerate()
                .map(|(a, e)| {
                    let e = e as i32 + 1;
                    (hi[a].powi(e) - lo[a].powi(e)) / (2.0 * f64::from(e))
                })
                .product()
        })
    }

    fn energy(k: &Stiffness, u: &dyn Fn([f64; 3]) -> [f64; 3]) -> f64 {
        let values: Vec<f64> = (0..8)
            .flat_map(|i| u([0, 1, 2].map(|a| f64::from((i >> a & 1) as u8) - 0.5)))
            .collect();
        let mut sum = 0.0;
        for i in 0..24 {
            for j in 0..24 {
                sum += 0.5 * values[i] * k[i][j] * values[j];
            }
        }
        sum
    }

    #[test]
    fn rigid_motions_cost_nothing_and_constant_strain_is_exact_in_cut_cells() {
        let element = Element::new(0.3, 0.5);
        for m in [
            full_cell(),
            filled_box([-1.0, -0.2, 0.1], [0.3, 0.9, 1.0]),
            filled_box([0.7, -1.0, -1.0], [0.8, 1.0, 1.0]),
        ] {
            let (k, mass) = element.matrices(&m);
            assert!(energy(&k, &|_| [1.0, 2.0, -1.0]).abs() < 1e-14);
            assert!(energy(&k, &|[x, y, z]| [y - z, -x + 2.0 * z, x - 2.0 * y]).abs() < 1e-14);
            let strain = energy(&k, &|[x, y, z]| [x, -0.3 * y, -0.3 * z]);
            assert!(
                (strain / (0.5 * m[0]) - 1.0).abs() < 1e-9,
                "{strain} {}",
                m[0]
            );
            let total: f64 = mass.iter().flatten().sum();
            assert!((total / m[0] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_full_cell_bends_without_locking() {
        let (k, _) = Element::new(0.3, 0.5).matrices(&full_cell());
        // Pure bending, u = κxy, w = -νκyz; the squares are left to the incompatible modes.
        // Beam theory: EI κ²/2 with I = 1/12.
        let bending = energy(&k, &|[x, y, z]| [x * y, 0.0, -0.3 * y * z]);
        assert!((bending * 24.0 - 1.0).abs() < 1e-12, "{bending}");
    }

    #[test]
    fn impossible_moments_still_give_positive_energies() {
        let mut m = full_cell().map(|x| 0.2 * x);
        m[2] = -0.3;
        let (k, mass) = Element::new(0.3, 0.5).matrices(&m);
        assert!((0..24).all(|i| k[i][i] > 0.0) && (0..8).all(|i| mass[i][i] > 0.0));
    }
}
