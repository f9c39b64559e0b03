//! The two tangents of one vertex and how modes move them, so that their cross product follows the
//! normal (docs/design/decisions/normal-fields.md).

use bdtree_runtime::{Asset, VertexId};
use glam::{DMat3, DVec3};

use crate::error::GpuError;

/// Up to so many modes that act on a vertex the terms of second order are met, too: 9 m² numbers per vertex
/// are solved for, and the sums of all pairs of modes formed.
const SECOND_ORDER_MODES: usize = 24;
/// Weight of a mode's own square beside products of two modes: of few modes the largest errors.
const OWN_SQUARE: f64 = 4.0;
/// Weight of the gradient that the edges show: what second-order terms leave open, it decides.
const GRADIENT: f64 = 0.03;
/// Regularisation of the gradient across flat triangles, of the trace of the edges' matrix.
const ACROSS: f64 = 1e-3;

/// The triangles around one vertex: both edges of each, at rest and per mode.
#[derive(Debug, Default)]
pub(crate) struct Around {
    rest: Vec<[DVec3; 2]>,
    /// Mode by mode.
    moved: Vec<[DVec3; 2]>,
    /// The normal as a polynomial in q; its pairs only up to [`SECOND_ORDER_MODES`].
    polynomial: Polynomial,
}

/// The normal weighted by area, `N + Σ_j L_j q_j + Σ_{k ≤ j} Q_jk q_j q_k`.
#[derive(Debug, Default)]
struct Polynomial {
    constant: DVec3,
    linear: Vec<DVec3>,
    /// Q_jk at [`pair`].
    pairs: Vec<DVec3>,
    /// Length of the longest edge at rest, then of its longest change by each mode.
    longest: Vec<f64>,
}

/// What [`NormalFields`] keeps of a vertex.
pub(crate) struct Tangents {
    pub(crate) rest: [[f32; 3]; 2],
    pub(crate) moved: Vec<[[f32; 3]; 2]>,
}

impl Tangents {
    /// Both at q times `sign`, of modes by their place among the vertex's.
    pub(crate) fn moved_by(&self, q: &[(usize, f64)], sign: f64) -> [DVec3; 2] {
        [0, 1].map(|side| {
            q.iter().fold(wide(self.rest[side]), |sum, (k, q)| {
                sum + sign * *q * wide(self.moved[*k][side])
            })
        })
    }
}

impl Around {
    pub(crate) fn gather(
        &mut self,
        asset: &Asset<'_>,
        triangles: &[[u32; 2]],
        vertex: usize,
        modes: &[u16],
        amplitudes: &[f64],
    ) -> Result<(), GpuError> {
        let at = |v: u32| wide(asset.positions()[v as usize]);
        let own = at(vertex as u32);
        self.rest.clear();
        self.rest
            .extend(triangles.iter().map(|others| others.map(|v| at(v) - own)));
        self.moved.clear();
        let fields = |v: u32| asset.displacements(VertexId(v));
        let own = fields(vertex as u32)?;
        let mut of_others = Vec::with_capacity(triangles.len());
        for [b, c] in triangles {
            of_others.push([fields(*b)?, fields(*c)?]);
        }
        for mode in modes {
            let mode = usize::from(*mode);
            let own = wide(own.of(mode));
            let edges = of_others
                .iter()
                .map(|both| both.map(|f| wide(f.of(mode)) - own));
            self.moved.extend(edges);
        }
        self.expand(amplitudes);
        Ok(())
    }

