//! Balls whose radius takes the displacements below a node for a polynomial and a rest.
//!
//! Let U_j(y) be a polynomial of first or second degree, x_i the arms about the centre, and Ū_j the
//! polynomial there and a shift. Then p'_i − c'(q) = F x_i + s_i + Σ r_ij q_j, where F = 1 + Σ ∇U_j q_j
//! at the centre, s_i is what second derivatives add less the shift, and r_ij what the polynomials
//! leave. Therefore R' ≤ max_i ‖F x_i‖ + max_i ‖s_i‖ + Σ ρ_j|q_j| with ρ_j = max_i ‖r_ij‖: modes are
//! summed before a norm is taken, so that what one of them adds another takes away again.
//! ‖F x‖² = xᵀMx with M = FᵀF. The polynomials may be the node's, the same for its eight lanes.

use bdtree_format::LANES;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::body::Body;
use super::shape::Ball;
use super::sphere::{enclosing, farthest};

/// A ball over a polynomial field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Affine {
    /// Whether the eight lanes of a node have the same polynomials and axes.
    pub shared: bool,
    /// Whether gradients are zero along the thinnest direction.
    pub tangent: bool,
    /// Whether the field has second derivatives in the plane, too.
    pub bent: bool,
    /// Whether Ū follows from the node's field.
    pub placed: bool,
    /// How ‖F x_i‖ is bounded.
    pub stretch: Stretch,
}

/// How max ‖F x_i‖ is bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stretch {
    /// σ_max(F) R.
    Norm,
    /// The larger singular value of F in the plane of the lane, and its thickness.
    Flat,
    /// The smaller of `Flat` and the sum of the parts of M, each times how far the lane goes along it.
    Parts,
    /// This many of the farthest vertices themselves, the others by `Flat`.
    Points(usize),
}

impl Affine {
    /// Whether the polynomial has nothing of this one of [`features`].
    fn leaves_out(self, feature: usize) -> bool {
        self.tangent && feature == 2 || !self.bent && feature > 2
    }

    /// Numbers per lane with M modes; a node's field counted by its eighth.
    pub fn numbers(self, m: usize) -> usize {
        let stretch = match self.stretch {
            Stretch::Norm => 0,
            Stretch::Flat => 2,
            Stretch::Parts => 12,
            Stretch::Points(count) => 3 + 3 * count,
        };
        let bent = if self.bent { 4 } else { 0 };
        let placed = match (self.placed, self.bent) {
            (false, _) => 0,
            (true, false) => 3,
            (true, true) => 4,
        };
        4 + stretch + bent + placed + (self.rows_per_mode() * m as f64).ceil() as usize
    }

    /// Operations on eight lanes after an update's rows, counted by hand.
    pub fn operations(self) -> usize {
        // M and its eigenvalues are the node's, unless each lane has an F of its own.
        let own = self.bent || !self.shared;
        let flat = if own { 20 } else { 5 };
        let stretch = match self.stretch {
            Stretch::Norm => 2,
            Stretch::Flat => flat,
            Stretch::Parts => flat + if own { 25 } else { 12 },
            Stretch::Points(count) => flat + 12 * count,
        };
        let square = if own { 18 } else { 0 };
        let bent = if self.bent { 16 } else { 0 };
        let placed = match (self.placed, self.bent) {
            (false, _) => 0,
            (true, false) => 9,
            (true, true) => 18,
        };
        stretch + square + bent + placed
    }

    /// Rows of eight that an update multiplies by q_j and adds, for each mode.
    pub fn rows_per_mode(self) -> f64 {
        let mut numbers = if self.tangent { 6.0 } else { 9.0 };
        if self.bent {
            numbers += 9.0;
        }
        if self.placed {
            numbers += 3.0;
        }
        numbers / if self.shared { LANES as f64 } else { 1.0 } + if self.placed { 1.0 } else { 4.0 }
    }
}

/// 3 × 6: what a field is of (a, b, h, a², ab, b²).
type Field = SMatrix<f64, 3, 6>;
type Features = SVector<f64, 6>;

