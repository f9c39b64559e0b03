//! Blocks of a component that meet at single nodes or edges only: joints that nothing stiffens.

use std::collections::HashMap;

use crate::disjoint_sets::DisjointSets;
use crate::elastic::element::NodeLists;
use crate::vec3::{cross, norm, sub};

/// Sets of elements that are stiff in themselves. A component of several can move at its joints
/// without strain.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Blocks {
    /// Block of each node, from 0; empty: all nodes are in block 0.
    pub of_node: Vec<u32>,
    /// Number of blocks after the first.
    pub further: usize,
    /// Joints: nodes with another block that they belong to as well.
    pub joints: Vec<(u32, u32)>,
}

impl Blocks {
    /// Block of a node; the first of them at a joint.
    pub(crate) fn of(&self, node: usize) -> usize {
        self.of_node.get(node).map_or(0, |&b| b as usize)
    }

    /// The same with other node numbers.
    pub(crate) fn renumbered(&self, place: &[u32]) -> Self {
        let mut of_node = vec![0; self.of_node.len()];
        for (n, &block) in self.of_node.iter().enumerate() {
            of_node[place[n] as usize] = block;
        }
        let joints = self.joints.iter();
        Self {
            of_node,
            further: self.further,
            joints: joints.map(|&(n, b)| (place[n as usize], b)).collect(),
        }
    }
}

/// More blocks than this are refused: the null space of so many is not worth computing.
pub(crate) const BLOCKS_MAX: usize = 100;

/// A body of more than [`BLOCKS_MAX`] blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TooManyBlocks(pub usize);

/// Corners of the faces of a tetrahedron.
const TRIANGLES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
/// Corners of the faces of a hexahedron, in VTK's order.
const QUADS: [[usize; 4]; 6] = [
    [0, 1, 2, 3],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

/// The blocks of connected elements: those that share a face, or three nodes off a line.
pub(crate) fn find_blocks(
    positions: &[[f64; 3]],
    elements: &NodeLists,
) -> Result<Blocks, TooManyBlocks> {
    let mut sets = join_over_faces(elements);
    loop {
        // Per node the blocks that it is in, each named by its first element.
        let mut memberships: Vec<(u32, u32)> = Vec::new();
        let mut names = HashMap::new();
        for (e, nodes) in elements.iter().enumerate() {
            let name = *names.entry(sets.find(e)).or_insert(e as u32);
            memberships.extend(nodes.iter().map(|&n| (n, name)));
        }
        if names.len() == 1 {
            return Ok(Blocks::default());
        }
        // Pairs of blocks at a node are counted below: few enough for that.
        if names.len() > 10 * BLOCKS_MAX {
            return Err(TooManyBlocks(names.len()));
        }
        memberships.sort_unstable();
        memberships.dedup();
        if !join_neighbours(positions, &memberships, &mut sets) {
            if names.len() > BLOCKS_MAX {
                return Err(TooManyBlocks(names.len()));
            }
            return Ok(number(positions.len(), &memberships));
        }
    }
}

fn join_over_faces(elements: &NodeLists) -> DisjointSets {
    let mut sets = DisjointSets::new(elements.len());
    let mut faces: Vec<([u32; 4], u32)> = Vec::new();
    for (e, nodes) in elements.iter().enumerate() {
        let mut add = |corners: &[usize]| {
            let mut face = [u32::MAX; 4];
            for (f, &c) in face.iter_mut().zip(corners) {
                *f = nodes[c];
            }
            face.sort_unstable();
            faces.push((face, e as u32));
        };
        match nodes.len() {
            4 => TRIANGLES.iter().for_each(|f| add(f)),
            8 => QUADS.iter().for_each(|f| add(f)),
            _ => {}
        }
    }
    faces.sort_unstable();
    for own in faces.chunk_by(|a, b| a.0 == b.0) {
        for other in &own[1..] {
            sets.join(own[0].1 as usize, other.1 as usize);
        }
    }
    sets
}

/// Joins blocks that share three nodes off a line; whether there were any.
fn join_neighbours(
    positions: &[[f64; 3]],
    memberships: &[(u32, u32)],
    sets: &mut DisjointSets,
) -> bool {
    let mut shared: Vec<(u32, u32, u32)> = Vec::new();
    for own in memberships.chunk_by(|a, b| a.0 == b.0) {
        for (i, a) in own.iter().enumerate() {
            shared.extend(own[i + 1..].iter().map(|b| (a.1, b.1, a.0)));
        }
    }
    shared.sort_unstable();
    let mut any = false;
    for pair in shared.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let points = pair.iter().map(|s| positions[s.2 as usize]);
        if spans_a_plane(points) {
            sets.join(pair[0].0 as usize, pair[0].1 as usize);
            any = true;
        }
    }
    any
}

/// Whether three of the points are off a line.
fn spans_a_plane(mut points: impl Iterator<Item = [f64; 3]> + Clone) -> bool {
    let Some(first) = points.next() else {
        return false;
    };
    let mut longest = [0.0; 3];
    for p in points.clone() {
        let edge = sub(p, first);
        if norm(edge) > norm(longest) {
            longest = edge;
        }
    }
    let length = norm(longest);
    points.any(|p| norm(cross(longest, sub(p, first))) > 1e-6 * length * length)
}

fn number(node_count: usize, memberships: &[(u32, u32)]) -> Blocks {
    let mut blocks = Blocks {
        of_node: vec![0; node_count],
        ..Blocks::default()
    };
    let mut numbers: Vec<u32> = memberships.iter().map(|m| m.1).collect();
    numbers.sort_unstable();
    numbers.dedup();
    blocks.further = numbers.len().saturating_sub(1);
    for own in memberships.chunk_by(|a, b| a.0 == b.0) {
        for (i, m) in own.iter().enumerate() {
            let block = numbers.partition_point(|&n| n < m.1) as u32;
            if i == 0 {
                blocks.of_node[m.0 as usize] = block;
            } else {
                blocks.joints.push((m.0, block));
            }
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_join_and_edges_do_not() {
        let p = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [2.0, 1.0, 1.0],
            [2.0, 0.0, 1.0],
        ];
        let blocks = |lists: &[[u32; 4]]| {
            let mut elements = NodeLists::default();
            lists.iter().for_each(|l| elements.push(*l));
            find_blocks(&p, &elements).expect("few blocks")
        };
        assert_eq!(blocks(&[[0, 1, 2, 3], [1, 2, 3, 4]]), Blocks::default());
        let edge = blocks(&[[0, 1, 2, 3], [1, 3, 5, 6]]);
        assert_eq!((edge.further, edge.joints), (1, vec![(1, 1), (3, 1)]));
        let point = blocks(&[[0, 1, 2, 3], [1, 2, 3, 4], [4, 5, 6, 1]]);
        assert_eq!((point.further, point.joints), (1, vec![(1, 1), (4, 1)]));
        assert_eq!(point.of_node[6], 1);
    }
}