    /// Forms the polynomial.
    fn expand(&mut self, amplitudes: &[f64]) {
        let mode_count = amplitudes.len();
        let acting = amplitudes.iter().filter(|a| **a > 0.0).count();
        let mut polynomial = std::mem::take(&mut self.polynomial);
        polynomial.constant = (self.rest.iter()).fold(DVec3::ZERO, |sum, [e, f]| sum + e.cross(*f));
        polynomial.linear.clear();
        polynomial.linear.extend((0..mode_count).map(|j| {
            let moved = self.rest.iter().zip(self.of(j));
            moved.fold(DVec3::ZERO, |sum, ([e, f], [de, df])| {
                sum + (de.cross(*f) + e.cross(*df))
            })
        }));
        polynomial.pairs.clear();
        if acting <= SECOND_ORDER_MODES {
            let pairs = (0..mode_count).flat_map(|j| (0..=j).map(move |k| (j, k)));
            polynomial.pairs.extend(pairs.map(|(j, k)| {
                let both = self.of(j).iter().zip(self.of(k));
                both.fold(DVec3::ZERO, |sum, ([e, f], [g, h])| {
                    let own = e.cross(*h);
                    sum + if j == k { own } else { own + g.cross(*f) }
                })
            }));
        }
        polynomial.longest.clear();
        let all = std::iter::once(self.rest.as_slice());
        let all = all.chain((0..mode_count).map(|j| self.of(j)));
        polynomial.longest.extend(all.map(|edges| {
            let squares = edges.as_flattened().iter().map(|e| e.length_squared());
            squares.fold(0.0, f64::max).sqrt()
        }));
        self.polynomial = polynomial;
    }

    /// The terms of the normal that keep their sign with q → −q, and those that change it: the normal of [`Around::normal`]
    /// but for rounding, relative to the third number. `None` where there are too many modes.
    pub(crate) fn even_and_odd(&self, q: &[(usize, f64)]) -> Option<(DVec3, DVec3, f64)> {
        let of = &self.polynomial;
        let (mut even, mut odd) = (of.constant, DVec3::ZERO);
        let mut longest = *of.longest.first()?;
        for (n, (j, q_j)) in q.iter().enumerate() {
            odd += *q_j * *of.linear.get(*j)?;
            longest += q_j.abs() * of.longest.get(1 + j)?;
            for (k, q_k) in &q[..=n] {
                even += q_j * q_k * *of.pairs.get(pair(*j, *k))?;
            }
        }
        Some((even, odd, self.rest.len() as f64 * longest * longest))
    }

    /// The exact normal at q, weighted by area, and the sum of the lengths of its terms, Σ ‖e‖ ‖f‖.
    pub(crate) fn normal(&self, q: &[(usize, f64)]) -> (DVec3, f64) {
        let mut sum = (DVec3::ZERO, 0.0);
        for (i, rest) in self.rest.iter().enumerate() {
            let [e, f] = [0, 1].map(|side| {
                q.iter()
                    .fold(rest[side], |sum, (k, q)| sum + *q * self.of(*k)[i][side])
            });
            sum = (sum.0 + e.cross(f), sum.1 + e.length() * f.length());
        }
        sum
    }

    /// Edges' changes by a mode.
    fn of(&self, mode: usize) -> &[[DVec3; 2]] {
        &self.moved[mode * self.rest.len()..][..self.rest.len()]
    }

    pub(crate) fn tangents(&self, amplitudes: &[f64]) -> Tangents {
        let Polynomial {
            constant: normal,
            linear,
            pairs,
            ..
        } = &self.polynomial;
        let area = normal.length();
        let none = Tangents {
            rest: [[0.0; 3]; 2],
            moved: vec![[[0.0; 3]; 2]; amplitudes.len()],
        };
        if !(area > 0.0 && area.is_finite()) {
            return none;
        }
        let n = *normal * (1.0 / area);
        let axis = if n.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
        let t1 = axis.cross(n);
        let t1 = t1 * (1.0 / t1.length());
        let t2 = n.cross(t1);
        let local = |v: DVec3| [v.dot(t1), v.dot(t2), v.dot(n)];
        // First order: T₁ × t₂ + t₁ × T₂ = L. With T₁ = (a₁, b₁, c₁) and T₂ = (a₂, b₂, c₂) along t₁, t₂
        // and n that is c₁ = −L·t₁, c₂ = −L·t₂, a₁ + b₂ = L·n: three numbers per mode are left, a₁, b₁ and
        // a₂. All for modes at their amplitude.
        let first: Vec<[f64; 3]> = (linear.iter().zip(amplitudes))
            .map(|(l, amplitude)| {
                let [x, y, z] = local(*l * (amplitude / area));
                [-x, -y, z]
            })
            .collect();
        let mut open = self.gradients(amplitudes, [t1, t2]);
        for (open, [_, _, trace]) in open.iter_mut().zip(&first) {
            // Half of what the trace lacks.
            open[0] += 0.5 * (trace - open[0] - open[3]);
        }
        let mut open: Vec<[f64; 3]> = open.into_iter().map(|[a, b, c, _]| [a, b, c]).collect();
        if !pairs.is_empty() {
            let quadratic = |j: usize, k: usize| {
                local(pairs[pair(j, k)] * (amplitudes[j] * amplitudes[k] / area))
            };
            meet_second_order(&first, &mut open, quadratic);
        }
        let moved = first.iter().zip(&open).zip(amplitudes);
        let moved = moved.map(|(([c1, c2, trace], [a1, b1, a2]), amplitude)| {
            let acts = *amplitude > 0.0;
            let per = if acts { 1.0 / amplitude } else { 0.0 };
            let combine = |a: f64, b: f64, c: f64| finite((a * t1 + b * t2 + c * n) * per);
            [combine(*a1, *b1, *c1), combine(*a2, trace - a1, *c2)]
        });
        Tangents {
            rest: [finite(t1), finite(t2)],
            moved: moved.collect(),
        }
    }

