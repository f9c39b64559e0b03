//! The lattice of filled cells: which are connected, and which spline functions act on them.

pub(crate) mod fill;
pub(crate) mod grid;
pub(crate) mod locate;
pub(crate) mod resolution;
pub(crate) mod slice;
mod system;
pub(crate) mod table;

use std::collections::HashMap;

use crate::disjoint_sets::DisjointSets;
use crate::elastic::element::moments::{Moments, add_eighth, full_cell};
use crate::elastic::element::spline::FUNCTIONS;
use crate::elastic::lattice::fill::{Material, fill};
use crate::elastic::lattice::grid::Grid;
use crate::elastic::lattice::table::{Filling, Fillings, SHARE_MIN, TooManyCells};
use crate::elastic::surface::components::{Kind, SurfaceComponents};
use crate::input::RawMesh;
use crate::vec3::{add, cross, norm, scale, sub};

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
    /// Its surface components.
    pub surface: SurfaceComponents,
    /// Thickness of sheets (mesh units).
    pub thickness: f64,
    /// Threads to work with; lattices do not depend on it.
    pub threads: usize,
    min: [f64; 3],
    max: [f64; 3],
    /// Of solids and of sheets: number, edge lengths and areas of the triangles.
    sizes: [[f64; 3]; 2],
}

impl<'a> Subject<'a> {
    /// Measures the box of the material, sheets with their thickness. Needs a surface component at least.
    pub(crate) fn new(mesh: &'a RawMesh, surface: SurfaceComponents, thickness: f64) -> Self {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut take = |p: [f64; 3]| {
            for a in 0..3 {
                min[a] = min[a].min(p[a]);
                max[a] = max[a].max(p[a]);
            }
        };
        let mut sizes = [[0.0; 3]; 2];
        for component in &surface.list {
            let is_sheet = component.kind != Kind::Solid;
            for &(id, _) in &component.triangles {
                let [a, b, c] = mesh.triangles[id as usize].map(|v| mesh.positions[v as usize]);
                let edges = [sub(b, a), sub(c, b), sub(a, c)];
                let n = cross(edges[0], edges[1]);
                let length = norm(n);
                let of = &mut sizes[usize::from(is_sheet)];
                of[0] += 1.0;
                of[1] += edges.map(norm).iter().sum::<f64>();
                of[2] += 0.5 * length;
                let half = if is_sheet && length > 0.0 {
                    scale(n, 0.5 * thickness / length)
                } else {
                    [0.0; 3]
                };
                for p in [a, b, c] {
                    take(add(p, half));
                    take(sub(p, half));
                }
            }
        }
        Self {
            mesh,
            surface,
            thickness,
            threads: 1,
            min,
            max,
            sizes,
        }
    }

    /// About how much [`Subject::lattice`] has to integrate, in small triangles: what it takes besides
    /// its cells. Where many large triangles lie on each other, cells say nothing about it.
    pub(crate) fn surface_work(&self, resolution: f64) -> f64 {
        /// A surface component as large as a cell is given this many times the points.
        const FULL: f64 = 16.0;
        let cell_size = self.grid(resolution).cell_size / FINE as f64;
        // A sheet has two layers, or is made of the eight triangles of a prism.
        let layers = if self.thickness > cell_size { 8.0 } else { 2.0 };
        let of = |[count, lengths, area]: [f64; 3]| {
            count + lengths / cell_size + FULL * area / (cell_size * cell_size)
        };
        of(self.sizes[0]) + layers * of(self.sizes[1])
    }

    /// Triangles of its surface components.
    pub(crate) fn triangle_count(&self) -> f64 {
        self.sizes[0][0] + self.sizes[1][0]
    }

    /// The grid with this many cells along the longest side, centered on the material's box so
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
        let mut lattice = self.connected::<true>(resolution, limit)?;
        integrate(&mut lattice);
        Ok(lattice)
    }

    /// [`Subject::lattice`] without moments: parts, components and nodes are the same.
    ///
    /// # Errors
    /// More than `limit` cells.
    pub(crate) fn outline(&self, resolution: f64, limit: usize) -> Result<Lattice, TooManyCells> {
        self.connected::<false>(resolution, limit)
    }

    fn connected<const ALL: bool>(
        &self,
        resolution: f64,
        limit: usize,
    ) -> Result<Lattice, TooManyCells> {
        let grid = self.grid(resolution);
        let fine = Grid {
            cell_size: grid.cell_size / FINE as f64,
            dims: grid.dims.map(|n| n * FINE),
            ..grid
        };
        let mesh = self.mesh;
        let corners = |id: u32| mesh.triangles[id as usize].map(|v| mesh.positions[v as usize]);
        let limit = limit.saturating_mul(FINE.pow(3));
        let material = Material {
            surface: &self.surface.list,
            corners: &corners,
            thickness: self.thickness,
        };
        let fillings = fill::<ALL>(&fine, &material, limit, self.threads)?;
        Ok(connect(grid, fine, fillings))
    }
}

