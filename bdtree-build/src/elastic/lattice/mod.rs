//! The lattice of filled cells: which are connected, and which spline functions act on them.

mod connect;
pub(crate) mod fill;
pub(crate) mod grid;
pub(crate) mod locate;
pub(crate) mod mass;
pub(crate) mod resolution;
pub(crate) mod slice;
mod subject;
mod system;
pub(crate) mod table;

use crate::elastic::element::moments::Moments;
use crate::elastic::element::spline::FUNCTIONS;
use crate::elastic::lattice::grid::Grid;
pub(crate) use crate::elastic::lattice::subject::Subject;
use crate::elastic::lattice::table::Filling;

/// A connected set of cells: its own vibrating body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Component {
    /// Cell in whose middle each node's function is centered; also cells around the lattice.
    pub nodes: Vec<[i32; 3]>,
    /// Per cell: its nodes, those of the 3 × 3 × 3 cells around it, x fastest, then y, then z.
    pub cells: Vec<[u32; FUNCTIONS]>,
    /// Per cell: what fills it.
    pub moments: Vec<Moments>,
}

/// Fine cells per cell along each axis: they tell what in a cell hangs together.
const FINE: usize = 2;

/// What is connected inside one cell. Two walls with a gap between them are two parts, each with
/// functions of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellPart {
    /// The cell.
    pub cell: [usize; 3],
    /// Its component.
    pub component: u32,
    /// Its place among the component's cells.
    pub place: u32,
}

/// The cells that are filled, in components.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    /// Where the cells lie.
    pub grid: Grid,
    /// Where the fine cells lie.
    fine: Grid,
    /// Every body's share of every fine cell, sorted by cell, then body.
    fillings: Vec<Filling>,
    /// Per filling: its part.
    part_of: Vec<u32>,
    /// Sorted by cell.
    pub parts: Vec<CellPart>,
    /// In the order of their first parts.
    pub components: Vec<Component>,
}

impl Lattice {
    /// Index of a body's filling of a fine cell.
    fn find(&self, key: u64, body: u32) -> Option<usize> {
        self.fillings
            .binary_search_by_key(&(key, body), |f| (f.key, f.body))
            .ok()
    }

    /// The part a lattice point lies in, of any body: as fine cells tell.
    pub(crate) fn part_at(&self, p: [f64; 3]) -> Option<usize> {
        let key = self.fine.key(self.fine.cell_of(p.map(|x| x * FINE as f64)));
        let n = self.fillings.partition_point(|f| f.key < key);
        let hit = self.fillings.get(n).is_some_and(|f| f.key == key);
        hit.then(|| self.part_of[n] as usize)
    }

    /// The part of `body` nearest to a lattice point.
    pub(crate) fn nearest_part(&self, body: u32, p: [f64; 3]) -> Option<usize> {
        let p = p.map(|x| x * FINE as f64);
        let center = self.fine.cell_of(p);
        if let Some(n) = self.find(self.fine.key(center), body) {
            return Some(self.part_of[n] as usize);
        }
        let around = (0..27usize).filter_map(|n| {
            let step = [n % 3, n / 3 % 3, n / 9];
            let cell: [usize; 3] = std::array::from_fn(|a| (center[a] + step[a]).wrapping_sub(1));
            let within = (0..3).all(|a| cell[a] < self.fine.dims[a]);
            within.then(|| self.find(self.fine.key(cell), body))?
        });
        let all = (0..self.fillings.len()).filter(|&n| self.fillings[n].body == body);
        // Only parts of a surface component that hold no material at all are far from all its cells.
        let best = self.closest(p, around).or_else(|| self.closest(p, all));
        best.map(|n| self.part_of[n] as usize)
    }

    /// The first of the fillings with the least distance to a point of the fine lattice.
    fn closest(&self, p: [f64; 3], fillings: impl Iterator<Item = usize>) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for n in fillings {
            let cell = self.fine.cell(self.fillings[n].key);
            let distance: f64 = (0..3)
                .map(|a| {
                    let lo = cell[a] as f64;
                    (lo - p[a]).max(p[a] - lo - 1.0).max(0.0).powi(2)
                })
                .sum();
            if best.is_none_or(|b| distance < b.0) {
                best = Some((distance, n));
            }
        }
        best.map(|b| b.1)
    }

    /// Bodies and the components they fill part of.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = (u32, usize)> {
        let parts = self.part_of.iter().map(|&n| self.parts[n as usize]);
        (self.fillings.iter().zip(parts)).map(|(f, part)| (f.body, part.component as usize))
    }

    /// Numbers of nodes of the components.
    pub(crate) fn sizes(&self) -> Vec<usize> {
        self.components.iter().map(|c| c.nodes.len()).collect()
    }

    /// Nodes of all components.
    pub(crate) fn node_count(&self) -> usize {
        self.components.iter().map(|c| c.nodes.len()).sum()
    }
}
