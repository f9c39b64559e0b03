//! Balls around a lane's vertices: the paper's, the product's, and others.

use bdtree_build::wrap::ball::smallest_ball;
use nalgebra::{Matrix3, Vector3};

use super::body::Body;
use super::shape::Ball;

/// How R' follows from q.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Growth {
    /// R + s, Ū the mean (the paper's eq. 7).
    Mean,
    /// R + s, Ū the centre of the displacements' smallest ball.
    Sum,
    /// √(R² + 2 Σ b|q| + s²), the product's bound (docs/guarantees.md), Ū as in `Sum`.
    SecondOrder,
    /// R √((1 + s·q)² + ‖Σ ω_j q_j‖²) + Σ ρ_j|q_j|: displacements taken as a scaling and a
    /// turn about the centre, and the rest.
    Similarity,
}

/// One mode's numbers.
#[derive(Debug, Clone, Copy)]
struct Mode {
    /// Ū_j.
    centre: Vector3<f64>,
    /// ΔR_j, or ρ_j.
    growth: f64,
    /// b⁺_j, b⁻_j.
    cross: [f64; 2],
    /// s_j and ω_j.
    scale: f64,
    turn: Vector3<f64>,
}

/// The numbers of a lane's ball.
#[derive(Debug, Clone)]
pub struct Sphere {
    growth: Growth,
    rest: Ball,
    modes: Vec<Mode>,
}

impl Sphere {
    /// The numbers of a lane.
    pub fn wrap(body: &Body, lane: usize, growth: Growth) -> Self {
        let fields = (0..body.mode_count()).map(|j| body.field(lane, j));
        Self::around(&body.rest(lane), fields, growth)
    }

    /// The numbers of some vertices: their places at rest, and for every mode their displacements.
    pub fn around(
        points: &[Vector3<f64>],
        fields: impl Iterator<Item = Vec<Vector3<f64>>>,
        growth: Growth,
    ) -> Self {
        let centre = enclosing(points).centre;
        let arms: Vec<_> = points.iter().map(|p| p - centre).collect();
        let radius = farthest(&arms);
        let inertia = Inertia::new(&arms);
        let modes = fields.map(|field| match growth {
            Growth::Similarity => inertia.mode(&arms, &field),
            _ => mode(&arms, radius, &field, growth == Growth::Mean),
        });
        Self {
            growth,
            rest: Ball { centre, radius },
            modes: modes.collect(),
        }
    }

    /// c'(q) and R'(q).
    pub fn at(&self, q: &[f64]) -> Ball {
        let radius = self.rest.radius;
        let mut centre = self.rest.centre;
        let (mut sum, mut cross, mut scale, mut turn) = (0.0, 0.0, 1.0, Vector3::zeros());
        for (mode, q) in self.modes.iter().zip(q) {
            centre += mode.centre * *q;
            sum += mode.growth * q.abs();
            cross += mode.cross[usize::from(*q < 0.0)] * q.abs();
            scale += mode.scale * q;
            turn += mode.turn * *q;
        }
        let radius = match self.growth {
            Growth::Mean | Growth::Sum => radius + sum,
            Growth::SecondOrder => (radius * radius + 2.0 * cross + sum * sum).max(0.0).sqrt(),
            Growth::Similarity => radius * (scale * scale + turn.norm_squared()).sqrt() + sum,
        };
        Ball { centre, radius }
    }

    /// c and all Ū_j.
    pub fn centres(&self) -> (Vector3<f64>, Vec<Vector3<f64>>) {
        let modes = self.modes.iter().map(|mode| mode.centre);
        (self.rest.centre, modes.collect())
    }

    /// c and R.
    pub fn rest(&self) -> Ball {
        self.rest
    }

    /// ΔR_j (of [`Growth::Similarity`] ρ_j).
    pub fn growth_of(&self, mode: usize) -> f64 {
        self.modes[mode].growth
    }

    /// ‖ΔR‖₂.
    pub fn growth_norm(&self) -> f64 {
        let squares = self.modes.iter().map(|mode| mode.growth * mode.growth);
        squares.sum::<f64>().sqrt()
    }

    /// Σ ΔR_j|q_j|.
    pub fn spread(&self, q: &[f64]) -> f64 {
        let terms = self.modes.iter().zip(q);
        terms.map(|(mode, q)| mode.growth * q.abs()).sum()
    }
}

/// The smallest ball around points.
pub fn enclosing(points: &[Vector3<f64>]) -> Ball {
    let points: Vec<[f64; 3]> = points.iter().map(|p| (*p).into()).collect();
    let ball = smallest_ball(&points);
    Ball {
        centre: ball.centre.into(),
        radius: ball.radius,
    }
}

pub(super) fn farthest(arms: &[Vector3<f64>]) -> f64 {
    arms.iter().map(Vector3::norm).fold(0.0, f64::max)
}

/// Ū, ΔR and b±.
fn mode(arms: &[Vector3<f64>], radius: f64, field: &[Vector3<f64>], mean: bool) -> Mode {
    let centre = if mean {
        field.iter().sum::<Vector3<f64>>() / field.len() as f64
    } else {
        enclosing(field).centre
    };
    let spread: Vec<_> = field.iter().map(|u| u - centre).collect();
    let growth = farthest(&spread);
    let mut cross = [f64::NEG_INFINITY; 2];
    for (x, w) in arms.iter().zip(&spread) {
        let depth = radius * radius - x.norm_squared();
        let excess = growth * growth - w.norm_squared();
        let root = (depth.max(0.0) * excess.max(0.0)).sqrt();
        let product = x.dot(w);
        cross = [cross[0].max(product - root), cross[1].max(-product - root)];
    }
    Mode {
        centre,
        growth,
        cross,
        scale: 0.0,
        turn: Vector3::zeros(),
    }
}

/// Fits scalings and turns.
struct Inertia {
    mean: Vector3<f64>,
    square: f64,
    inverse: Matrix3<f64>,
}

impl Inertia {
    fn new(arms: &[Vector3<f64>]) -> Self {
        let mean = arms.iter().sum::<Vector3<f64>>() / arms.len().max(1) as f64;
        let (mut square, mut matrix) = (0.0, Matrix3::zeros());
        for x in arms {
            let x = x - mean;
            square += x.norm_squared();
            matrix += Matrix3::identity() * x.norm_squared() - x * x.transpose();
        }
        // A set on a line turns about it for nothing: any number does there.
        let small = Matrix3::identity() * (1e-9 * square + f64::MIN_POSITIVE);
        Self {
            mean,
            square: square + f64::MIN_POSITIVE,
            inverse: (matrix + small).try_inverse().unwrap_or_default(),
        }
    }

    /// w ≈ s x + ω × x in the least squares, Ū the centre of what is left.
    fn mode(&self, arms: &[Vector3<f64>], field: &[Vector3<f64>]) -> Mode {
        let middle = field.iter().sum::<Vector3<f64>>() / field.len() as f64;
        let (mut along, mut about) = (0.0, Vector3::zeros());
        for (x, u) in arms.iter().zip(field) {
            along += (x - self.mean).dot(&(u - middle));
            about += (x - self.mean).cross(&(u - middle));
        }
        let (scale, turn) = (along / self.square, self.inverse * about);
        let left: Vec<_> = arms
            .iter()
            .zip(field)
            .map(|(x, u)| u - x * scale - turn.cross(x))
            .collect();
        let centre = enclosing(&left).centre;
        let left: Vec<_> = left.iter().map(|u| u - centre).collect();
        Mode {
            centre,
            growth: farthest(&left),
            cross: [0.0; 2],
            scale,
            turn,
        }
    }
}
