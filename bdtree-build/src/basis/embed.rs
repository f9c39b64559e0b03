//! Points that follow a volume: each is a weighted mean of the nodes of the element it lies in.

mod boxes;
mod face;
mod hexahedron;
mod tetrahedron;

use crate::elastic::vec3::{norm, sub};
use crate::error::{BakeError, Problem};
use crate::input::volume::{Face, RawVolume, boundary};
use boxes::{Aabb, BoxTree};

/// Points no farther outside, over the box diagonal, are not worth a warning: the rounding of
/// coordinates in text or f32.
const ROUNDED: f64 = 1e-6;

/// Weights, and distances from the ends of the unit cube, that are nothing but rounding.
const SMALLEST: f64 = 4.0 * f64::EPSILON;

/// Most problems that are listed one by one.
const PROBLEM_CAP: usize = 100;

/// For each point the nodes it follows, with weights in [0, 1] that add up to 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Embedding {
    /// Number of nodes of the volume.
    pub node_count: usize,
    /// Node and weight, point after point.
    entries: Vec<(u32, f64)>,
    /// Where the entries of each point begin, and where the last ones end.
    starts: Vec<usize>,
    /// Points that lie outside of all elements, by more than rounding.
    pub outside: usize,
    /// The point farthest outside, and its distance over the diagonal of the box around the nodes.
    pub farthest: Option<(usize, f64)>,
}

impl Embedding {
    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The nodes that point `i` follows and their weights: at most eight, none of them zero.
    pub fn weights(&self, i: usize) -> &[(u32, f64)] {
        match (self.starts.get(i), self.starts.get(i + 1)) {
            (Some(&start), Some(&end)) => &self.entries[start..end],
            _ => &[],
        }
    }

    /// Vectors at the points from vectors at the nodes; several fields one after the other, as in
    /// [`super::Basis::fields`].
    ///
    /// What is left over after the last whole field is not looked at.
    pub fn apply(&self, node_fields: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let fields = node_fields.chunks_exact(self.node_count.max(1));
        fields
            .flat_map(|field| (0..self.point_count()).map(|i| self.mean(i, field)))
            .collect()
    }

    fn mean(&self, i: usize, field: &[[f64; 3]]) -> [f64; 3] {
        let mut mean = [0.0; 3];
        for &(node, weight) in self.weights(i) {
            let value = field[node as usize];
            for a in 0..3 {
                mean[a] += weight * value[a];
            }
        }
        mean
    }

    fn push(&mut self, pairs: impl Iterator<Item = (u32, f64)> + Clone) {
        let sum: f64 = pairs.clone().map(|(_, weight)| weight).sum();
        let used = pairs.filter(|&(_, weight)| weight > 0.0);
        self.entries.extend(used.map(|(node, w)| (node, w / sum)));
        self.starts.push(self.entries.len());
    }
}

/// The embedding of `points` in `volume`: barycentric weights in a tetrahedron, trilinear ones in a
/// hexahedron.
///
/// A point that several elements contain follows the one of the lowest index, tetrahedra first. A
/// point outside follows the nearest point of the boundary; a warning counts these and names the
/// farthest. Linear fields are reproduced inside, to rounding.
///
/// # Errors
/// A volume without elements or with nodes that are not finite or not there; points that are not
/// finite (the first 100).
pub fn embed(
    points: &[[f64; 3]],
    volume: &RawVolume,
    warnings: &mut Vec<String>,
) -> Result<Embedding, BakeError> {
    check(points, volume)?;
    let places = Places::new(volume);
    if places.faces.is_empty() {
        let message = "a volume without a boundary";
        return Err(BakeError::one("basis", volume.name.clone(), message));
    }
    let mut embedding = Embedding {
        node_count: volume.nodes.len(),
        starts: vec![0],
        ..Embedding::default()
    };
    for (i, &point) in points.iter().enumerate() {
        if places.contain(point, &mut embedding) {
            continue;
        }
        let distance = places.follow_boundary(point, &mut embedding) / places.diagonal;
        if distance > ROUNDED {
            embedding.outside += 1;
            if embedding.farthest.is_none_or(|(_, most)| distance > most) {
                embedding.farthest = Some((i, distance));
            }
        }
    }
    if let Some((vertex, distance)) = embedding.farthest {
        warnings.push(format!(
            "{}: {} of {} vertices lie outside the volume and follow the nearest point of its \
             boundary; the farthest is vertex {vertex}, {:.2e} box diagonals away",
            volume.name,
            embedding.outside,
            points.len(),
            distance
        ));
    }
    Ok(embedding)
}

/// The largest coordinate there is: distances are known to a few ulps of it.
fn reach(corners: &[[f64; 3]], p: [f64; 3]) -> f64 {
    let all = corners.iter().flatten().chain(&p);
    all.fold(0.0_f64, |m, x| m.max(x.abs()))
}

/// What [`embed`] refuses.
fn check(points: &[[f64; 3]], volume: &RawVolume) -> Result<(), BakeError> {
    let refuse = |message: &str| Err(BakeError::one("basis", volume.name.clone(), message));
    let corners = volume.tetrahedra.iter().flatten();
    let mut corners = corners.chain(volume.hexahedra.iter().flatten()).peekable();
    if corners.peek().is_none() {
        return refuse("a volume without elements");
    }
    if corners.any(|&corner| corner as usize >= volume.nodes.len()) {
        return refuse("elements refer to nodes that are not there");
    }
    let is_finite = |p: &[f64; 3]| p.iter().all(|x| x.is_finite());
    if !volume.nodes.iter().all(is_finite) {
        return refuse("nodes are not finite");
    }
    let problems: Vec<Problem> = points
        .iter()
        .enumerate()
        .filter(|(_, point)| !is_finite(point))
        .take(PROBLEM_CAP)
        .map(|(i, point)| Problem {
            stage: "basis",
            place: format!("vertex {i}"),
            message: format!("position {point:?} is not finite"),
        })
        .collect();
    if problems.is_empty() {
        Ok(())
    } else {
        Err(BakeError { problems })
    }
}

/// A volume with trees over its elements and the faces of its boundary.
struct Places<'v> {
    volume: &'v RawVolume,
    elements: BoxTree,
    faces: Vec<Face>,
    face_tree: BoxTree,
    /// How far rounding may carry a point out of the box of its element.
    slack: f64,
    /// Of the box around all nodes.
    diagonal: f64,
}

/// The nodes of the element that contains a point, and their weights.
enum Inside {
    Tetrahedron([f64; 4]),
    Hexahedron([f64; 8]),
}

impl<'v> Places<'v> {
    fn new(volume: &'v RawVolume) -> Self {
        let around = |nodes: &[u32]| Aabb::around(nodes.iter().map(|&n| volume.nodes[n as usize]));
        let tetrahedra = volume.tetrahedra.iter().map(|corners| around(corners));
        let hexahedra = volume.hexahedra.iter().map(|corners| around(corners));
        let boxes: Vec<Aabb> = tetrahedra.chain(hexahedra).collect();
        let faces = boundary(volume).faces;
        let face_boxes: Vec<Aabb> = faces.iter().map(|face| around(face.nodes())).collect();
        let all = Aabb::around(volume.nodes.iter().copied());
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
    fn contain(&self, point: [f64; 3], embedding: &mut Embedding) -> bool {
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
    fn follow_boundary(&self, point: [f64; 3], embedding: &mut Embedding) -> f64 {
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
