//! Finite elements: stiffness and mass of one cell, hexahedron or tetrahedron.

pub(crate) mod hexahedron;
pub(crate) mod material;
pub(crate) mod moments;
pub(crate) mod spline;
pub(crate) mod tetrahedron;

/// Stiffness and mass of an element with n functions.
#[derive(Debug, Clone)]
pub(crate) struct ElementMatrices {
    /// Per pair of functions at `n i + j`: the 3 × 3 block, row-major.
    pub stiffness: Vec<[f64; 9]>,
    /// Per pair of functions: the mass of each direction.
    pub mass: Vec<f64>,
}

impl ElementMatrices {
    /// Puts the sum of each row of the mass on its diagonal.
    pub(crate) fn lump(&mut self) {
        let count = self.mass.len().isqrt();
        for (i, row) in self.mass.chunks_exact_mut(count.max(1)).enumerate() {
            let sum = row.iter().sum();
            row.fill(0.0);
            row[i] = sum;
        }
    }
}

/// Lists of nodes, one per element.
#[derive(Debug, Clone, Default)]
pub(crate) struct NodeLists {
    ends: Vec<usize>,
    nodes: Vec<u32>,
}

impl NodeLists {
    /// Appends an element.
    pub(crate) fn push(&mut self, nodes: impl IntoIterator<Item = u32>) {
        self.nodes.extend(nodes);
        self.ends.push(self.nodes.len());
    }

    /// Number of elements.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Nodes of an element.
    pub(crate) fn get(&self, element: usize) -> &[u32] {
        let start = if element == 0 {
            0
        } else {
            self.ends[element - 1]
        };
        &self.nodes[start..self.ends[element]]
    }

    /// The elements in turn.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|e| self.get(e))
    }

    /// The same with other node numbers.
    pub(crate) fn renumbered(&self, place: &[u32]) -> Self {
        Self {
            ends: self.ends.clone(),
            nodes: self.nodes.iter().map(|&n| place[n as usize]).collect(),
        }
    }
}
