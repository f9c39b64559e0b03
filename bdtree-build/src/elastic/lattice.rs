//! The lattice of filled cells: which hang together, and where its nodes are.

use std::collections::HashMap;

use super::moments::{Filling, Grid, Moments, TooManyCells, fill, full_cell};
use super::pieces::{DisjointSets, Kind, Pieces};
use crate::input::RawMesh;

/// A connected set of cells: its own vibrating body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Component {
    /// Lattice corner of each node.
    pub nodes: Vec<[i32; 3]>,
    /// Per cell: its nodes, x fastest, then y, then z.
    pub cells: Vec<[u32; 8]>,
    /// Per cell: what fills it.
    pub moments: Vec<Moments>,
}

/// The cells that are filled, in components.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    /// Where the cells lie.
    pub grid: Grid,
    /// Every body's part in every cell, sorted by cell, then body.
    pub fillings: Vec<Filling>,
    /// Cell numbers, ascending.
    pub keys: Vec<u64>,
    /// Per cell: its component and its place there.
    pub places: Vec<(u32, u32)>,
    /// In the order of their first cells.
    pub components: Vec<Component>,
}

impl Lattice {
    /// Index of a cell in `keys`, if it is filled.
    pub(crate) fn find(&self, key: u64) -> Option<usize> {
        self.keys.binary_search(&key).ok()
    }

    /// Whether `body` fills part of the cell.
    pub(crate) fn holds(&self, key: u64, body: u32) -> bool {
        self.fillings
            .binary_search_by_key(&(key, body), |f| (f.key, f.body))
            .is_ok()
    }

    /// Nodes of all components.
    pub(crate) fn node_count(&self) -> usize {
        self.components.iter().map(|c| c.nodes.len()).sum()
    }
}

/// A mesh that was read once and is put into lattices of several sizes.
#[derive(Debug)]
pub(crate) struct Subject<'a> {
    /// The mesh.
    pub mesh: &'a RawMesh,
    /// Its pieces.
    pub pieces: Pieces,
    /// Thickness of sheets (mesh units).
    pub thickness: f64,
    min: [f64; 3],
    max: [f64; 3],
}

impl<'a> Subject<'a> {
    /// Measures the box of the material, sheets with their thickness. Needs a piece at least.
    pub(crate) fn new(mesh: &'a RawMesh, pieces: Pieces, thickness: f64) -> Self {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut take = |p: [f64; 3]| {
            for a in 0..3 {
                min[a] = min[a].min(p[a]);
                max[a] = max[a].max(p[a]);
            }
        };
        for piece in &pieces.list {
            for &(id, _) in &piece.triangles {
                let [a, b, c] = mesh.triangles[id as usize].map(|v| mesh.positions[v as usize]);
                let mut half = [0.0; 3];
                if piece.kind != Kind::Solid {
                    let n = super::vec3::cross(super::vec3::sub(b, a), super::vec3::sub(c, a));
                    let length = super::vec3::norm(n);
                    if length > 0.0 {
                        half = super::vec3::scale(n, 0.5 * thickness / length);
                    }
                }
                for p in [a, b, c] {
                    take(super::vec3::add(p, half));
                    take(super::vec3::sub(p, half));
                }
            }
        }
        Self {
            mesh,
            pieces,
            thickness,
            min,
            max,
        }
    }

    /// The grid with this many cells along the longest side, centred on the material's box so
    /// that symmetric bodies meet symmetric cells, and a box with whole ratios fits exactly.
    pub(crate) fn grid(&self, resolution: f64) -> Grid {
        let extent: [f64; 3] = std::array::from_fn(|a| self.max[a] - self.min[a]);
        let longest = extent.iter().fold(0.0f64, |x, &y| x.max(y));
        let cell_size = longest / resolution;
        let dims = extent.map(|e| ((e / cell_size - 1e-6).ceil().max(1.0)) as usize);
        let origin = std::array::from_fn(|a| {
            0.5 * (self.min[a] + self.max[a]) - 0.5 * dims[a] as f64 * cell_size
        });
        Grid {
            origin,
            cell_size,
            dims,
        }
    }

    /// The filled cells at this many cells along the longest side.
    ///
    /// # Errors
    /// More than `limit` cells.
    pub(crate) fn lattice(&self, resolution: f64, limit: usize) -> Result<Lattice, TooManyCells> {
        let grid = self.grid(resolution);
        // A surface point lies at most this many cells deep in rounding: see `Grid::local`.
        let mesh = self.mesh;
        let corners = |id: u32| mesh.triangles[id as usize].map(|v| mesh.positions[v as usize]);
        let fillings = fill(&grid, &self.pieces.list, &corners, self.thickness, limit)?;
        Ok(connect(grid, fillings))
    }
}