/// Two parts that are connected: the lower one, the upper one, and the axis between them.
type Link = (u32, u32, u8);

/// Finds parts and components. Fine cells hang together where one body reaches through the face
/// between them. Bodies are joined where they share a fine cell or nearly do, so that whether
/// bodies that touch are joined does not depend on where the lattice lies.
fn connect(grid: Grid, fine: Grid, fillings: Fillings) -> Lattice {
    let Fillings { list, touches } = fillings;
    let count = list.len();
    let mut lattice = Lattice {
        grid,
        fine,
        fillings: list,
        part_of: vec![0; count],
        parts: Vec::new(),
        components: Vec::new(),
    };
    let cells: Vec<[usize; 3]> = (lattice.fillings.iter())
        .map(|f| fine.cell(f.key).map(|n| n / FINE))
        .collect();
    let mut sets = DisjointSets::new(count);
    let mut across: Vec<(usize, usize, u8)> = Vec::new();
    for (here, f) in lattice.fillings.iter().enumerate() {
        if here > 0 && lattice.fillings[here - 1].key == f.key {
            sets.join(here - 1, here);
        }
        for axis in 0..3 {
            let mut next = fine.cell(f.key);
            next[axis] += 1;
            if next[axis] >= fine.dims[axis] {
                continue;
            }
            let Some(there) = lattice.find(fine.key(next), f.body) else {
                continue;
            };
            if lattice.fillings[there].faces[axis].abs() <= SHARE_MIN {
                continue;
            }
            if cells[here] == cells[there] {
                sets.join(here, there);
            } else {
                across.push((here, there, axis as u8));
            }
        }
    }
    for (from, to, body) in touches {
        let Some(one) = lattice.find(from, body) else {
            continue;
        };
        let first = lattice.fillings.partition_point(|f| f.key < to);
        let others = lattice.fillings[first..].iter().enumerate();
        for (n, f) in others.take_while(|(_, f)| f.key == to) {
            let other = first + n;
            if f.body == body {
                continue;
            }
            if cells[one] == cells[other] {
                sets.join(one, other);
            } else if let Some(axis) = (0..3).find(|&a| cells[one][a] != cells[other][a]) {
                let (lower, upper) = if from < to {
                    (one, other)
                } else {
                    (other, one)
                };
                across.push((lower, upper, axis as u8));
            }
        }
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&n| (grid.key(cells[n]), n));
    for own in order.chunk_by(|&a, &b| cells[a] == cells[b]) {
        for &n in own {
            let root = sets.find(n);
            if root == n {
                lattice.part_of[n] = lattice.parts.len() as u32;
                lattice.parts.push(CellPart {
                    cell: cells[n],
                    component: 0,
                    place: 0,
                });
            }
            lattice.part_of[n] = lattice.part_of[root];
        }
    }
    let part = |n: usize| lattice.part_of[n];
    let mut links: Vec<Link> = (across.iter())
        .map(|&(a, b, axis)| (part(a), part(b), axis))
        .collect();
    links.sort_unstable();
    links.dedup();
    gather(&mut lattice, &links);
    number_nodes(&mut lattice, &links);
    lattice
}

