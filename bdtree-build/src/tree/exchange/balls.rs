//! Balls around triangles.

use crate::tree::Met;
use crate::vec3::{norm2, sub};
use crate::wrap::ball::smallest_ball;

/// A ball, by the square of its radius.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Ball {
    pub(super) center: [f64; 3],
    pub(super) square: f64,
}

impl Ball {
    /// Around nothing: to [`Ball::least_of_both`] any other ball is the larger one.
    pub(super) const EMPTY: Self = Self {
        center: [0.0; 3],
        square: f64::NEG_INFINITY,
    };

    /// No ball around what these two are the smallest ones around has a smaller square: about z the points
    /// of a smallest ball (c, r) need a square of at least r² + ‖z − c‖².
    pub(super) fn least_of_both(&self, other: &Self) -> f64 {
        let apart = norm2(sub(self.center, other.center));
        // On the line through the centers, where both demand the same.
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
        let rest = norm2(sub(self.center, other.center)) - self.square - other.square;
        rest <= 0.0 || rest * rest <= 4.0 * self.square * other.square
    }

    pub(super) fn holds(&self, point: [f64; 3]) -> bool {
        norm2(sub(point, self.center)) <= self.square
    }
}

/// The triangles.
#[derive(Debug, Clone, Copy)]
pub(in crate::tree) struct Mesh<'t> {
    pub(in crate::tree) positions: &'t [[f32; 3]],
    pub(in crate::tree) corners: &'t [[u32; 3]],
}

/// Memory for the vertices of some triangles.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    ids: Vec<u32>,
    points: Vec<[f64; 3]>,
    /// Empty until a large set comes.
    met: Met,
}

/// Up to this many triangles their vertices are compared with each other.
const COMPARED_MAX: usize = 32;

impl Mesh<'_> {
    fn position(&self, vertex: u32) -> [f64; 3] {
        self.positions[vertex as usize].map(f64::from)
    }

    pub(super) fn corners(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.corners[triangle as usize].map(|i| self.position(i))
    }

    /// The smallest ball around some triangles; [`Ball::EMPTY`] around none. Each vertex is looked at once, in the
    /// order of first use, on which the last bits depend.
    pub(super) fn ball(&self, triangles: &[u32], vertices: &mut Vertices) -> Ball {
        if triangles.is_empty() {
            return Ball::EMPTY;
        }
        let Vertices { ids, points, met } = vertices;
        points.clear();
        let corners = triangles.iter().flat_map(|&t| self.corners[t as usize]);
        if triangles.len() <= COMPARED_MAX {
            ids.clear();
            for vertex in corners {
                if !ids.contains(&vertex) {
                    ids.push(vertex);
                    points.push(self.position(vertex));
                }
            }
        } else {
            let vertices = met.once(self.positions.len(), corners);
            points.extend(vertices.map(|vertex| self.position(vertex)));
        }
        let ball = smallest_ball(points);
        Ball {
            center: ball.center,
            square: ball.radius * ball.radius,
        }
    }
}
