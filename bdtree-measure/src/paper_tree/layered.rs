//! The layered hierarchy that the paper compares with: all vertices are deformed and every sphere is
//! made anew from its two children's, leaves first.

use super::PaperTree;
use super::walk::Spheres;
use crate::Place;
use crate::place::matrix;

/// Spheres of all nodes at the current step.
#[derive(Debug, Clone)]
pub struct Layered {
    spheres: Vec<[f32; 4]>,
    /// x, y, z of all vertices in the body's frame.
    pub vertices: Vec<f32>,
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl Layered {
    /// Room for a tree's nodes and `numbers` numbers of vertices.
    pub fn new(tree: &PaperTree, numbers: usize) -> Self {
        Self {
            spheres: vec![[0.0; 4]; tree.node_count()],
            vertices: vec![0.0; numbers],
            rotation: matrix(Place::IDENTITY.rotation),
            translation: [0.0; 3],
        }
    }

    /// Makes all spheres from the vertices, children before parents.
    pub fn refit(&mut self, tree: &PaperTree, place: &Place) {
        self.rotation = matrix(place.rotation);
        self.translation = place.translation;
        for node in (0..tree.links.len()).rev() {
            let link = tree.links[node];
            self.spheres[node] = match link.triangle() {
                Some(id) => around_triangle(tree.corners[id as usize].map(|v| {
                    let at = 3 * v as usize;
                    [0, 1, 2].map(|k| self.vertices[at + k])
                })),
                None => around_both(self.spheres[node + 1], self.spheres[link.0 as usize]),
            };
        }
    }
}

/// Room for the rounding of a radius and of the distances it is tested with, relative to the sizes
/// in it.
const ROUNDING: f32 = 1.0 + 4e-6;

/// The sphere around the middle of the box of three points.
fn around_triangle(p: [[f32; 3]; 3]) -> [f32; 4] {
    let [x, y, z] = [0, 1, 2].map(|k| {
        let (low, high) = (
            p[0][k].min(p[1][k]).min(p[2][k]),
            p[0][k].max(p[1][k]).max(p[2][k]),
        );
        0.5 * (low + high)
    });
    let squares = p.map(|p| {
        let d = [p[0] - x, p[1] - y, p[2] - z];
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    });
    let radius = squares[0].max(squares[1]).max(squares[2]).sqrt();
    let size = x.abs() + y.abs() + z.abs();
    [x, y, z, radius * ROUNDING + size * (ROUNDING - 1.0)]
}

/// The smallest sphere around two.
fn around_both(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let distance = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    if distance + b[3] <= a[3] {
        return a;
    }
    if distance + a[3] <= b[3] {
        return b;
    }
    let radius = 0.5 * (distance + a[3] + b[3]);
    let share = (radius - a[3]) / distance;
    let c = [0, 1, 2].map(|k| a[k] + share * d[k]);
    [c[0], c[1], c[2], radius * ROUNDING]
}

impl Spheres for Layered {
    #[inline]
    fn sphere(&mut self, _tree: &PaperTree, node: usize) -> [f32; 4] {
        self.spheres[node]
    }

    #[inline]
    fn vertex(&mut self, vertex: u32) -> [f64; 3] {
        let at = 3 * vertex as usize;
        let p = [0, 1, 2].map(|k| f64::from(self.vertices[at + k]));
        [0, 1, 2].map(|i| {
            let row = self.rotation[i];
            row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + self.translation[i]
        })
    }
}
