//! Moments of the filled part of each cell: exact volume integrals from the surface alone.
//!
//! The stiffness and the mass of a partly filled cell are integrals of polynomials of degree four
//! per coordinate over its filled part, so 125 numbers per cell say all about the filling (the
//! finite-cell method with moments instead of sub-cells). For a solid they come from the
//! divergence theorem along x: a fragment of the surface adds its own integral to its cell and
//! its shadow to all cells before it in the row. A sheet is integrated over its area at Gauss
//! points through its thickness, which carries its bending stiffness.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::pieces::{Kind, Piece};
use super::slice::{Polygon, Rules, for_each_fragment};
use super::vec3::{add, cross, norm, scale, sub};

/// Powers of a coordinate in a product of two quadratic functions: 0 to 4.
pub(crate) const POWERS: usize = 5;

/// ⅛ ∫ ξᵃ ηᵇ ζᶜ over the filled part, in [-1, 1]³, at `a + 5b + 25c`; entry 0 is the filled share.
pub(crate) type Moments = [f64; POWERS * POWERS * POWERS];

/// Moments in η and ζ of what lies between a surface and the lower end of its row.
type Shadow = [f64; POWERS * POWERS];

/// ½ ∫ ξᵃ over [-1, 1].
const LINE: [f64; POWERS] = [1.0, 0.0, 1.0 / 3.0, 0.0, 0.2];

/// Moments of a cell that is filled.
pub(crate) fn full_cell() -> Moments {
    std::array::from_fn(|n| LINE[n % 5] * LINE[n / 5 % 5] * LINE[n / 25])
}