fn features(x: &Vector3<f64>) -> Features {
    Features::from([x.x, x.y, x.z, x.x * x.x, x.x * x.y, x.y * x.y])
}

/// All modes as fields U_j(y) = u_j + C_j φ(y), in axes of their own, the thinnest direction last.
#[derive(Debug, Clone)]
pub struct Fields {
    axes: Matrix3<f64>,
    /// Where y is 0.
    origin: Vector3<f64>,
    modes: Vec<(Vector3<f64>, Field)>,
}

impl Fields {
    /// Least squares, with one constant for all lanes where the centres follow and else with one for
    /// each.
    pub fn fit(body: &Body, lanes: &[usize], kind: Affine) -> Self {
        let points: Vec<_> = lanes.iter().map(|lane| body.rest(*lane)).collect();
        let all: Vec<_> = points.iter().flatten().copied().collect();
        let origin = mean(&all);
        let mut square = Matrix3::zeros();
        for points in &points {
            let middle = mean(points);
            for p in points {
                square += (p - middle) * (p - middle).transpose();
            }
        }
        let axes = axes_of(square);
        let local = |p: &Vector3<f64>| axes.tr_mul(&(p - origin));
        let bases: Vec<Vec<Features>> = points
            .iter()
            .map(|points| points.iter().map(|p| features(&local(p))).collect())
            .collect();
        let means: Vec<Features> = if kind.placed {
            let one = mean(&bases.concat());
            vec![one; lanes.len()]
        } else {
            bases.iter().map(|bases| mean(bases)).collect()
        };
        let mut matrix = SMatrix::<f64, 6, 6>::zeros();
        for (bases, middle) in bases.iter().zip(&means) {
            for basis in bases {
                matrix += (basis - middle) * (basis - middle).transpose();
            }
        }
        // A flat set leaves the gradient across it open: zero does.
        matrix[(2, 2)] += 1e-3 * (matrix[(0, 0)] + matrix[(1, 1)]);
        for k in 0..6 {
            matrix[(k, k)] += 1e-6 * matrix[(k, k)] + f64::MIN_POSITIVE;
            if kind.leaves_out(k) {
                matrix.row_mut(k).fill(0.0);
                matrix.column_mut(k).fill(0.0);
                matrix[(k, k)] = 1.0;
            }
        }
        let inverse = matrix.try_inverse().unwrap_or_default();
        let modes = (0..body.mode_count()).map(|j| {
            let mut right = Field::zeros();
            let mut values = Vec::new();
            for ((lane, bases), middle) in lanes.iter().zip(&bases).zip(&means) {
                for (u, basis) in body.field(*lane, j).iter().zip(bases) {
                    let u = axes.tr_mul(u);
                    right += u * (basis - middle).transpose();
                    values.push(u);
                }
            }
            for k in 0..6 {
                if kind.leaves_out(k) {
                    right.column_mut(k).fill(0.0);
                }
            }
            let field = right * inverse;
            let constant = mean(&values) - field * mean(&bases.concat());
            (constant, field)
        });
        Self {
            modes: modes.collect(),
            axes,
            origin,
        }
    }

    fn at(&self, q: &[f64]) -> Field {
        let terms = self.modes.iter().zip(q);
        terms.fold(Field::zeros(), |sum, ((_, field), q)| sum + field * *q)
    }
}

/// The numbers of a lane.
#[derive(Debug, Clone)]
pub struct AffineBall {
    kind: Affine,
    /// At rest.
    centre: Vector3<f64>,
    fields: Fields,
    /// The centre's place in the fields' axes.
    place: Vector3<f64>,
    /// Ū_j and ρ_j.
    modes: Vec<(Vector3<f64>, f64)>,
    /// Vertices that are looked at themselves.
    points: Vec<Vector3<f64>>,
    /// R of the others; what follows is about those.
    radius: f64,
    /// H, the largest |h|, and k = max(|h||t| − H √(R² − |x|²)), t the part of x in the plane.
    thick: [f64; 2],
    /// B⁺ and B⁻ of the parts of M.
    parts: [[f64; 5]; 2],
    /// How far a² + b², and (a² − b², 2ab), are from what the centre takes of them.
    bends: [f64; 2],
}

