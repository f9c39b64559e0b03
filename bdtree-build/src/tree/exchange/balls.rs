//! Balls around triangles.

use crate::wrap::ball::{norm2, smallest_ball, sub};

/// A ball, by the square of its radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ball {
    pub(super) centre: [f64; 3],
    pub(super) square: f64,
}

impl Ball {
    /// No ball around what these two are the smallest ones around has a smaller square: about z the points
    /// of a smallest ball (c, r) need a square of at least r² + ‖z − c‖².
    pub(super) fn least_of_both(&self, other: &Self) -> f64 {
        let apart = norm2(sub(self.centre, other.centre));
        // On the line through the centres, where both demand the same.
        let along = 0.5 * (apart + other.square - self.square);
        if along <= 0.0 {
            self.square
        } else if along >= apart {
            other.square
        } else {
            self.square + along * along / apart
        }
    }

    pub(super) fn meets(&self, other: &Self) -> bool {
        let rest = norm2(sub(self.centre, other.centre)) - self.square - other.square;
        rest <= 0.0 || rest * rest <= 4.0 * self.square * other.square
    }

    pub(super) fn holds(&self, point: [f64; 3]) -> bool {
        norm2(sub(point, self.centre)) <= self.square
    }
}

/// The triangles, with memory for their points.
pub(super) struct Mesh<'t> {
    pub(super) positions: &'t [[f32; 3]],
    pub(super) corners: &'t [[u32; 3]],
    pub(super) points: Vec<[f64; 3]>,
}

impl Mesh<'_> {
    pub(super) fn corners(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.corners[triangle as usize].map(|i| self.positions[i as usize].map(f64::from))
    }

    pub(super) fn ball(&mut self, triangles: &[u32]) -> Ball {
        self.points.clear();
        for &triangle in triangles {
            let corners = self.corners(triangle);
            self.points.extend(corners);
        }
        let ball = smallest_ball(&self.points);
        Ball {
            centre: ball.centre,
            square: ball.radius * ball.radius,
        }
    }
}