    /// Of each mode at its amplitude the gradient in the tangents' plane, (t₁·Gt₁, t₂·Gt₁, t₁·Gt₂, t₂·Gt₂),
    /// with G the 3 × 3 matrix that maps edges to their changes best, all edges alike.
    fn gradients(&self, amplitudes: &[f64], tangents: [DVec3; 2]) -> Vec<[f64; 4]> {
        let weight = |e: DVec3| {
            let square = e.length_squared();
            if square > 0.0 { 1.0 / square } else { 0.0 }
        };
        let edges = self.rest.as_flattened();
        let mut matrix = DMat3::ZERO;
        for e in edges {
            let scaled = weight(*e) * *e;
            matrix += DMat3::from_cols(scaled * e.x, scaled * e.y, scaled * e.z);
        }
        let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
        let ridge = DMat3::from_diagonal(DVec3::splat(ACROSS * trace));
        let inverse = (matrix + ridge).inverse();
        let solved = tangents.map(|t| inverse * t);
        let one = |(j, amplitude): (usize, &f64)| {
            // G t = Σ w de (e · M⁻¹ t), since M is symmetric.
            let images = solved.map(|s| {
                let changes = self.of(j).as_flattened();
                edges.iter().zip(changes).fold(DVec3::ZERO, |sum, (e, de)| {
                    sum + amplitude * weight(*e) * e.dot(s) * *de
                })
            });
            let [t1, t2] = tangents;
            [
                images[0].dot(t1),
                images[0].dot(t2),
                images[1].dot(t1),
                images[1].dot(t2),
            ]
        };
        amplitudes.iter().enumerate().map(one).collect()
    }
}

/// The place of two modes among all pairs of them.
fn pair(j: usize, k: usize) -> usize {
    let (more, less) = (j.max(k), j.min(k));
    more * (more + 1) / 2 + less
}

