//! The finite element of one cell: quadratic B-splines.
//!
//! A displacement is a sum of the lattice's uniform quadratic B-splines, products of one per axis,
//! each spread over 3 × 3 × 3 cells; a cell sees 27 of them. Their sums hold every quadratic
//! displacement *and* have continuous gradients, so walls bend freely however they lie to the
//! lattice, also where they are a fraction of a cell thick: the error of the curvature is of
//! second order in the cell size. (Trilinear cubes with incompatible modes, which do as well
//! along the axes, come out a third too stiff there: docs/design/decisions/elastic-element.md.)
//! K. Höllig, "Finite Element Methods with B-Splines" (2003); D. Schillinger, E. Rank, "An
//! unfitted hp-adaptive finite element method based on hierarchical B-splines" (2011);
//! J. Parvizian, A. Düster, E. Rank, "Finite cell method" (2007).
//!
//! Everything is in cell units: edge 1, Young's modulus 1, density 1.

use crate::elastic::element::ElementMatrices;
use crate::elastic::element::moments::{Moments, POWERS, full_cell};
use crate::mass::integrals::Integrals;

/// Functions that act in a cell: number `a + 3b + 9c` is centered `a − 1`, `b − 1`, `c − 1` cells
/// from it.
pub(crate) const FUNCTIONS: usize = 27;
/// Pairs of one axis' three functions.
const PAIRS: usize = 9;

/// A cell's filling is thinned out over the whole cell by this share of itself, so that functions
/// that hardly meet the filled part stay apart. It stiffens a wall of t cell sizes by 1e-4 / t².
const SPREAD: f64 = 1e-4;

/// The three functions of one axis at ξ in [-1, 1] across the cell.
pub(crate) fn spline(x: f64) -> [f64; 3] {
    [
        0.125 * (1.0 - x) * (1.0 - x),
        0.75 - 0.25 * x * x,
        0.125 * (1.0 + x) * (1.0 + x),
    ]
}

/// Coefficients of the three functions in powers of ξ.
const VALUES: [[f64; 3]; 3] = [
    [0.125, -0.25, 0.125],
    [0.75, 0.0, -0.25],
    [0.125, 0.25, 0.125],
];
/// Those of their derivatives by x = ξ / 2.
const SLOPES: [[f64; 3]; 3] = [[-0.5, 0.5, 0.0], [0.0, -1.0, 0.0], [0.5, 0.5, 0.0]];

/// Products of two functions of one axis, per pair, in powers of ξ.
type Products = [[f64; POWERS]; PAIRS];

fn products(first: &[[f64; 3]; 3], second: &[[f64; 3]; 3]) -> Products {
    std::array::from_fn(|pair| {
        let mut product = [0.0; POWERS];
        for (i, a) in first[pair / 3].iter().enumerate() {
            for (j, b) in second[pair % 3].iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        product
    })
}

/// What a cell's mass matrix says of rigid motions: integrals over its filling, in cell units from its middle.
#[derive(Debug, Clone)]
pub(crate) struct Resultants {
    /// Of the filling.
    pub filling: Integrals,
    /// Per function: ∫ N, and ∫ N x.
    pub functions: [(f64, [f64; 3]); FUNCTIONS],
}

/// The resultants of a cell with this filling: row sums of its mass matrix, since the functions sum to 1 and their
/// centers carry every linear field.
pub(crate) fn resultants(moments: &Moments) -> Resultants {
    let own = match moments[0] {
        share if share >= 1.0 => full_cell(),
        _ => sound(moments),
    };
    let entry = |[a, b, c]: [usize; 3]| own[a + POWERS * b + POWERS * POWERS * c];
    let half = |powers: [usize; 3]| 0.5 * entry(powers);
    let quarter = |powers: [usize; 3]| 0.25 * entry(powers);
    let mut filling = Integrals::default();
    filling.add(
        own[0],
        [half([1, 0, 0]), half([0, 1, 0]), half([0, 0, 1])],
        [
            quarter([2, 0, 0]),
            quarter([0, 2, 0]),
            quarter([0, 0, 2]),
            quarter([1, 1, 0]),
            quarter([1, 0, 1]),
            quarter([0, 1, 1]),
        ],
    );
    let functions = std::array::from_fn(|n| {
        let of = [n % 3, n / 3 % 3, n / 9];
        let integral = |more: [usize; 3]| {
            let mut sum = 0.0;
            for (k, z) in VALUES[of[2]].iter().enumerate() {
                for (j, y) in VALUES[of[1]].iter().enumerate() {
                    for (i, x) in VALUES[of[0]].iter().enumerate() {
                        sum += x * y * z * entry([i + more[0], j + more[1], k + more[2]]);
                    }
                }
            }
            sum
        };
        let along = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|more| 0.5 * integral(more));
        (integral([0; 3]), along)
    });
    Resultants { filling, functions }
}

