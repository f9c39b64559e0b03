//! The product's ball of some vertices, in exact numbers: the formulas of docs/design/guarantees.md in f64, without slack.

use bdtree_build::wrap::ball::smallest_ball;
use nalgebra::Vector3;

/// One mode's numbers.
#[derive(Debug, Clone, Copy)]
struct Mode {
    /// Ū_j, the center of the displacements' smallest ball.
    center: Vector3<f64>,
    /// ΔR_j.
    growth: f64,
    /// b⁺_j, b⁻_j.
    cross: [f64; 2],
}

/// The numbers of a ball that follows q.
#[derive(Debug, Clone)]
pub struct Sphere {
    center: Vector3<f64>,
    /// R.
    pub radius: f64,
    modes: Vec<Mode>,
}

impl Sphere {
    /// The numbers of some vertices: their places at rest, and for every mode their displacements.
    pub fn around(
        points: &[Vector3<f64>],
        fields: impl Iterator<Item = Vec<Vector3<f64>>>,
    ) -> Self {
        let center = center(points);
        let arms: Vec<_> = points.iter().map(|p| p - center).collect();
        let radius = farthest(&arms);
        Self {
            center,
            radius,
            modes: fields.map(|field| mode(&arms, radius, &field)).collect(),
        }
    }

    /// c'(q) and R'(q) = √(R² + 2 Σ b|q| + s²).
    pub fn at(&self, q: &[f64]) -> ([f64; 3], f64) {
        let mut center = self.center;
        let (mut sum, mut cross) = (0.0, 0.0);
        for (mode, q) in self.modes.iter().zip(q) {
            center += mode.center * *q;
            sum += mode.growth * q.abs();
            cross += mode.cross[usize::from(*q < 0.0)] * q.abs();
        }
        let square = self.radius * self.radius + 2.0 * cross + sum * sum;
        (center.into(), square.max(0.0).sqrt())
    }

    /// ΔR_j.
    pub fn growth_of(&self, mode: usize) -> f64 {
        self.modes[mode].growth
    }

    /// ‖ΔR‖₂.
    pub fn growth_norm(&self) -> f64 {
        let squares = self.modes.iter().map(|mode| mode.growth * mode.growth);
        squares.sum::<f64>().sqrt()
    }
}

/// That of the smallest ball around points.
fn center(points: &[Vector3<f64>]) -> Vector3<f64> {
    let points: Vec<[f64; 3]> = points.iter().map(|p| (*p).into()).collect();
    smallest_ball(&points).center.into()
}

fn farthest(arms: &[Vector3<f64>]) -> f64 {
    arms.iter().map(Vector3::norm).fold(0.0, f64::max)
}

/// Ū, ΔR and b±.
fn mode(arms: &[Vector3<f64>], radius: f64, field: &[Vector3<f64>]) -> Mode {
    let center = center(field);
    let spread: Vec<_> = field.iter().map(|u| u - center).collect();
    let growth = farthest(&spread);
    let mut cross = [f64::NEG_INFINITY; 2];
    for (x, w) in arms.iter().zip(&spread) {
        let depth = radius * radius - x.norm_squared();
        let excess = growth * growth - w.norm_squared();
        // Rounding may leave the farthest arm a little outside.
        let root = (depth.max(0.0) * excess.max(0.0)).sqrt();
        let product = x.dot(w);
        cross = [cross[0].max(product - root), cross[1].max(-product - root)];
    }
    Mode {
        center,
        growth,
        cross,
    }
}