/// Adds the moments of one of a cell's eight parts to those of the cell. `upper` says on which
/// axes the part is the upper one.
pub(crate) fn add_eighth(sum: &mut Moments, part: &Moments, upper: [bool; 3]) {
    // ξ = (ξ' ± 1) / 2, so ξᵃ = 2⁻ᵃ Σ C(a, k) ξ'ᵏ (±1)ᵃ⁻ᵏ; the part has half the length.
    const BINOMIALS: [[f64; POWERS]; POWERS] = [
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0, 0.0],
        [1.0, 2.0, 1.0, 0.0, 0.0],
        [1.0, 3.0, 3.0, 1.0, 0.0],
        [1.0, 4.0, 6.0, 4.0, 1.0],
    ];
    let mut values = *part;
    for (axis, stride) in [1, 5, 25].into_iter().enumerate() {
        let sign: f64 = if upper[axis] { 1.0 } else { -1.0 };
        for start in (0..values.len()).filter(|n| n / stride % POWERS == 0) {
            let line: [f64; POWERS] = std::array::from_fn(|k| values[start + k * stride]);
            for (a, row) in BINOMIALS.iter().enumerate() {
                let terms = (0..=a).map(|k| row[k] * line[k] * sign.powi((a - k) as i32));
                values[start + a * stride] = 0.5f64.powi(a as i32 + 1) * terms.sum::<f64>();
            }
        }
    }
    for (s, v) in sum.iter_mut().zip(&values) {
        *s += v;
    }
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
struct Sums {
    key: u64,
    body: u32,
    own: Moments,
    shadow: Shadow,
    /// What its surface adds to the covered shares of the lower y and z faces here and below.
    flux: [f64; 2],
    /// Above 0 for those of its own lower faces that a sheet reaches through.
    crossed: [f64; 3],
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

struct Table {
    /// Whether touches are wanted.
    several: bool,
    touches: Vec<Touch>,
    index: HashMap<(u64, u32), usize, BuildHasherDefault<KeyHasher>>,
    sums: Vec<Sums>,
    last: usize,
    limit: usize,
}

impl Table {
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

/// Calls `visit` with the corners of each triangle of the sheet's layers, the thickness that layer
/// stands for and the way to the next one: two Gauss layers per cell size of thickness.
pub(crate) fn for_each_layer(
    triangle: [[f64; 3]; 3],
    thickness: f64,
    cell_size: f64,
    visit: &mut impl FnMut([[f64; 3]; 3], f64, [f64; 3]),
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
    let height = |layer: usize| {
        let middle = ((layer / 2) as f64 + 0.5) * step - 0.5 * thickness;
        let gauss = if layer.is_multiple_of(2) { -1.0 } else { 1.0 };
        middle + gauss * step / 12f64.sqrt()
    };
    for layer in 0..2 * slices {
        let shift = scale(normal, height(layer));
        let next = if layer + 1 < 2 * slices {
            scale(normal, height(layer + 1) - height(layer))
        } else {
            [0.0; 3]
        };
        visit(triangle.map(|p| add(p, shift)), 0.5 * step, next);
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
) -> Result<Fillings, TooManyCells> {
    let mut table = Table {
        several: pieces.iter().any(|p| p.body != pieces[0].body),
        touches: Vec::new(),
        index: HashMap::default(),
        sums: Vec::new(),
        last: 0,
        limit,
    };
    let rules = Rules::new();
    for piece in pieces {
        let body = piece.body as u32;
        for &(id, reverse) in &piece.triangles {
            let triangle = corners(id);
            match piece.kind {
                Kind::Solid => {
                    let sign = if reverse { -piece.sign } else { piece.sign };
                    add_solid(&mut table, &rules, grid, body, triangle, sign)?;
                }
                Kind::Sheet => add_sheet(&mut table, &rules, grid, body, triangle, thickness)?,
                Kind::Paper => {
                    add_sheet(&mut table, &rules, grid, body, triangle, 0.5 * thickness)?
                }
            }
        }
        for &cap in &piece.caps {
            add_solid(&mut table, &rules, grid, body, cap, piece.sign)?;
        }
    }
    let mut list = sweep(grid, table.sums, limit)?;
    list.sort_unstable_by_key(|f| (f.key, f.body));
    let mut touches = table.touches;
    touches.sort_unstable();
    touches.dedup();
    Ok(Fillings { list, touches })
}

fn powers(x: f64) -> [f64; POWERS] {
    [1.0, x, x * x, x * x * x, x * x * x * x]
}

fn add_solid(
    table: &mut Table,
    rules: &Rules,
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
            rules.integrate(polygon, &mut |p, vector| {
                let [x, y, z]: [f64; 3] =
                    std::array::from_fn(|a| 2.0 * (p[a] - cell[a] as f64) - 1.0);
                sums.flux[0] += sign * vector[1];
                sums.flux[1] += sign * vector[2];
                let (y, z, w) = (powers(y), powers(z), 0.5 * sign * vector[0]);
                let x = powers(x);
                let primitive: [f64; POWERS] = [
                    x[1] + 1.0,
                    (x[2] - 1.0) / 2.0,
                    (x[3] + 1.0) / 3.0,
                    (x[4] - 1.0) / 4.0,
                    (x[4] * x[1] + 1.0) / 5.0,
                ];
                for (n, sum) in sums.shadow.iter_mut().enumerate() {
                    let shadow = w * y[n % 5] * z[n / 5];
                    *sum += shadow;
                    for (own, f) in sums.own[5 * n..].iter_mut().zip(primitive) {
                        *own += shadow * f;
                    }
                }
            });
            table.note_touches(grid, body, cell, polygon);
        },
    );
    outcome
}

fn add_sheet(
    table: &mut Table,
    rules: &Rules,
    grid: &Grid,
    body: u32,
    triangle: [[f64; 3]; 3],
    thickness: f64,
) -> Result<(), TooManyCells> {
    let mut outcome = Ok(());
    for_each_layer(
        triangle,
        thickness,
        grid.cell_size,
        &mut |layer, depth, next| {
            let depth = depth / grid.cell_size;
            let next = scale(next, 1.0 / grid.cell_size);
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
                    let corners = polygon.corners();
                    for (i, &p) in corners.iter().enumerate() {
                        let q = corners[(i + 1) % corners.len()];
                        for (a, crossed) in sums.crossed.iter_mut().enumerate() {
                            let plane = cell[a] as f64;
                            // Cutting puts corners exactly into the plane.
                            if p[a] == plane && q[a] == plane {
                                *crossed += norm(sub(q, p)) * depth;
                            }
                        }
                    }
                    rules.integrate(polygon, &mut |p, vector| {
                        let local: [[f64; POWERS]; 3] =
                            std::array::from_fn(|a| powers(2.0 * (p[a] - cell[a] as f64) - 1.0));
                        let w = norm(vector) * depth;
                        for (n, sum) in sums.own.iter_mut().enumerate() {
                            *sum += w * local[0][n % 5] * local[1][n / 5 % 5] * local[2][n / 25];
                        }
                    });
                    table.note_touches(grid, body, cell, polygon);
                    outcome = cover_to_next(table, grid, body, (cell, polygon), next);
                },
            );
        },
    );
    outcome
}