impl AffineBall {
    /// The numbers of a lane.
    pub fn wrap(body: &Body, lane: usize, kind: Affine, fields: &Fields) -> Self {
        let points = body.rest(lane);
        let centre = enclosing(&points).centre;
        let axes = fields.axes;
        let arms: Vec<_> = points.iter().map(|p| axes.tr_mul(&(p - centre))).collect();
        let place = axes.tr_mul(&(centre - fields.origin));
        let (shift, bends) = shift_of(&arms);
        let mut modes = Vec::new();
        for (j, (constant, field)) in fields.modes.iter().enumerate() {
            let own: Vec<_> = body.field(lane, j);
            let own: Vec<_> = own.iter().map(|u| axes.tr_mul(u)).collect();
            let left = own.iter().zip(&arms);
            let left: Vec<_> = left
                .map(|(u, x)| u - field * features(&(place + x)))
                .collect();
            let middle = if kind.placed {
                *constant
            } else {
                enclosing(&left).centre
            };
            let left: Vec<_> = left.iter().map(|u| u - middle).collect();
            let middle = middle + field * (features(&place) + shift);
            modes.push((axes * middle, farthest(&left)));
        }
        let mut points = arms;
        points.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        let count = match kind.stretch {
            Stretch::Points(count) => count.min(points.len()),
            _ => 0,
        };
        let others = points.split_off(count);
        let radius = farthest(&others);
        let depth = |x: &Vector3<f64>| (radius * radius - x.norm_squared()).max(0.0);
        let thickness = others.iter().map(|x| x.z.abs()).fold(0.0, f64::max);
        let mut skew = 0.0_f64;
        let mut parts = [[f64::NEG_INFINITY; 5]; 2];
        for x in &others {
            skew = skew.max(x.z.abs() * x.xy().norm() - thickness * depth(x).sqrt());
            for (part, along) in parts_of(x).into_iter().enumerate() {
                for (side, along) in [along, -along].into_iter().enumerate() {
                    let reach = along - DEPTH * depth(x);
                    parts[side][part] = parts[side][part].max(reach);
                }
            }
        }
        Self {
            kind,
            centre,
            fields: fields.clone(),
            place,
            modes,
            points,
            radius,
            thick: [thickness, skew],
            parts,
            bends,
        }
    }

    /// c'(q) and R'(q).
    pub fn at(&self, q: &[f64]) -> Ball {
        let mut centre = self.centre;
        let mut left = 0.0;
        for ((middle, rho), q) in self.modes.iter().zip(q) {
            centre += middle * *q;
            left += rho * q.abs();
        }
        let field = self.fields.at(q);
        let column = |k: usize| field.column(k).into_owned();
        let [x, y] = [self.place.x, self.place.y];
        let f = Matrix3::identity()
            + Matrix3::from_columns(&[
                column(0) + column(3) * (2.0 * x) + column(4) * y,
                column(1) + column(4) * x + column(5) * (2.0 * y),
                column(2),
            ]);
        let m = f.tr_mul(&f);
        let square = match self.kind.stretch {
            Stretch::Norm => m.symmetric_eigenvalues().max() * self.radius * self.radius,
            Stretch::Flat => self.flat(&m),
            Stretch::Parts => self.flat(&m).min(self.by_parts(&m)),
            Stretch::Points(_) => {
                let lengths = self.points.iter().map(|x| (f * x).norm_squared());
                lengths.fold(self.flat(&m), f64::max)
            }
        };
        let even = 0.5 * (column(3) + column(5)).norm();
        let odd = 0.5 * (column(3) - column(5)).norm().hypot(column(4).norm());
        let bend = even * self.bends[0] + odd * self.bends[1];
        let radius = square.max(0.0).sqrt() + left + bend;
        Ball { centre, radius }
    }