/// Puts the parts into components.
fn gather(lattice: &mut Lattice, links: &[Link]) {
    let mut sets = DisjointSets::new(lattice.parts.len());
    for &(a, b, _) in links {
        sets.join(a as usize, b as usize);
    }
    let mut number: HashMap<usize, u32> = HashMap::new();
    for n in 0..lattice.parts.len() {
        let next = number.len() as u32;
        let component = *number.entry(sets.find(n)).or_insert(next);
        if component == next {
            lattice.components.push(Component::default());
        }
        let own = &mut lattice.components[component as usize];
        lattice.parts[n].component = component;
        lattice.parts[n].place = own.cells.len() as u32;
        own.cells.push([0; FUNCTIONS]);
    }
}

/// Gives the components what fills their parts.
fn integrate(lattice: &mut Lattice) {
    let mut moments: Vec<Moments> = vec![[0.0; 125]; lattice.parts.len()];
    let mut start = 0;
    while start < lattice.fillings.len() {
        // What fills one part of a fine cell: overlapping bodies fill it once.
        let key = lattice.fillings[start].key;
        let own = lattice.part_of[start];
        let mut end = start;
        let mut total = [0.0; 125];
        while end < lattice.fillings.len() && lattice.fillings[end].key == key {
            let full = full_cell();
            let filling = lattice.fillings[end].moments.as_deref().unwrap_or(&full);
            for (t, m) in total.iter_mut().zip(filling) {
                *t += m;
            }
            end += 1;
        }
        if total[0] > 1.0 - 1e-9 {
            total = full_cell();
        }
        let upper = lattice.fine.cell(key).map(|n| n % FINE == 1);
        add_eighth(&mut moments[own as usize], &total, upper);
        start = end;
    }
    for (part, mut moments) in lattice.parts.iter().zip(moments) {
        if moments[0] > 1.0 - 1e-9 {
            moments = full_cell();
        }
        // Parts stand in their components in their own order.
        let own = &mut lattice.components[part.component as usize];
        own.moments.push(moments);
    }
}

