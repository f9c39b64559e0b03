//! What fragments of the surface add up to in each cell.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::elastic::element::moments::{Moments, POWERS};
use crate::elastic::lattice::grid::{Grid, Slab};
use crate::elastic::lattice::slice::{Polygon, for_each_fragment};

/// Moments in η and ζ of what lies between a surface and the lower end of its row.
pub(crate) type Shadow = [f64; POWERS * POWERS];

/// The part of one body in one cell.
#[derive(Debug, Clone)]
pub(crate) struct Filling {
    /// Cell number.
    pub key: u64,
    /// Body index.
    pub body: u32,
    /// Its moments there; `None` fills the cell.
    pub moments: Option<Box<Moments>>,
    /// Shares of the cell's lower x, y and z face that it covers.
    pub faces: [f64; 3],
}

/// The lattice would need more cells than allowed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TooManyCells;

/// A share of a cell or of a face below this is rounding or a touch.
pub(crate) const SHARE_MIN: f64 = 1e-6;

/// A fast hash for cell numbers; only looked up, never iterated.
#[derive(Default)]
struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u64(u64::from(b));
        }
    }
    fn write_u32(&mut self, x: u32) {
        self.write_u64(u64::from(x));
    }
    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0.rotate_left(5) ^ x).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
}

#[derive(Clone)]
pub(crate) struct Sums {
    pub key: u64,
    pub body: u32,
    /// Moments of what its surface bounds towards the lower end of the row, inside the cell.
    pub own: Moments,
    pub shadow: Shadow,
    /// What its surface adds to the covered shares of the lower y and z faces here and below.
    pub flux: [f64; 2],
    /// Above 0 for those of its own lower faces that a sheet reaches through.
    pub crossed: [f64; 3],
}

/// A body in one cell that comes near a face of it: the cell, its neighbour there, the body.
pub(crate) type Touch = (u64, u64, u32);

/// What fills the cells, and where it is near their neighbours.
#[derive(Debug, Default)]
pub(crate) struct Fillings {
    /// Sorted by cell, then body.
    pub list: Vec<Filling>,
    /// Sorted; empty where there is one body only.
    pub touches: Vec<Touch>,
}

/// How near a face a body must come to touch the next cell, in cells.
const NEAR: f64 = 0.25;

/// What the fragments add up to, per cell and body, in one slab of the lattice.
pub(crate) struct Table<'c> {
    /// Whose cells it holds.
    pub slab: Slab,
    /// Whether touches are wanted.
    several: bool,
    pub touches: Vec<Touch>,
    index: HashMap<(u64, u32), usize, BuildHasherDefault<KeyHasher>>,
    pub sums: Vec<Sums>,
    last: usize,
    /// How many more there may be, in the tables of all slabs.
    room: &'c AtomicUsize,
}

impl<'c> Table<'c> {
    /// No cells yet; `several` bodies may touch.
    pub(crate) fn new(slab: Slab, several: bool, room: &'c AtomicUsize) -> Self {
        Self {
            slab,
            several,
            touches: Vec::new(),
            index: HashMap::default(),
            sums: Vec::new(),
            last: 0,
            room,
        }
    }

    /// Calls `add(sums, cell, fragment)` for the fragments of a triangle of `body` (mesh units) in slab `within`; there
    /// are no sums of cells that are another table's.
    pub(crate) fn add_fragments(
        &mut self,
        grid: &Grid,
        body: u32,
        triangle: [[f64; 3]; 3],
        within: &Slab,
        add: &mut impl FnMut(Option<&mut Sums>, [usize; 3], &Polygon),
    ) -> Result<(), TooManyCells> {
        let mut outcome = Ok(());
        let local = triangle.map(|p| grid.local(p));
        for_each_fragment(local, grid.dims, within, &mut |cell, polygon| {
            if outcome.is_err() {
                return;
            }
            if !self.slab.contains(cell) {
                add(None, cell, polygon);
                return;
            }
            match self.entry(grid.key(cell), body) {
                Ok(sums) => {
                    add(Some(sums), cell, polygon);
                    self.note_touches(grid, body, cell, polygon);
                }
                Err(error) => outcome = Err(error),
            }
        });
        outcome
    }

    /// Notes where a fragment comes near the neighbours of its cell.
    fn note_touches(&mut self, grid: &Grid, body: u32, cell: [usize; 3], polygon: &Polygon) {
        if !self.several {
            return;
        }
        for a in 0..3 {
            let (lo, hi) = polygon.range(a);
            let mut other = cell;
            if lo < cell[a] as f64 + NEAR && cell[a] > 0 {
                other[a] = cell[a] - 1;
                self.touches.push((grid.key(cell), grid.key(other), body));
            }
            if hi > (cell[a] + 1) as f64 - NEAR && cell[a] + 1 < grid.dims[a] {
                other[a] = cell[a] + 1;
                self.touches.push((grid.key(cell), grid.key(other), body));
            }
        }
    }

    /// The sums of a body in a cell.
    pub(crate) fn entry(&mut self, key: u64, body: u32) -> Result<&mut Sums, TooManyCells> {
        let hit = self
            .sums
            .get(self.last)
            .is_some_and(|s| s.key == key && s.body == body);
        if !hit {
            let next = self.sums.len();
            self.last = *self.index.entry((key, body)).or_insert(next);
            if self.last == next {
                let one_less = |room: usize| room.checked_sub(1);
                let (set, get) = (Ordering::Relaxed, Ordering::Relaxed);
                if self.room.fetch_update(set, get, one_less).is_err() {
                    return Err(TooManyCells);
                }
                self.sums.push(Sums {
                    key,
                    body,
                    own: [0.0; 125],
                    shadow: [0.0; 25],
                    flux: [0.0; 2],
                    crossed: [0.0; 3],
                });
            }
        }
        Ok(&mut self.sums[self.last])
    }
}