/// Makes element matrices from moments, for one Poisson's ratio.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    lambda: f64,
    mu: f64,
    /// N N, N' N, N N', N' N'.
    products: [Products; 4],
    full: ElementMatrices,
}

/// Places in [`Element::products`].
const NN: usize = 0;
const DN: usize = 1;
const ND: usize = 2;
const DD: usize = 3;

impl Element {
    /// For Poisson's ratio in (-1, 0.5).
    pub(crate) fn new(poisson: f64) -> Self {
        let mut element = Self {
            lambda: poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
            mu: 0.5 / (1.0 + poisson),
            products: [
                products(&VALUES, &VALUES),
                products(&SLOPES, &VALUES),
                products(&VALUES, &SLOPES),
                products(&SLOPES, &SLOPES),
            ],
            full: ElementMatrices {
                stiffness: Vec::new(),
                mass: Vec::new(),
            },
        };
        element.full = element.integrate(&full_cell());
        element
    }

    /// Stiffness and mass of a cell with this filling.
    pub(crate) fn matrices(&self, moments: &Moments) -> std::borrow::Cow<'_, ElementMatrices> {
        if moments[0] >= 1.0 {
            return std::borrow::Cow::Borrowed(&self.full);
        }
        std::borrow::Cow::Owned(self.integrate(&sound(moments)))
    }

    /// Axis after axis, so that each step sums over one power only.
    fn integrate(&self, moments: &Moments) -> ElementMatrices {
        let [nn, dn, nd, dd] = [NN, DN, ND, DD].map(|kind| self.along_x(moments, kind));
        let mass = self.along_z(&self.along_y(&nn, NN), NN);
        let xx = self.along_z(&self.along_y(&dd, NN), NN);
        let yy = self.along_z(&self.along_y(&nn, DD), NN);
        let zz = self.along_z(&self.along_y(&nn, NN), DD);
        // ∫ ∂x Nᵢ ∂y Nⱼ, and so on; the other order is the transposed.
        let xy = self.along_z(&self.along_y(&dn, ND), NN);
        let xz = self.along_z(&self.along_y(&dn, NN), ND);
        let yx = self.along_z(&self.along_y(&nd, DN), NN);
        let zx = self.along_z(&self.along_y(&nd, NN), DN);
        let half = self.along_y(&nn, DN);
        let yz = self.along_z(&half, ND);
        let zy = self.along_z(&self.along_y(&nn, ND), DN);
        let stiffness = (0..FUNCTIONS * FUNCTIONS)
            .map(|n| {
                // The isotropic material: λ ∂ᵢu ∂ⱼv + μ (∇u·∇v δ + ∂ⱼu ∂ᵢv).
                let s = [
                    [xx[n], xy[n], xz[n]],
                    [yx[n], yy[n], yz[n]],
                    [zx[n], zy[n], zz[n]],
                ];
                let along = s[0][0] + s[1][1] + s[2][2];
                let mut block = [0.0; 9];
                for d in 0..3 {
                    for e in 0..3 {
                        block[3 * d + e] = self.lambda * s[d][e] + self.mu * s[e][d];
                    }
                    block[4 * d] += self.mu * along;
                }
                block
            })
            .collect();
        ElementMatrices { stiffness, mass }
    }

    /// Sums over the powers of ξ: per pair of x, what remains in η and ζ.
    fn along_x(&self, moments: &Moments, kind: usize) -> [[f64; POWERS * POWERS]; PAIRS] {
        let mut out = [[0.0; POWERS * POWERS]; PAIRS];
        for (row, product) in out.iter_mut().zip(&self.products[kind]) {
            for (n, sum) in row.iter_mut().enumerate() {
                for (m, p) in moments[POWERS * n..].iter().zip(product) {
                    *sum += m * p;
                }
            }
        }
        out
    }

    /// Sums over the powers of η: per pair of x and of y, what remains in ζ.
    fn along_y(
        &self,
        x: &[[f64; POWERS * POWERS]; PAIRS],
        kind: usize,
    ) -> [[[f64; POWERS]; PAIRS]; PAIRS] {
        let mut out = [[[0.0; POWERS]; PAIRS]; PAIRS];
        for (rows, x) in out.iter_mut().zip(x) {
            for (row, product) in rows.iter_mut().zip(&self.products[kind]) {
                for (c, sum) in row.iter_mut().enumerate() {
                    for (m, p) in x[POWERS * c..].iter().zip(product) {
                        *sum += m * p;
                    }
                }
            }
        }
        out
    }

    /// Sums over the powers of ζ: one number per pair of functions, at `27 i + j`.
    fn along_z(&self, xy: &[[[f64; POWERS]; PAIRS]; PAIRS], kind: usize) -> Vec<f64> {
        let mut out = vec![0.0; FUNCTIONS * FUNCTIONS];
        for (x, rows) in xy.iter().enumerate() {
            for (y, row) in rows.iter().enumerate() {
                for (z, product) in self.products[kind].iter().enumerate() {
                    let i = x / 3 + 3 * (y / 3) + 9 * (z / 3);
                    let j = x % 3 + 3 * (y % 3) + 9 * (z % 3);
                    let sum: f64 = row.iter().zip(product).map(|(m, p)| m * p).sum();
                    out[FUNCTIONS * i + j] = sum;
                }
            }
        }
        out
    }
}