/// Moves (a₁, b₁, a₂) of all modes so that the tangential parts of T₁ⱼ × T₂ₖ + T₁ₖ × T₂ⱼ come near those of
/// the quadratic terms: linear least squares, since c₁, c₂ and a₁ + b₂ are given.
fn meet_second_order(
    first: &[[f64; 3]],
    open: &mut [[f64; 3]],
    quadratic: impl Fn(usize, usize) -> [f64; 3],
) {
    let m = first.len();
    let squares = |v: &[f64; 3]| DVec3::from_array(*v).length_squared();
    let size = first.iter().chain(&*open).map(squares).sum::<f64>() / m.max(1) as f64;
    if !(size > 0.0 && size.is_finite()) {
        return;
    }
    let n = 3 * m;
    let mut matrix = vec![0.0; n * n];
    let mut right = vec![0.0; n];
    for (i, x) in open.as_flattened().iter().enumerate() {
        matrix[i * n + i] = GRADIENT * size;
        right[i] = GRADIENT * size * x;
    }
    for j in 0..m {
        for k in 0..=j {
            let [x, y, _] = quadratic(j, k);
            let weight = if j == k { OWN_SQUARE } else { 1.0 };
            // T₁ × T₂ along t₁ is b₁c₂ − c₁b₂, along t₂ it is c₁a₂ − a₁c₂; b₂ = trace − a₁.
            let mut along = [(Vec::with_capacity(4), x), (Vec::with_capacity(4), y)];
            let mut product = |p: usize, q: usize| {
                let ([c1, _, _], [_, c2, trace]) = (first[p], first[q]);
                along[0].0.extend([(3 * p + 1, c2), (3 * q, c1)]);
                along[0].1 += c1 * trace;
                along[1].0.extend([(3 * q + 2, c1), (3 * p, -c2)]);
            };
            product(j, k);
            if j != k {
                product(k, j);
            }
            for (row, value) in along {
                for (p, x) in &row {
                    for (q, y) in &row {
                        matrix[p * n + q] += weight * x * y;
                    }
                    right[*p] += weight * x * value;
                }
            }
        }
    }
    if cholesky_solve(&mut matrix, &mut right) {
        open.as_flattened_mut().copy_from_slice(&right);
    }
}

/// Solves A x = b for a symmetric positive A; false where it is not, to working precision.
fn cholesky_solve(a: &mut [f64], b: &mut [f64]) -> bool {
    let n = b.len();
    for i in 0..n {
        for j in 0..=i {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= a[i * n + k] * a[j * n + k];
            }
            if i == j {
                if !(sum > 0.0 && sum.is_finite()) {
                    return false;
                }
                a[i * n + i] = sum.sqrt();
            } else {
                a[i * n + j] = sum / a[j * n + j];
            }
        }
    }
    for i in 0..n {
        for k in 0..i {
            b[i] -= a[i * n + k] * b[k];
        }
        b[i] /= a[i * n + i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            b[i] -= a[k * n + i] * b[k];
        }
        b[i] /= a[i * n + i];
    }
    true
}

/// In f32, zero where it is not finite: a needle whose gradient f32 cannot hold has none.
fn finite(v: DVec3) -> [f32; 3] {
    let v = v.as_vec3();
    if v.is_finite() {
        v.to_array()
    } else {
        [0.0; 3]
    }
}

/// In f64.
pub(crate) fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

#[cfg(test)]
mod tests {
    use bdtree_fixtures::poses;
    use rand::RngExt;

    use super::*;

    #[test]
    fn the_polynomial_is_the_sum_over_the_triangles() {
        let mut rng = poses::rng(1);
        for modes in [0, 1, 2, 7, SECOND_ORDER_MODES] {
            let mut edges = |count: usize| -> Vec<[DVec3; 2]> {
                let mut vector =
                    || DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0)));
                (0..count).map(|_| [vector(), vector()]).collect()
            };
            let mut around = Around {
                rest: edges(6),
                moved: edges(6 * modes),
                ..Default::default()
            };
            around.expand(&vec![1.0; modes]);
            // In any order of the modes.
            let mut q: Vec<_> = (0..modes)
                .map(|k| (k, rng.random_range(-0.3..0.3)))
                .collect();
            q.rotate_left(modes / 2);
            for sign in [1.0, -1.0] {
                let (even, odd, size) = around.even_and_odd(&q).expect("few modes");
                let signed: Vec<_> = q.iter().map(|(k, q)| (*k, sign * q)).collect();
                let (sum, terms) = around.normal(&signed);
                let off = (even + sign * odd - sum).length();
                assert!(off <= 1e-14 * size, "{modes} modes: {off}");
                assert!(terms <= size * (1.0 + 1e-12), "{modes} modes: {terms}");
            }
        }
        let mut around = Around {
            rest: vec![[DVec3::X, DVec3::Y]],
            moved: vec![[DVec3::Z; 2]; SECOND_ORDER_MODES + 1],
            ..Default::default()
        };
        around.expand(&[1.0; SECOND_ORDER_MODES + 1]);
        assert!(around.even_and_odd(&[(0, 1.0)]).is_none());
    }
}
