//! Moments of the filled part of each cell: exact volume integrals from the surface alone.
//!
//! The stiffness and the mass of a partly filled cell are integrals of polynomials of degree two
//! per coordinate over its filled part, so 27 numbers per cell say all about the filling (the
//! finite-cell method with fitted moments instead of sub-cells). For a solid they come from the
//! divergence theorem along x: a fragment of the surface adds its own integral to its cell and
//! its shadow to all cells before it in the row. A sheet is integrated over its area at Gauss
//! points through its thickness, which carries its bending stiffness.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::pieces::{Kind, Piece};
use super::slice::{for_each_fragment, integrate};
use super::vec3::{add, cross, norm, scale, sub};

/// ⅛ ∫ ξᵃ ηᵇ ζᶜ over the filled part, in [-1, 1]³, at `a + 3b + 9c`; entry 0 is the filled share.
pub(crate) type Moments = [f64; 27];

/// Moments of a cell that is filled.
pub(crate) fn full_cell() -> Moments {
    const LINE: [f64; 3] = [1.0, 0.0, 1.0 / 3.0];
    std::array::from_fn(|n| LINE[n % 3] * LINE[n / 3 % 3] * LINE[n / 9])
}

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

/// The part of one body in one cell.
#[derive(Debug, Clone)]
pub(crate) struct Filling {
    /// Cell number.
    pub key: u64,
    /// Body index.
    pub body: u32,
    /// Its moments there.
    pub moments: Moments,
}

/// The lattice would need more cells than allowed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TooManyCells;

/// A share below this is rounding or a touch.
const SHARE_MIN: f64 = 1e-6;

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
struct Sums {
    key: u64,
    body: u32,
    own: Moments,
    shadow: [f64; 9],
}

struct Table {
    index: HashMap<(u64, u32), usize, BuildHasherDefault<KeyHasher>>,
    sums: Vec<Sums>,
    last: usize,
    limit: usize,
}

impl Table {
    fn entry(&mut self, key: u64, body: u32) -> Result<&mut Sums, TooManyCells> {
        let hit = self
            .sums
            .get(self.last)
            .is_some_and(|s| s.key == key && s.body == body);
        if !hit {
            let next = self.sums.len();
            self.last = *self.index.entry((key, body)).or_insert(next);
            if self.last == next {
                if next >= self.limit {
                    return Err(TooManyCells);
                }
                self.sums.push(Sums {
                    key,
                    body,
                    own: [0.0; 27],
                    shadow: [0.0; 9],
                });
            }
        }
        Ok(&mut self.sums[self.last])
    }
}

/// Calls `visit` with the corners of each triangle of the sheet's layers and the thickness that
/// layer stands for: two Gauss layers per cell size of thickness.
pub(crate) fn for_each_layer(
    triangle: [[f64; 3]; 3],
    thickness: f64,
    cell_size: f64,
    visit: &mut impl FnMut([[f64; 3]; 3], f64),
) {
    let [a, b, c] = triangle;
    let normal = cross(sub(b, a), sub(c, a));
    let length = norm(normal);
    if length.is_nan() || length <= 0.0 {
        return;
    }
    let normal = scale(normal, 1.0 / length);
    // A sheet thicker than hundreds of cells is a block seen from its side; the cell limit ends it.
    let slices = (thickness / cell_size).ceil().clamp(1.0, 4096.0) as usize;
    let step = thickness / slices as f64;
    for n in 0..slices {
        let middle = (n as f64 + 0.5) * step - 0.5 * thickness;
        for gauss in [-1.0, 1.0] {
            let shift = scale(normal, middle + gauss * step / 12f64.sqrt());
            visit(triangle.map(|p| add(p, shift)), 0.5 * step);
        }
    }
}

