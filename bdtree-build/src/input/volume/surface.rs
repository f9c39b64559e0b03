//! The boundary of a volume mesh: the faces that have elements on one side only.

use super::RawVolume;
use crate::input::RawMesh;

/// A face of the boundary, seen from outside counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Face {
    /// Its nodes; the fourth is [`Face::NONE`] for a triangle.
    pub(crate) corners: [u32; 4],
}

const NONE: u32 = Face::NONE;

impl Face {
    /// The fourth corner of a triangle. No node: a volume of 2³² nodes is refused.
    pub(crate) const NONE: u32 = u32::MAX;

    /// Three nodes or four.
    pub(crate) fn nodes(&self) -> &[u32] {
        let count = if self.corners[3] == NONE { 3 } else { 4 };
        &self.corners[..count]
    }
}

/// The faces of the boundary, and what is odd about the faces between elements.
#[derive(Debug, Default)]
pub(crate) struct Boundary {
    /// In the order of the elements, tetrahedra first, then of an element's faces.
    pub(crate) faces: Vec<Face>,
    /// Faces of three elements or more.
    pub(crate) crowded: usize,
    /// Faces with two elements or more on the same side.
    pub(crate) overlapping: usize,
}

/// A tetrahedron's faces, outward.
const TETRAHEDRON: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// A hexahedron's faces, outward.
const HEXAHEDRON: [[usize; 4]; 6] = [
    [0, 3, 2, 1],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

/// The boundary of `volume`: faces that no element shares from the other side.
pub(crate) fn boundary(volume: &RawVolume) -> Boundary {
    let triangles = volume.tetrahedra.iter().flat_map(|corners| {
        TETRAHEDRON.map(|[a, b, c]| [corners[a], corners[b], corners[c], NONE])
    });
    let quadrilaterals = volume
        .hexahedra
        .iter()
        .flat_map(|corners| HEXAHEDRON.map(|face| face.map(|i| corners[i])));
    let faces: Vec<[u32; 4]> = triangles.chain(quadrilaterals).collect();
    let mut keys: Vec<([u32; 4], bool, usize)> = faces
        .iter()
        .enumerate()
        .map(|(i, &face)| {
            let (key, side) = key(face);
            (key, side, i)
        })
        .collect();
    keys.sort_unstable();
    let mut boundary = Boundary::default();
    let mut outer = Vec::new();
    for same in keys.chunk_by(|a, b| a.0 == b.0) {
        let fronts = same.iter().filter(|(_, side, _)| *side).count();
        let backs = same.len() - fronts;
        boundary.crowded += usize::from(same.len() > 2);
        boundary.overlapping += usize::from(fronts > 1 || backs > 1);
        if fronts == 0 || backs == 0 {
            outer.push(same[0].2);
        }
    }
    outer.sort_unstable();
    boundary.faces = outer
        .into_iter()
        .map(|i| Face { corners: faces[i] })
        .collect();
    boundary
}

/// The face as a cycle that begins at its lowest node and goes on to the lower neighbour, and
/// whether that is the way round that it is given in.
fn key(face: [u32; 4]) -> ([u32; 4], bool) {
    let count = if face[3] == NONE { 3 } else { 4 };
    let lowest = (0..count).min_by_key(|&i| face[i]).unwrap_or(0);
    let (next, last) = (
        face[(lowest + 1) % count],
        face[(lowest + count - 1) % count],
    );
    let opposite = if count == 4 {
        face[(lowest + 2) % 4]
    } else {
        NONE
    };
    let key = [face[lowest], next.min(last), next.max(last), opposite];
    (key, next < last)
}

/// The boundary of `volume` as triangles, outward; vertices are the volume's nodes, all of them, in
/// order.
///
/// Triangles follow the elements (tetrahedra first) and an element's faces; the face of a hexahedron
/// is cut into a fan around its first corner. The volume's warnings come along. Nodes inside belong
/// to no triangle: a warning counts them, as it does faces of three elements or more and elements
/// that overlap.
pub fn surface(volume: &RawVolume) -> RawMesh {
    let boundary = boundary(volume);
    let mut mesh = RawMesh {
        name: volume.name.clone(),
        hash: volume.hash,
        positions: volume.nodes.clone(),
        warnings: volume.warnings.clone(),
        ..RawMesh::default()
    };
    let mut used = vec![false; volume.nodes.len()];
    for face in &boundary.faces {
        let nodes = face.nodes();
        for pair in nodes[1..].windows(2) {
            mesh.triangles.push([nodes[0], pair[0], pair[1]]);
        }
        for &node in nodes {
            if let Some(used) = used.get_mut(node as usize) {
                *used = true;
            }
        }
    }
    let inside = used.iter().filter(|&&used| !used).count();
    let name = &volume.name;
    let mut warn = |count: usize, message: &str| {
        if count > 0 {
            mesh.warnings.push(format!("{name}: {count} {message}"));
        }
    };
    let message = format!(
        "of {} nodes are inside: vertices without triangles",
        used.len()
    );
    warn(inside, &message);
    warn(boundary.crowded, "faces belong to three elements or more");
    warn(
        boundary.overlapping,
        "faces have elements on the same side: these overlap",
    );
    mesh
}
