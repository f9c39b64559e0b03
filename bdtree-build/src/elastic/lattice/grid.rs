//! Where the lattice's cells lie.

use crate::vec3::{scale, sub};

/// Where the lattice lies: cubic cells along the mesh axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Lower corner (mesh units).
    pub origin: [f64; 3],
    /// Edge of a cell (mesh units).
    pub cell_size: f64,
    /// Cells along each axis.
    pub dims: [usize; 3],
}

impl Grid {
    /// A mesh point in lattice coordinates (cell size 1).
    pub(crate) fn local(&self, p: [f64; 3]) -> [f64; 3] {
        scale(sub(p, self.origin), 1.0 / self.cell_size)
    }

    /// The cell a lattice point lies in, moved into the lattice.
    pub(crate) fn cell_of(&self, p: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|a| (p[a].floor().max(0.0) as usize).min(self.dims[a] - 1))
    }

    /// Number of a cell, x fastest.
    pub(crate) fn key(&self, cell: [usize; 3]) -> u64 {
        let [nx, ny, _] = self.dims.map(|n| n as u64);
        let [i, j, k] = cell.map(|n| n as u64);
        (k * ny + j) * nx + i
    }

    /// The cell of a number.
    pub(crate) fn cell(&self, key: u64) -> [usize; 3] {
        let [nx, ny, _] = self.dims.map(|n| n as u64);
        [key % nx, key / nx % ny, key / nx / ny].map(|n| n as usize)
    }
}