/// Moments of every body in every cell it fills, sorted by cell, then body.
///
/// `corners` gives a triangle's positions by id; sheets take `thickness` (mesh units).
pub(crate) fn fill(
    grid: &Grid,
    pieces: &[Piece],
    corners: &dyn Fn(u32) -> [[f64; 3]; 3],
    thickness: f64,
    limit: usize,
) -> Result<Vec<Filling>, TooManyCells> {
    let mut table = Table {
        index: HashMap::default(),
        sums: Vec::new(),
        last: 0,
        limit,
    };
    for piece in pieces {
        let body = piece.body as u32;
        for &(id, reverse) in &piece.triangles {
            let triangle = corners(id);
            match piece.kind {
                Kind::Solid => {
                    let sign = if reverse { -piece.sign } else { piece.sign };
                    add_solid(&mut table, grid, body, triangle, sign)?;
                }
                Kind::Sheet => add_sheet(&mut table, grid, body, triangle, thickness)?,
                Kind::Paper => add_sheet(&mut table, grid, body, triangle, 0.5 * thickness)?,
            }
        }
        for &cap in &piece.caps {
            add_solid(&mut table, grid, body, cap, piece.sign)?;
        }
    }
    let mut result = sweep(grid, table.sums, limit)?;
    result.sort_unstable_by_key(|f| (f.key, f.body));
    Ok(result)
}

fn powers(x: f64) -> [f64; 3] {
    [1.0, x, x * x]
}

fn add_solid(
    table: &mut Table,
    grid: &Grid,
    body: u32,
    triangle: [[f64; 3]; 3],
    sign: f64,
) -> Result<(), TooManyCells> {
    let mut outcome = Ok(());
    for_each_fragment(
        triangle.map(|p| grid.local(p)),
        grid.dims,
        &mut |cell, polygon| {
            if outcome.is_err() {
                return;
            }
            let sums = match table.entry(grid.key(cell), body) {
                Ok(sums) => sums,
                Err(e) => {
                    outcome = Err(e);
                    return;
                }
            };
            integrate(polygon, &mut |p, vector| {
                let [x, y, z]: [f64; 3] =
                    std::array::from_fn(|a| 2.0 * (p[a] - cell[a] as f64) - 1.0);
                let (y, z, w) = (powers(y), powers(z), 0.5 * sign * vector[0]);
                let primitive = [x + 1.0, 0.5 * (x * x - 1.0), (x * x * x + 1.0) / 3.0];
                for (n, sum) in sums.shadow.iter_mut().enumerate() {
                    let shadow = w * y[n % 3] * z[n / 3];
                    *sum += shadow;
                    for (own, f) in sums.own[3 * n..].iter_mut().zip(primitive) {
                        *own += shadow * f;
                    }
                }
            });
        },
    );
    outcome
}

fn add_sheet(
    table: &mut Table,
    grid: &Grid,
    body: u32,
    triangle: [[f64; 3]; 3],
    thickness: f64,
) -> Result<(), TooManyCells> {
    let mut outcome = Ok(());
    for_each_layer(triangle, thickness, grid.cell_size, &mut |layer, depth| {
        let depth = depth / grid.cell_size;
        for_each_fragment(
            layer.map(|p| grid.local(p)),
            grid.dims,
            &mut |cell, polygon| {
                if outcome.is_err() {
                    return;
                }
                let sums = match table.entry(grid.key(cell), body) {
                    Ok(sums) => sums,
                    Err(e) => {
                        outcome = Err(e);
                        return;
                    }
                };
                integrate(polygon, &mut |p, vector| {
                    let local: [[f64; 3]; 3] =
                        std::array::from_fn(|a| powers(2.0 * (p[a] - cell[a] as f64) - 1.0));
                    let w = norm(vector) * depth;
                    for (n, sum) in sums.own.iter_mut().enumerate() {
                        *sum += w * local[0][n % 3] * local[1][n / 3 % 3] * local[2][n / 9];
                    }
                });
            },
        );
    });
    outcome
}

