//! A mesh and the lattices of several sizes it is put into.

use crate::elastic::element::moments::{Moments, add_eighth, full_cell};
use crate::elastic::lattice::connect::connect;
use crate::elastic::lattice::fill::{Material, fill};
use crate::elastic::lattice::grid::Grid;
use crate::elastic::lattice::table::TooManyCells;
use crate::elastic::lattice::{FINE, Lattice};
use crate::elastic::surface::components::{Kind, SurfaceComponents};
use crate::input::RawMesh;
use crate::vec3::{add, cross, norm, scale, sub};

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
