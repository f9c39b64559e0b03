//! Convex pieces of a triangle, in weights of its corners (Sutherland and Hodgman, 1974).
//!
//! A function that is linear on the triangle is given by its values at the corners. Every vertex
//! of a piece is a convex combination of corners, whatever is lost in rounding.

use crate::math::dot;

/// A convex polygon in a triangle, of at most `N` vertices.
#[derive(Clone, Copy)]
pub(super) struct Polygon<const N: usize> {
    vertices: [[f64; 3]; N],
    len: usize,
}

impl<const N: usize> Polygon<N> {
    /// The whole triangle; N is at least 3.
    pub(super) fn triangle() -> Self {
        let mut vertices = [[0.0; 3]; N];
        for (k, vertex) in vertices.iter_mut().take(3).enumerate() {
            vertex[k] = 1.0;
        }
        Self {
            vertices,
            len: N.min(3),
        }
    }

    /// Weights of the corners, vertex by vertex.
    pub(super) fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices[..self.len]
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The part where a linear function is not negative; nothing where it would have more than
    /// `N` vertices.
    ///
    /// A cut lies off by rounding: at its vertices the function is at most 8 u times its largest
    /// magnitude at the corners from where it should be.
    pub(super) fn clipped(&self, at_corners: [f64; 3]) -> Option<Self> {
        let mut out = Self {
            vertices: [[0.0; 3]; N],
            len: 0,
        };
        for (i, &v) in self.vertices().iter().enumerate() {
            let w = self.vertices[if i + 1 == self.len { 0 } else { i + 1 }];
            let (at_v, at_w) = (dot(v, at_corners), dot(w, at_corners));
            if at_v >= 0.0 {
                out.push(v)?;
            }
            if (at_v < 0.0 && at_w > 0.0) || (at_v > 0.0 && at_w < 0.0) {
                let s = at_v / (at_v - at_w);
                out.push([0, 1, 2].map(|k| (1.0 - s) * v[k] + s * w[k]))?;
            }
        }
        Some(out)
    }

    fn push(&mut self, vertex: [f64; 3]) -> Option<()> {
        *self.vertices.get_mut(self.len)? = vertex;
        self.len += 1;
        Some(())
    }
}