/// Covers the faces between a fragment of one layer of a sheet and the next layer.
fn cover_to_next(
    table: &mut Table,
    grid: &Grid,
    body: u32,
    (cell, polygon): ([usize; 3], &Polygon),
    next: [f64; 3],
) -> Result<(), TooManyCells> {
    let corners = polygon.corners();
    for (i, &p) in corners.iter().enumerate() {
        let middle = scale(add(p, corners[(i + 1) % corners.len()]), 0.5);
        let other = grid.cell_of(add(middle, next));
        let mut differing = (0..3).filter(|&a| other[a] != cell[a]);
        if let (Some(axis), None) = (differing.next(), differing.next()) {
            let upper = if other[axis] > cell[axis] {
                other
            } else {
                cell
            };
            table.entry(grid.key(upper), body)?.crossed[axis] += 1.0;
        }
    }
    Ok(())
}

/// Hands the shadows down each row and keeps the cells that are filled.
fn sweep(grid: &Grid, mut sums: Vec<Sums>, limit: usize) -> Result<Vec<Filling>, TooManyCells> {
    let nx = grid.dims[0] as u64;
    sums.sort_unstable_by_key(|s| (s.body, s.key));
    let mut result = Vec::with_capacity(sums.len());
    let with_shadow = |own: &Moments, shadow: &Shadow| -> Moments {
        std::array::from_fn(|n| own[n] + 2.0 * LINE[n % 5] * shadow[n / 5])
    };
    let mut keep = |filling: Filling| {
        let share = filling.moments.as_ref().map_or(1.0, |m| m[0]);
        if share > SHARE_MIN {
            if result.len() >= limit {
                return Err(TooManyCells);
            }
            result.push(filling);
        }
        Ok(())
    };
    for row in sums.chunk_by(|a, b| (a.body, a.key / nx) == (b.body, b.key / nx)) {
        let mut shadow = [0.0; 25];
        for (n, own) in row.iter().enumerate().rev() {
            let moments = with_shadow(&own.own, &shadow);
            for (s, add) in shadow.iter_mut().zip(&own.shadow) {
                *s += add;
            }
            let [x, y, z] = own.crossed;
            let covered = 2.0 * shadow[0];
            keep(Filling {
                key: own.key,
                body: own.body,
                moments: (moments[0] < 1.0).then(|| Box::new(moments)),
                faces: [covered + x, y, z],
            })?;
            // No surface in between: these cells are filled or they are not.
            let previous = if n > 0 { row[n - 1].key + 1 } else { own.key };
            if covered > 0.5 {
                for key in (previous..own.key).rev() {
                    keep(Filling {
                        key,
                        body: own.body,
                        moments: None,
                        faces: [covered, 0.0, 0.0],
                    })?;
                }
            }
        }
    }
    cover_faces(grid, &sums, &mut result);
    Ok(result)
}