    /// With x = (t, h), λ² the larger eigenvalue of M in the plane, m its mixed and μ its last part:
    /// xᵀMx ≤ λ²t² + 2‖m‖|ht| + μh² = λ²(R² − d) + 2‖m‖|ht| + (μ − λ²)h² with the depth
    /// d = R² − |x|², and 2‖m‖|ht| ≤ 2‖m‖k + 2‖m‖H√d ≤ 2‖m‖k + λ²d + ‖m‖²H²/λ².
    fn flat(&self, m: &Matrix3<f64>) -> f64 {
        let (mean, turn) = (0.5 * (m.m11 + m.m22), 0.5 * (m.m11 - m.m22));
        let along = mean + turn.hypot(m.m12);
        let mixed = m.m13.hypot(m.m23);
        let [thickness, skew] = self.thick;
        // M has no negative eigenvalue: ‖m‖² ≤ λ²μ.
        let bend = (mixed * mixed / along.max(f64::MIN_POSITIVE)).min(m.m33);
        along * self.radius * self.radius
            + 2.0 * mixed * skew
            + (bend + (m.m33 - along).max(0.0)) * thickness * thickness
    }

    /// With e = (M₁₁ + M₂₂)/2: xᵀMx = e|x|² + Σ c_k X_k(x) = e(R² − d) + Σ c_k X_k, where
    /// ±X_k ≤ B±_k + d/2; what is left of d counts where Σ|c_k|/2 is above e, and d ≤ R².
    fn by_parts(&self, m: &Matrix3<f64>) -> f64 {
        let mean = 0.5 * (m.m11 + m.m22);
        let factors = [0.5 * (m.m11 - m.m22), m.m12, m.m13, m.m23, m.m33 - mean];
        let (mut sum, mut weight) = (0.0, 0.0);
        for (k, factor) in factors.into_iter().enumerate() {
            sum += factor.abs() * self.parts[usize::from(factor < 0.0)][k];
            weight += DEPTH * factor.abs();
        }
        (mean + (weight - mean).max(0.0)) * self.radius * self.radius + sum
    }
}

/// How much of a vertex's depth below the sphere each part of M takes.
const DEPTH: f64 = 0.5;

/// What M's parts besides the mean in the plane are multiplied with in xᵀMx.
fn parts_of(x: &Vector3<f64>) -> [f64; 5] {
    [
        x.x * x.x - x.y * x.y,
        2.0 * x.x * x.y,
        2.0 * x.x * x.z,
        2.0 * x.y * x.z,
        x.z * x.z,
    ]
}

fn mean<const N: usize>(all: &[SVector<f64, N>]) -> SVector<f64, N> {
    all.iter().sum::<SVector<f64, N>>() / all.len().max(1) as f64
}

/// The middles of a², ab and b², and how far (a² + b²) and (a² − b², 2ab) go from them.
fn shift_of(arms: &[Vector3<f64>]) -> (Features, [f64; 2]) {
    let split = |x: &Vector3<f64>| {
        let [p, q] = [x.x * x.x, x.y * x.y];
        Vector3::new(p - q, 2.0 * x.x * x.y, p + q)
    };
    let all: Vec<_> = arms.iter().map(split).collect();
    let first = all.first().copied().unwrap_or_default();
    let (low, high) = all
        .iter()
        .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = (low + high) * 0.5;
    let mut shift = Features::zeros();
    shift[3] = 0.5 * (middle.z + middle.x);
    shift[4] = 0.5 * middle.y;
    shift[5] = 0.5 * (middle.z - middle.x);
    let odd = all.iter().map(|p| (p - middle).xy().norm());
    (shift, [0.5 * (high.z - low.z), odd.fold(0.0, f64::max)])
}

/// Right-handed eigenvectors as columns, the smallest eigenvalue's last.
pub(super) fn axes_of(matrix: Matrix3<f64>) -> Matrix3<f64> {
    let eigen = matrix.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let first = eigen.eigenvectors.column(order[0]).normalize();
    let second = eigen.eigenvectors.column(order[1]).into_owned();
    let second = (second - first * first.dot(&second)).normalize();
    Matrix3::from_columns(&[first, second, first.cross(&second)])
}