/// Hands the shadows down each row and keeps the cells that are filled.
fn sweep(grid: &Grid, mut sums: Vec<Sums>, limit: usize) -> Result<Vec<Filling>, TooManyCells> {
    let nx = grid.dims[0] as u64;
    sums.sort_unstable_by_key(|s| (s.body, s.key));
    let mut result = Vec::with_capacity(sums.len());
    let with_shadow = |own: &Moments, shadow: &[f64; 9]| -> Moments {
        const FULL: [f64; 3] = [2.0, 0.0, 2.0 / 3.0];
        std::array::from_fn(|n| own[n] + FULL[n % 3] * shadow[n / 3])
    };
    let mut keep = |key: u64, body: u32, moments: Moments| {
        if moments[0] > SHARE_MIN {
            if result.len() >= limit {
                return Err(TooManyCells);
            }
            result.push(Filling { key, body, moments });
        }
        Ok(())
    };
    for row in sums.chunk_by(|a, b| (a.body, a.key / nx) == (b.body, b.key / nx)) {
        let mut shadow = [0.0; 9];
        for (n, own) in row.iter().enumerate().rev() {
            keep(own.key, own.body, with_shadow(&own.own, &shadow))?;
            for (s, add) in shadow.iter_mut().zip(&own.shadow) {
                *s += add;
            }
            let previous = if n > 0 { row[n - 1].key + 1 } else { own.key };
            let gap = with_shadow(&[0.0; 27], &shadow);
            if gap[0] > SHARE_MIN {
                for key in (previous..own.key).rev() {
                    keep(key, own.body, gap)?;
                }
            }
        }
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::pieces::find_pieces;

    /// A tetrahedron's volume and first moments, whichever way the cells cut it.
    #[test]
    fn moments_of_a_tetrahedron_are_exact() {
        let p = [
            [0.1, 0.2, 0.3],
            [5.3, 0.7, 1.1],
            [1.3, 4.9, 0.4],
            [2.2, 1.7, 6.1],
        ];
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let grid = Grid {
            origin: [0.0; 3],
            cell_size: 1.0,
            dims: [6, 5, 7],
        };
        let pieces = find_pieces(&p, &triangles).list;
        let corners = |id: u32| triangles[id as usize].map(|v| p[v as usize]);
        let cells = fill(&grid, &pieces, &corners, 0.1, 1000).unwrap_or_default();
        let (mut volume, mut first) = (0.0, [0.0; 3]);
        for f in &cells {
            assert!(f.moments[0] <= 1.0 + 1e-12);
            volume += f.moments[0];
            for (a, at) in [1usize, 3, 9].into_iter().enumerate() {
                let middle = grid.cell(f.key)[a] as f64 + 0.5;
                first[a] += f.moments[0] * middle + 0.5 * f.moments[at];
            }
        }
        let [a, b, c] = [1, 2, 3].map(|i| sub(p[i], p[0]));
        let want = crate::elastic::vec3::dot(a, cross(b, c)).abs() / 6.0;
        assert!((volume - want).abs() < 1e-5, "{volume} {want}");
        for a in 0..3 {
            let mean = p.iter().map(|p| p[a]).sum::<f64>() / 4.0;
            assert!((first[a] - mean * want).abs() < 1e-4);
        }
    }

    #[test]
    fn a_sheet_weighs_area_times_thickness_wherever_it_lies() {
        let p = [
            [0.0, 0.0, 2.0],
            [4.0, 0.0, 2.0],
            [4.0, 4.0, 2.0],
            [0.0, 4.0, 2.0],
        ];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let pieces = find_pieces(&p, &triangles).list;
        let corners = |id: u32| triangles[id as usize].map(|v| p[v as usize]);
        for (z, thickness) in [(0.0, 0.2), (0.3, 0.2), (0.0, 2.5)] {
            let grid = Grid {
                origin: [0.0, 0.0, z],
                cell_size: 1.0,
                dims: [4, 4, 4],
            };
            let cells = fill(&grid, &pieces, &corners, thickness, 1000).unwrap_or_default();
            let volume: f64 = cells.iter().map(|f| f.moments[0]).sum();
            assert!((volume - 16.0 * thickness).abs() < 1e-9, "{volume}");
        }
    }
}
