//! Which element of a volume a point lies in, and which face of the boundary it is nearest to.

use super::boxes::{Aabb, BoxTree};
use super::{Embedding, face, hexahedron, reach, tetrahedron};
use crate::input::volume::{Face, RawVolume, boundary};
use crate::vec3::{norm, sub};

/// A volume with trees over its elements and the faces of its boundary.
pub(super) struct Places<'v> {
    volume: &'v RawVolume,
    elements: BoxTree,
    /// Of the boundary.
    pub(super) faces: Vec<Face>,
    face_tree: BoxTree,
    /// How far rounding may carry a point out of the box of its element.
    slack: f64,
    /// Of the box around all elements.
    pub(super) diagonal: f64,
}

/// The nodes of the element that contains a point, and their weights.
enum Inside {
    Tetrahedron([f64; 4]),
    Hexahedron([f64; 8]),
}

impl<'v> Places<'v> {
    pub(super) fn new(volume: &'v RawVolume) -> Self {
        let around = |nodes: &[u32]| Aabb::around(nodes.iter().map(|&n| volume.nodes[n as usize]));
        let tetrahedra = volume.tetrahedra.iter().map(|corners| around(corners));
        let hexahedra = volume.hexahedra.iter().map(|corners| around(corners));
        let boxes: Vec<Aabb> = tetrahedra.chain(hexahedra).collect();
        let faces = boundary(volume).faces;
        let face_boxes: Vec<Aabb> = faces.iter().map(|face| around(face.nodes())).collect();
        let all = boxes.iter().fold(Aabb::EMPTY, |all, item| all.with(item));
        Self {
            volume,
            elements: BoxTree::new(&boxes),
            faces,
            face_tree: BoxTree::new(&face_boxes),
            slack: 256.0 * f64::EPSILON * reach(&[all.low, all.high], [0.0; 3]),
            diagonal: norm(sub(all.high, all.low)),
        }
    }

    fn corners<const N: usize>(&self, nodes: &[u32; N]) -> [[f64; 3]; N] {
        nodes.map(|node| self.volume.nodes[node as usize])
    }

    /// Adds the weights of the lowest element that contains `point`; false if none does.
    pub(super) fn contain(&self, point: [f64; 3], embedding: &mut Embedding) -> bool {
        let (tetrahedra, hexahedra) = (&self.volume.tetrahedra, &self.volume.hexahedra);
        let mut best: Option<(usize, Inside)> = None;
        self.elements.containing(point, self.slack, |element| {
            let element = element as usize;
            if best.as_ref().is_some_and(|&(lowest, _)| lowest <= element) {
                return;
            }
            let inside = match tetrahedra.get(element) {
                Some(nodes) => {
                    tetrahedron::weights(&self.corners(nodes), point).map(Inside::Tetrahedron)
                }
                None => hexahedron::weights(
                    &self.corners(&hexahedra[element - tetrahedra.len()]),
                    point,
                )
                .map(Inside::Hexahedron),
            };
            if let Some(inside) = inside {
                best = Some((element, inside));
            }
        });
        match best {
            None => return false,
            Some((element, Inside::Tetrahedron(weights))) => {
                embedding.push(tetrahedra[element].into_iter().zip(weights));
            }
            Some((element, Inside::Hexahedron(weights))) => {
                let nodes = hexahedra[element - tetrahedra.len()];
                embedding.push(nodes.into_iter().zip(weights));
            }
        }
        true
    }

    /// Adds the weights of the point of the boundary nearest to `point`; the distance.
    pub(super) fn follow_boundary(&self, point: [f64; 3], embedding: &mut Embedding) -> f64 {
        let nearest = |face: u32| {
            let nodes = self.faces[face as usize].corners;
            match nodes {
                [a, b, c, Face::NONE] => {
                    let (weights, square) = face::triangle(self.corners(&[a, b, c]), point);
                    ([weights[0], weights[1], weights[2], 0.0], square)
                }
                _ => face::quadrilateral(self.corners(&nodes), point),
            }
        };
        // There are faces: `embed` refuses a volume without.
        let found = self.face_tree.nearest(point, |face| nearest(face).1);
        let (face, square) = found.unwrap_or_default();
        let nodes = self.faces[face as usize].corners;
        embedding.push(nodes.into_iter().zip(nearest(face).0));
        square.sqrt()
    }
}