/// The moments with a share of them spread over the cell: as little as gives positive energies.
///
/// Surfaces that cross themselves can leave sums that no filling has; these end as a thinner
/// filling of the whole cell.
fn sound(moments: &Moments) -> Moments {
    let full = full_cell();
    let share = moments[0];
    let mut spread = SPREAD;
    while spread < 1.0 {
        let mixed =
            std::array::from_fn(|n| (moments[n] + spread * share * full[n]) / (1.0 + spread));
        if is_positive(&mixed) {
            return mixed;
        }
        spread *= 10.0;
    }
    full.map(|m| share * m)
}

/// Whether the moments give positive energies: the Gram matrix of the monomials that a function
/// consists of has a Cholesky factor.
fn is_positive(moments: &Moments) -> bool {
    let exponents = |n: usize| [n % 3, n / 3 % 3, n / 9];
    let mut g = [[0.0; FUNCTIONS]; FUNCTIONS];
    for (p, row) in g.iter_mut().enumerate() {
        for (q, value) in row.iter_mut().enumerate().take(p + 1) {
            let (p, q) = (exponents(p), exponents(q));
            *value =
                moments[p[0] + q[0] + POWERS * (p[1] + q[1]) + POWERS * POWERS * (p[2] + q[2])];
        }
    }
    for j in 0..FUNCTIONS {
        let pivot = g[j][j] - g[j][..j].iter().map(|x| x * x).sum::<f64>();
        // A full cell's least pivot is 7e-4; the spread share of it is 7e-8.
        if pivot.is_nan() || pivot <= 1e-9 * moments[0] {
            return false;
        }
        let root = pivot.sqrt();
        g[j][j] = root;
        let own = g[j];
        for row in g.iter_mut().skip(j + 1) {
            let sum: f64 = row[..j].iter().zip(&own[..j]).map(|(a, b)| a * b).sum();
            row[j] = (row[j] - sum) / root;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of the box [lo, hi] inside the cell [-1, 1]³.
    fn filled_box(lo: [f64; 3], hi: [f64; 3]) -> Moments {
        std::array::from_fn(|n| {
            [n % 5, n / 5 % 5, n / 25]
                .into_iter()
                .enumerate()
                .map(|(a, e)| {
                    let e = e as i32 + 1;
                    (hi[a].powi(e) - lo[a].powi(e)) / (2.0 * f64::from(e))
                })
                .product()
        })
    }

    /// Coefficients of a quadratic displacement: 1, x, x², y, xy, … with x from the cell's middle.
    /// A spline's coefficient is the blossom of the polynomial at its two inner knots.
    fn coefficients(u: &dyn Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
        // The blossom of a quadratic p at (s, t): 2 p((s + t) / 2) − (p(s) + p(t)) / 2, per axis.
        let mut out = Vec::new();
        for n in 0..FUNCTIONS {
            let middle = [n % 3, n / 3 % 3, n / 9].map(|a| a as f64 - 1.0);
            let mut sum = [0.0; 3];
            for corner in 0..27usize {
                let at = [corner % 3, corner / 3 % 3, corner / 9];
                let weight: f64 = at.iter().map(|&a| [-0.5, 2.0, -0.5][a]).product();
                let p = std::array::from_fn(|a| middle[a] + [-0.5, 0.0, 0.5][at[a]]);
                for (s, v) in sum.iter_mut().zip(u(p)) {
                    *s += weight * v;
                }
            }
            out.extend(sum);
        }
        out
    }

    fn energy(matrices: &ElementMatrices, u: &dyn Fn([f64; 3]) -> [f64; 3]) -> f64 {
        let c = coefficients(u);
        let mut sum = 0.0;
        for i in 0..FUNCTIONS {
            for j in 0..FUNCTIONS {
                for (n, k) in matrices.stiffness[FUNCTIONS * i + j].iter().enumerate() {
                    sum += 0.5 * c[3 * i + n / 3] * k * c[3 * j + n % 3];
                }
            }
        }
        sum
    }

    #[test]
    fn rigid_motions_cost_nothing_and_constant_strain_is_exact_in_cut_cells() {
        let element = Element::new(0.3);
        for m in [
            full_cell(),
            filled_box([-1.0, -0.2, 0.1], [0.3, 0.9, 1.0]),
            filled_box([0.7, -1.0, -1.0], [0.8, 1.0, 1.0]),
        ] {
            let k = element.matrices(&m);
            assert!(energy(&k, &|_| [1.0, 2.0, -1.0]).abs() < 1e-14);
            assert!(energy(&k, &|[x, y, z]| [y - z, -x + 2.0 * z, x - 2.0 * y]).abs() < 1e-14);
            let strain = energy(&k, &|[x, y, z]| [x, -0.3 * y, -0.3 * z]);
            assert!((strain / (0.5 * m[0]) - 1.0).abs() < 1e-9, "{strain}");
            let total: f64 = k.mass.iter().sum();
            assert!((total / m[0] - 1.0).abs() < 1e-12);
        }
    }

    /// Pure bending about any axis, of a thin layer anywhere in the cell: beam theory's energy.
    #[test]
    fn thin_layers_bend_without_locking() {
        let element = Element::new(0.3);
        for (lo, hi) in [(-1.0, 1.0), (-0.3, 0.3), (0.2, 0.5)] {
            let k = element.matrices(&filled_box([-1.0, lo, -1.0], [1.0, hi, 1.0]));
            // u = κxy, v = −κ(x² + ν(y² − z²))/2, w = −νκyz, about the layer's own middle.
            let middle = 0.25 * (lo + hi);
            let bending = energy(&k, &|[x, y, z]| {
                let y = y - middle;
                let v = -0.5 * (x * x + 0.3 * (y * y - z * z));
                [x * y, v, -0.3 * y * z]
            });
            let thickness = 0.5 * (hi - lo);
            let want = 0.5 * thickness.powi(3) / 12.0;
            // What is spread over the cell lies 0.5 from the middle at most.
            let spread = 0.5 * thickness * SPREAD;
            assert!((bending - want).abs() < 1e-12 + spread, "{bending} {want}");
        }
    }

    #[test]
    fn impossible_moments_still_give_positive_energies() {
        let mut m = full_cell().map(|x| 0.2 * x);
        m[2] = -0.3;
        let k = Element::new(0.3).matrices(&m).into_owned();
        for i in 0..FUNCTIONS {
            let own = FUNCTIONS * i + i;
            assert!(k.mass[own] > 0.0 && [0, 4, 8].iter().all(|&n| k.stiffness[own][n] > 0.0));
        }
    }

    #[test]
    fn functions_add_up_to_one_and_follow_lines() {
        for x in [-1.0, -0.4, 0.0, 0.7, 1.0] {
            let n = spline(x);
            assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!((n[2] - n[0] - 0.5 * x).abs() < 1e-15);
            for (value, c) in n.iter().zip(VALUES) {
                assert!((value - (c[0] + c[1] * x + c[2] * x * x)).abs() < 1e-15);
            }
        }
    }
}
