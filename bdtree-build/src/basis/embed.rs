//! Points that follow a volume: each is a weighted mean of the nodes of the element it lies in.

mod boxes;
mod face;
mod hexahedron;
mod places;
mod tetrahedron;

use crate::error::{BakeError, Part, Place, Problems};
use crate::input::volume::RawVolume;
use places::Places;

/// Points no farther outside, over the box diagonal, are not worth a warning: the rounding of
/// coordinates in text or f32.
const ROUNDED: f64 = 1e-6;

/// Weights, and distances from the ends of the unit cube, that are nothing but rounding.
const SMALLEST: f64 = 4.0 * f64::EPSILON;

/// Fourth powers of lengths are numbers up to here.
const LARGEST: f64 = 1e60;

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
    /// The point farthest outside, and its distance over the diagonal of the box around the elements.
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
/// A volume without elements or boundary, or with nodes that are not there, not finite or beyond
/// 1e60; points that are (the first 100).
pub fn embed(
    points: &[[f64; 3]],
    volume: &RawVolume,
    warnings: &mut Vec<String>,
) -> Result<Embedding, BakeError> {
    check(points, volume)?;
    let places = Places::new(volume);
    if places.faces.is_empty() {
        let message = "a volume without a boundary";
        return Err(BakeError::one("basis", Place::file(&volume.name), message));
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
    let refuse = |message: &str| Err(BakeError::one("basis", Place::file(&volume.name), message));
    let corners = volume.tetrahedra.iter().flatten();
    let mut corners = corners.chain(volume.hexahedra.iter().flatten()).peekable();
    if corners.peek().is_none() {
        return refuse("a volume without elements");
    }
    if corners.any(|&corner| corner as usize >= volume.nodes.len()) {
        return refuse("elements refer to nodes that are not there");
    }
    let is_sound = |p: &[f64; 3]| p.iter().all(|x| x.abs() <= LARGEST);
    if !volume.nodes.iter().all(is_sound) {
        return refuse(&format!("nodes are not finite or beyond {LARGEST:e}"));
    }
    let mut problems = Problems::new("basis");
    for (i, point) in points.iter().enumerate().filter(|(_, p)| !is_sound(p)) {
        let message = || format!("position {point:?} is not finite or beyond {LARGEST:e}");
        problems.add(|| (Part::Vertex(i), message()));
    }
    problems.into_result(Place::NOWHERE)
}