/// Adds what of the lower y and z faces is covered: like the shadow, handed down each column.
fn cover_faces(grid: &Grid, sums: &[Sums], fillings: &mut [Filling]) {
    for axis in [1, 2] {
        let line = |key: u64| {
            let mut cell = grid.cell(key);
            let at = std::mem::take(&mut cell[axis]);
            (grid.key(cell), at)
        };
        // Body, column, place in it from above; its flux, or the filling that wants to know.
        let fluxes = sums.iter().map(|s| (s.body, s.key, s.flux[axis - 1], None));
        let wishes = (fillings.iter().enumerate()).map(|(n, f)| (f.body, f.key, 0.0, Some(n)));
        let mut entries: Vec<_> = fluxes
            .chain(wishes)
            .map(|(body, key, flux, wish)| {
                let (column, at) = line(key);
                ((body, column, std::cmp::Reverse(at), wish), flux)
            })
            .collect();
        entries.sort_unstable_by_key(|e| e.0);
        let mut share = 0.0;
        let mut last = None;
        for ((body, column, _, wish), flux) in entries {
            if last != Some((body, column)) {
                (share, last) = (0.0, Some((body, column)));
            }
            share += flux;
            if let Some(n) = wish {
                fillings[n].faces[axis] += share;
            }
        }
    }
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
        let cells = fill(&grid, &pieces, &corners, 0.1, 1000)
            .unwrap_or_default()
            .list;
        let (mut volume, mut first) = (0.0, [0.0; 3]);
        for f in &cells {
            let moments = f.moments.as_deref().copied().unwrap_or(full_cell());
            assert!(moments[0] <= 1.0 + 1e-12);
            volume += moments[0];
            for (a, at) in [1usize, 5, 25].into_iter().enumerate() {
                let middle = grid.cell(f.key)[a] as f64 + 0.5;
                first[a] += moments[0] * middle + 0.5 * moments[at];
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
            let cells = fill(&grid, &pieces, &corners, thickness, 1000)
                .unwrap_or_default()
                .list;
            let volume: f64 = cells
                .iter()
                .map(|f| f.moments.as_ref().map_or(1.0, |m| m[0]))
                .sum();
            assert!((volume - 16.0 * thickness).abs() < 1e-9, "{volume}");
        }
    }

    #[test]
    fn eighths_of_a_full_cell_make_a_full_cell() {
        let mut sum = [0.0; 125];
        for n in 0..8 {
            add_eighth(&mut sum, &full_cell(), [0, 1, 2].map(|a| n >> a & 1 == 1));
        }
        for (a, b) in sum.iter().zip(full_cell()) {
            assert!((a - b).abs() < 1e-15, "{a} {b}");
        }
    }

    /// Faces are covered where material reaches through them, not where it stands on both sides.
    #[test]
    fn a_gap_leaves_its_faces_bare() {
        let faces = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        for axis in 0..3 {
            // Two slabs of one body across the whole lattice, from 0.5 to 1.8 and 2.1 to 3.5.
            let (mut p, mut triangles) = (Vec::new(), Vec::new());
            for (lo, hi) in [(0.5, 1.8), (2.1, 3.5)] {
                let first = p.len() as u32;
                for n in 0..8 {
                    p.push([0, 1, 2].map(|a| match (n >> a & 1 == 1, a == axis) {
                        (false, true) => lo,
                        (true, true) => hi,
                        (false, false) => 0.0,
                        (true, false) => 4.0,
                    }));
                }
                triangles.extend(faces.map(|t: [u32; 3]| t.map(|v| v + first)));
            }
            let mut pieces = find_pieces(&p, &triangles).list;
            pieces[1].body = 0;
            let corners = |id: u32| triangles[id as usize].map(|v: u32| p[v as usize]);
            let grid = Grid {
                origin: [0.0; 3],
                cell_size: 1.0,
                dims: [4; 3],
            };
            let cells = fill(&grid, &pieces, &corners, 0.1, 1000)
                .unwrap_or_default()
                .list;
            assert_eq!(cells.len(), 64);
            for f in cells {
                let want = [0.0, 1.0, 0.0, 1.0][grid.cell(f.key)[axis]];
                assert!((f.faces[axis] - want).abs() < 1e-12, "{axis} {f:?}");
            }
        }
    }
}
