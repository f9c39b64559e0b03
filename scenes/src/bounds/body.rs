//! A mesh with modes and the product's tree over it, in f64.

use bdtree_build::tree::{LaneKind, Split, Tree, TreeSettings, build};
use bdtree_format::LANES;
use nalgebra::Vector3;

/// A mesh with modes and its eight-wide tree. Lanes are counted through all nodes: lane k of node
/// n is `8 n + k`.
#[derive(Debug, Clone)]
pub struct Body {
    /// Rest positions p_i.
    pub positions: Vec<Vector3<f64>>,
    /// U_ij, by mode and vertex.
    pub fields: Vec<Vec<Vector3<f64>>>,
    /// Corners by triangle.
    pub corners: Vec<[u32; 3]>,
    /// Nodes and the triangles of their lanes.
    pub tree: Tree,
    /// Where each lane's vertices end in `below`.
    ends: Vec<usize>,
    /// The vertices below each lane, each once.
    below: Vec<u32>,
    /// The node below each lane.
    children: Vec<u32>,
}

impl Body {
    /// The body of a mesh, its tree built as a bake builds it.
    pub fn new(
        positions: &[[f32; 3]],
        fields: Vec<Vec<Vector3<f64>>>,
        corners: Vec<[u32; 3]>,
        split: Split,
        leaf_size: usize,
    ) -> Self {
        let settings = TreeSettings {
            split,
            leaf_size,
            threads: 1,
        };
        let tree = build(positions, &corners, &settings);
        let mut seen = vec![usize::MAX; positions.len()];
        let (mut ends, mut below, mut children) = (Vec::new(), Vec::new(), Vec::new());
        for node in &tree.nodes {
            let mut child = node.first_child;
            for lane in node.lanes {
                for t in tree.triangles_below(lane) {
                    for v in corners[*t as usize] {
                        if seen[v as usize] != ends.len() {
                            seen[v as usize] = ends.len();
                            below.push(v);
                        }
                    }
                }
                ends.push(below.len());
                children.push(child);
                child += u32::from(lane.kind == LaneKind::Inner);
            }
        }
        Self {
            positions: positions
                .iter()
                .map(|p| Vector3::from(p.map(f64::from)))
                .collect(),
            fields,
            corners,
            tree,
            ends,
            below,
            children,
        }
    }

    /// Number of modes M.
    pub fn mode_count(&self) -> usize {
        self.fields.len()
    }

    /// Number of lanes, empty ones included.
    pub fn lane_count(&self) -> usize {
        self.ends.len()
    }

    /// The vertices below a lane, each once.
    pub fn vertices_below(&self, lane: usize) -> &[u32] {
        let start = lane.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.below[start..self.ends[lane]]
    }

    /// The triangles below a lane.
    pub fn triangles_below(&self, lane: usize) -> &[u32] {
        let place = self.tree.nodes[lane / LANES].lanes[lane % LANES];
        self.tree.triangles_below(place)
    }

    /// What a lane holds.
    pub fn kind(&self, lane: usize) -> LaneKind {
        self.tree.nodes[lane / LANES].lanes[lane % LANES].kind
    }

    /// The node below an inner lane.
    pub fn child(&self, lane: usize) -> usize {
        self.children[lane] as usize
    }

    /// Rest positions of the vertices below a lane.
    pub fn rest(&self, lane: usize) -> Vec<Vector3<f64>> {
        let vertices = self.vertices_below(lane).iter();
        vertices.map(|v| self.positions[*v as usize]).collect()
    }

    /// U_ij of the vertices below a lane.
    pub fn field(&self, lane: usize, mode: usize) -> Vec<Vector3<f64>> {
        let vertices = self.vertices_below(lane).iter();
        vertices.map(|v| self.fields[mode][*v as usize]).collect()
    }

    /// p + U q of all vertices.
    pub fn deformed(&self, q: &[f64]) -> Vec<Vector3<f64>> {
        let mut all = self.positions.clone();
        for (field, q) in self.fields.iter().zip(q) {
            for (p, u) in all.iter_mut().zip(field) {
                *p += u * *q;
            }
        }
        all
    }
}
