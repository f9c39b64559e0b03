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

/// The cells of a lattice whose place on one axis is in a range.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slab {
    /// The axis.
    pub axis: usize,
    /// First place on it.
    pub first: usize,
    /// Behind the last.
    pub end: usize,
}

impl Slab {
    /// Every lattice's cells.
    pub(crate) const ALL: Self = Self {
        axis: 0,
        first: 0,
        end: usize::MAX,
    };

    /// Whether it has cells at this place of an axis.
    pub(crate) fn meets(&self, axis: usize, place: usize) -> bool {
        axis != self.axis || (self.first..self.end).contains(&place)
    }

    /// Whether a cell is one of its own.
    pub(crate) fn contains(&self, cell: [usize; 3]) -> bool {
        self.meets(self.axis, cell[self.axis])
    }

    /// With the cells next to it.
    pub(crate) fn widened(&self) -> Self {
        Self {
            first: self.first.saturating_sub(1),
            end: self.end.saturating_add(1),
            ..*self
        }
    }
}

impl Grid {
    /// Cut across its longest axis into at most `count` slabs, none thinner than `thickness_min` cells unless it is
    /// the only one.
    pub(crate) fn slabs(&self, count: usize, thickness_min: usize) -> Vec<Slab> {
        let axis = (1..3).fold(0, |best, axis| {
            if self.dims[axis] > self.dims[best] {
                axis
            } else {
                best
            }
        });
        let cells = self.dims[axis];
        let count = count.min(cells / thickness_min).max(1);
        let place = |n: usize| n * cells / count;
        (0..count)
            .map(|n| Slab {
                axis,
                first: place(n),
                end: place(n + 1),
            })
            .collect()
    }

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
