//! Intervals along directions: boxes, k-DOPs and the slab of a flat piece of surface.

use nalgebra::{Matrix3, Vector3};

use super::affine::axes_of;
use super::body::Body;
use super::shape::Slab;

/// Middle and half length.
#[derive(Debug, Clone, Copy, Default)]
struct Interval {
    middle: f64,
    half: f64,
}

impl Interval {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        Self {
            middle: 0.5 * (low + high),
            half: 0.5 * (high - low),
        }
    }
}

/// The numbers of one direction: an interval at rest and one for each mode.
#[derive(Debug, Clone)]
pub struct Direction {
    /// n.
    pub normal: Vector3<f64>,
    rest: Interval,
    modes: Vec<Interval>,
}

impl Direction {
    /// The intervals of n·p_i and n·U_ij below a lane.
    pub fn wrap(body: &Body, lane: usize, normal: Vector3<f64>) -> Self {
        let of = |points: Vec<Vector3<f64>>| Interval::of(points.iter().map(|p| normal.dot(p)));
        Self {
            normal,
            rest: of(body.rest(lane)),
            modes: (0..body.mode_count())
                .map(|j| of(body.field(lane, j)))
                .collect(),
        }
    }

    /// The slab along n at a pose: middle m + Σ m_j q_j, half h + Σ h_j|q_j|.
    pub fn at(&self, q: &[f64]) -> Slab {
        let mut now = self.rest;
        for (mode, q) in self.modes.iter().zip(q) {
            now.middle += mode.middle * q;
            now.half += mode.half * q.abs();
        }
        Slab {
            normal: self.normal,
            middle: now.middle,
            half: now.half,
        }
    }
}

/// A slab about the lane's moving centre whose normal follows the surface: n'(q) = n + Σ ν_j q_j.
///
/// n'·(p' − c') = n·x + Σ (n·w_j + ν_j·x) q_j + (Σ ν_j q_j)·(Σ w_j q_j); ν_j makes the middle
/// part small where the surface turns, the last part is at most ‖Σ ν_j q_j‖ s.
#[derive(Debug, Clone)]
pub struct TurningSlab {
    direction: Direction,
    turns: Vec<Vector3<f64>>,
}

impl TurningSlab {
    /// The numbers of a lane whose ball has the centre `centre` at rest and Ū `centres`.
    pub fn wrap(
        body: &Body,
        lane: usize,
        normal: Vector3<f64>,
        (centre, centres): (Vector3<f64>, Vec<Vector3<f64>>),
    ) -> Self {
        let arms: Vec<_> = body.rest(lane).iter().map(|p| p - centre).collect();
        // n·w + ν·x is fitted over tangential ν, a constant beside it.
        let mean = arms.iter().sum::<Vector3<f64>>() / arms.len().max(1) as f64;
        let flat = |x: &Vector3<f64>| x - normal * normal.dot(x);
        let mut matrix = normal * normal.transpose();
        let scale = arms.iter().map(Vector3::norm_squared).sum::<f64>() + f64::MIN_POSITIVE;
        matrix *= scale;
        for x in &arms {
            let x = flat(&(x - mean));
            matrix += x * x.transpose();
        }
        matrix += Matrix3::identity() * (1e-9 * scale);
        let inverse = matrix.try_inverse().unwrap_or_default();
        let (mut turns, mut modes) = (Vec::new(), Vec::new());
        for (j, middle) in centres.iter().enumerate() {
            let along: Vec<f64> = body
                .field(lane, j)
                .iter()
                .map(|u| normal.dot(&(u - middle)))
                .collect();
            let mut right = Vector3::zeros();
            for (x, w) in arms.iter().zip(&along) {
                right -= flat(&(x - mean)) * *w;
            }
            let turn = flat(&(inverse * right));
            modes.push(Interval::of(
                arms.iter().zip(&along).map(|(x, w)| w + turn.dot(x)),
            ));
            turns.push(turn);
        }
        Self {
            direction: Direction {
                normal,
                rest: Interval::of(arms.iter().map(|x| normal.dot(x))),
                modes,
            },
            turns,
        }
    }

    /// The slab at a pose, where the ball's centre is `centre` and s is `spread`.
    pub fn at(&self, q: &[f64], centre: Vector3<f64>, spread: f64) -> Slab {
        let mut slab = self.direction.at(q);
        let turn: Vector3<f64> = self.turns.iter().zip(q).map(|(n, q)| n * *q).sum();
        slab.normal += turn;
        slab.middle += slab.normal.dot(&centre);
        slab.half += turn.norm() * spread;
        slab
    }
}

/// Principal axes of a lane's rest vertices as columns, the thinnest direction last.
pub fn principal_axes(body: &Body, lane: usize) -> Matrix3<f64> {
    let points = body.rest(lane);
    let mean = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let mut matrix = Matrix3::zeros();
    for p in &points {
        matrix += (p - mean) * (p - mean).transpose();
    }
    axes_of(matrix)
}

/// Unit directions of a k-DOP: the three axes, then the four diagonals of the cube (7), then
/// the six of its sides (13).
pub fn dop_directions(count: usize) -> Vec<Vector3<f64>> {
    const ALL: [[f64; 3]; 13] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [1.0, -1.0, 1.0],
        [-1.0, 1.0, 1.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [1.0, -1.0, 0.0],
        [1.0, 0.0, -1.0],
        [0.0, 1.0, -1.0],
    ];
    let directions = ALL.iter().take(count);
    directions.map(|n| Vector3::from(*n).normalize()).collect()
}