/// Finds the components: cells sharing a face hang together where one body fills both, and all
/// bodies in one cell are joined.
fn connect(grid: Grid, fillings: Vec<Filling>) -> Lattice {
    let mut keys: Vec<u64> = fillings.iter().map(|f| f.key).collect();
    keys.dedup();
    let mut lattice = Lattice {
        grid,
        fillings,
        keys,
        places: Vec::new(),
        components: Vec::new(),
    };
    let mut sets = DisjointSets::new(lattice.keys.len());
    // Per cell: whether it hangs together with the next one along x, y, z.
    let mut linked = vec![[false; 3]; lattice.keys.len()];
    for f in &lattice.fillings {
        let cell = grid.cell(f.key);
        let Some(here) = lattice.find(f.key) else {
            continue;
        };
        for axis in 0..3 {
            let mut next = cell;
            next[axis] += 1;
            if next[axis] >= grid.dims[axis] {
                continue;
            }
            let key = grid.key(next);
            if lattice.holds(key, f.body)
                && let Some(there) = lattice.find(key)
            {
                sets.join(here, there);
                linked[here][axis] = true;
            }
        }
    }
    let mut number: HashMap<usize, u32> = HashMap::new();
    let mut parts = lattice.fillings.chunk_by(|a, b| a.key == b.key);
    for n in 0..lattice.keys.len() {
        let root = sets.find(n);
        let next = number.len() as u32;
        let component = *number.entry(root).or_insert(next);
        if component == next {
            lattice.components.push(Component::default());
        }
        let own = &mut lattice.components[component as usize];
        lattice.places.push((component, own.cells.len() as u32));
        own.cells.push([0; 8]);
        own.moments.push(sum(parts.next().unwrap_or(&[])));
    }
    number_nodes(&mut lattice, &linked);
    lattice
}

/// Gives every corner its nodes: one for each group of cells around it that hang together over
/// faces *there*. So cells that merely touch stay apart, be it two bodies in neighbouring cells
/// or two cells of one body that meet in an edge, which would be a hinge.
fn number_nodes(lattice: &mut Lattice, linked: &[[bool; 3]]) {
    let [nx, ny, _] = lattice.grid.dims.map(|n| n as u64 + 1);
    let mut corners: Vec<(u64, u32, u8)> = Vec::with_capacity(8 * lattice.keys.len());
    for (n, &key) in lattice.keys.iter().enumerate() {
        let cell = lattice.grid.cell(key);
        for corner in 0..8u8 {
            let [i, j, k] = [0, 1, 2].map(|a| (cell[a] + usize::from(corner >> a & 1)) as u64);
            corners.push(((k * ny + j) * nx + i, n as u32, corner));
        }
    }
    corners.sort_unstable();
    for around in corners.chunk_by(|a, b| a.0 == b.0) {
        // Seen from a corner, the cell that has it as its corner 0 lies above on all axes.
        let mut sets = DisjointSets::new(around.len());
        for (n, a) in around.iter().enumerate() {
            for (m, b) in around.iter().enumerate() {
                // Cell a is below cell b along the one axis in which their corners differ.
                let difference = a.2 ^ b.2;
                if difference.count_ones() == 1 && a.2 & difference != 0 {
                    let axis = difference.trailing_zeros() as usize;
                    if linked[a.1 as usize][axis] {
                        sets.join(n, m);
                    }
                }
            }
        }
        let mut nodes = [0u32; 8];
        for (n, &(_, cell, corner)) in around.iter().enumerate() {
            let (component, place) = lattice.places[cell as usize];
            let root = sets.find(n);
            let own = &mut lattice.components[component as usize];
            if root == n {
                nodes[n] = own.nodes.len() as u32;
                let at = lattice.grid.cell(lattice.keys[cell as usize]);
                own.nodes
                    .push([0, 1, 2].map(|a| at[a] as i32 + i32::from(corner >> a & 1)));
            }
            own.cells[place as usize][usize::from(corner)] = nodes[root];
        }
    }
}

/// Moments of all bodies in a cell together. Bodies that overlap cannot fill more than the cell.
fn sum(parts: &[Filling]) -> Moments {
    let mut total = [0.0; 27];
    for part in parts {
        for (t, m) in total.iter_mut().zip(&part.moments) {
            *t += m;
        }
    }
    if total[0] > 1.0 - 1e-9 {
        return full_cell();
    }
    total
}