/// Gives every place its nodes: one for each group of parts in the 27 cells around it that hang
/// together over faces *there*. So cells that merely touch stay apart, be it two bodies in
/// neighbouring cells or two cells of one body that meet in an edge, which would be a hinge; and
/// two walls of one body with a gap between them move apart.
fn number_nodes(lattice: &mut Lattice, links: &[Link]) {
    let [nx, ny, _] = lattice.grid.dims.map(|n| n as u64 + 2);
    let mut uses: Vec<(u64, u32, u8)> = Vec::with_capacity(FUNCTIONS * lattice.parts.len());
    for (n, part) in lattice.parts.iter().enumerate() {
        for function in 0..FUNCTIONS {
            let step = [function % 3, function / 3 % 3, function / 9];
            let [i, j, k] = [0, 1, 2].map(|a| (part.cell[a] + step[a]) as u64);
            uses.push(((k * ny + j) * nx + i, n as u32, function as u8));
        }
    }
    uses.sort_unstable();
    for around in uses.chunk_by(|a, b| a.0 == b.0) {
        let mut sets = DisjointSets::new(around.len());
        for (n, &(_, lower, function)) in around.iter().enumerate() {
            let first = links.partition_point(|l| l.0 < lower);
            for &(_, upper, axis) in links[first..].iter().take_while(|l| l.0 == lower) {
                // The lower cell of two has the place farther up on that axis.
                let stride = [1, 3, 9][usize::from(axis)];
                if usize::from(function) / stride % 3 > 0
                    && let Ok(m) = around.binary_search_by_key(&upper, |u| u.1)
                {
                    sets.join(n, m);
                }
            }
        }
        let mut nodes = vec![0u32; around.len()];
        for (n, &(_, part, function)) in around.iter().enumerate() {
            let part = lattice.parts[part as usize];
            let function = usize::from(function);
            let root = sets.find(n);
            let own = &mut lattice.components[part.component as usize];
            if root == n {
                nodes[n] = own.nodes.len() as u32;
                let step = [function % 3, function / 3 % 3, function / 9];
                own.nodes
                    .push([0, 1, 2].map(|a| part.cell[a] as i32 + step[a] as i32 - 1));
            }
            own.cells[part.place as usize][function] = nodes[root];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::surface::components::find_components;

    /// A solid and a tilted sheet.
    fn mesh() -> RawMesh {
        let solid = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        RawMesh {
            positions: vec![
                [0.1, 0.2, 0.3],
                [5.3, 0.7, 1.1],
                [1.3, 4.9, 0.4],
                [2.2, 1.7, 6.1],
                [0.0, 0.0, 7.0],
                [6.0, 0.3, 7.2],
                [5.8, 6.1, 6.7],
            ],
            triangles: [&solid[..], &[[4, 5, 6]]].concat(),
            ..RawMesh::default()
        }
    }

    fn subject(mesh: &RawMesh, thickness: f64) -> Subject<'_> {
        let surface = find_components(&mesh.positions, &mesh.triangles);
        Subject::new(mesh, surface, thickness)
    }

    /// Threads take slabs, and each adds up in a cell what one thread would, in its order.
    #[test]
    fn threads_do_not_change_a_bit() {
        let mesh = mesh();
        for thickness in [0.05, 1.0] {
            let [one, several] = [1, 3].map(|threads| {
                let mut subject = subject(&mesh, thickness);
                subject.threads = threads;
                subject.lattice(24.3, 100_000).expect("few cells")
            });
            assert!(one.parts.len() > 500, "{}", one.parts.len());
            let bits = |lattice: &Lattice| -> Vec<_> {
                let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let fillings = lattice.fillings.iter();
                fillings
                    .map(|f| {
                        (
                            f.key,
                            f.body,
                            bits(&f.faces),
                            f.moments.as_ref().map(|m| bits(&**m)),
                        )
                    })
                    .collect()
            };
            assert_eq!(bits(&one), bits(&several));
            for (a, b) in one.components.iter().zip(&several.components) {
                assert_eq!((&a.nodes, &a.cells), (&b.nodes, &b.cells));
                assert_eq!(a.moments, b.moments);
            }
        }
    }

    /// Parts, components and nodes do not depend on whether moments are summed: of a solid, and of sheets thinner
    /// and thicker than a fine cell.
    #[test]
    fn an_outline_is_the_lattice_without_moments() {
        let mesh = mesh();
        for thickness in [0.05, 1.0] {
            let subject = subject(&mesh, thickness);
            for resolution in [5.0, 9.3] {
                let [outline, lattice] = [
                    subject.outline(resolution, 10_000).expect("few cells"),
                    subject.lattice(resolution, 10_000).expect("few cells"),
                ];
                assert!(lattice.parts.len() > 20, "{}", lattice.parts.len());
                let parts = |lattice: &Lattice| -> Vec<_> {
                    let parts = lattice.parts.iter();
                    parts.map(|p| (p.cell, p.component, p.place)).collect()
                };
                assert_eq!(parts(&outline), parts(&lattice));
                assert_eq!(outline.part_of, lattice.part_of);
                let fillings = |lattice: &Lattice| -> Vec<_> {
                    let fillings = lattice.fillings.iter();
                    fillings.map(|f| (f.key, f.body, f.faces)).collect()
                };
                assert_eq!(fillings(&outline), fillings(&lattice));
                for (a, b) in outline.components.iter().zip(&lattice.components) {
                    assert_eq!((&a.nodes, &a.cells), (&b.nodes, &b.cells));
                }
            }
        }
    }
}
