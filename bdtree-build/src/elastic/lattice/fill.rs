//! What fills each cell: exact volume integrals from the surface alone.
//!
//! For a solid the moments come from the divergence theorem along x: a fragment of the surface adds
//! its own integral to its cell and its shadow to all cells before it in the row. A sheet thicker than
//! a cell is made of prisms, a thinner one is integrated over its area at two Gauss points through its
//! thickness, which carry its bending stiffness.

use crate::elastic::element::moments::{LINE, Moments, POWERS, powers};
use std::sync::atomic::AtomicUsize;

use crate::elastic::lattice::grid::Grid;
use crate::elastic::lattice::slice::Rules;
use crate::elastic::lattice::table::{
    Filling, Fillings, SHARE_MIN, Shadow, Sums, Table, TooManyCells,
};
use crate::elastic::surface::components::{Kind, SurfaceComponent};
use crate::parallel;
use crate::vec3::{add, cross, norm, scale, sub};

/// Slabs per thread, so that threads end at about the same time.
const SLABS_PER_THREAD: usize = 4;
/// Sheets are cut in the slabs' neighbours too: of thinner slabs that would be much of the work.
const SLAB_MIN: usize = 8;

/// What is integrated over: corners by triangle id, and the thickness of sheets (mesh units).
pub(crate) struct Material<'m> {
    pub surface: &'m [SurfaceComponent],
    pub corners: &'m (dyn Fn(u32) -> [[f64; 3]; 3] + Sync),
    pub thickness: f64,
}

/// Moments of every body in every cell it fills, sorted by cell, then body: the same for any number of threads.
///
/// Without `ALL`, of a cell's moments only the first is meant, its filled share: what is filled and hangs together
/// is the same to the last bit, in a fraction of the time.
pub(crate) fn fill<const ALL: bool>(
    grid: &Grid,
    material: &Material<'_>,
    limit: usize,
    threads: usize,
) -> Result<Fillings, TooManyCells> {
    let surface = material.surface;
    let several = surface.iter().any(|p| p.body != surface[0].body);
    // Sums take a kilobyte and more; cells that no surface meets, which have none, take little.
    let room = AtomicUsize::new(limit / 4);
    let rules = Rules::new();
    // Each cell's sums are those of one slab, which adds its triangles up in their order.
    let count = if threads > 1 {
        SLABS_PER_THREAD * threads
    } else {
        1
    };
    let slabs = grid.slabs(count, SLAB_MIN).into_iter();
    let mut parts: Vec<_> = slabs
        .map(|slab| (Table::new(slab, several, &room), Ok(())))
        .collect();
    let mut states = parallel::states(threads, || ());
    parallel::for_each(parts.iter_mut(), &mut states, |(), (table, outcome)| {
        *outcome = add_all::<ALL>(table, &rules, grid, material);
    });
    let (mut sums, mut touches) = (Vec::new(), Vec::new());
    for (table, outcome) in parts {
        outcome?;
        sums.extend(table.sums);
        touches.extend(table.touches);
    }
    let mut list = sweep(grid, sums, limit)?;
    list.sort_unstable_by_key(|f| (f.key, f.body));
    touches.sort_unstable();
    touches.dedup();
    Ok(Fillings { list, touches })
}

/// Adds all triangles to a table.
fn add_all<const ALL: bool>(
    table: &mut Table<'_>,
    rules: &Rules,
    grid: &Grid,
    material: &Material<'_>,
) -> Result<(), TooManyCells> {
    let Material {
        surface,
        corners,
        thickness,
    } = *material;
    for component in surface {
        let body = component.body as u32;
        for &(id, reverse) in &component.triangles {
            let triangle = corners(id);
            match component.kind {
                Kind::Solid => {
                    let sign = if reverse {
                        -component.sign
                    } else {
                        component.sign
                    };
                    add_solid::<ALL>(table, rules, grid, body, triangle, sign)?;
                }
                Kind::Sheet => {
                    add_sheet::<ALL>(table, rules, grid, body, triangle, (thickness, 1.0))?;
                }
                // It is there twice.
                Kind::Paper => {
                    add_sheet::<ALL>(table, rules, grid, body, triangle, (thickness, 0.5))?;
                }
            }
        }
        for &cap in &component.caps {
            add_solid::<ALL>(table, rules, grid, body, cap, component.sign)?;
        }
    }
    Ok(())
}

fn add_solid<const ALL: bool>(
    table: &mut Table,
    rules: &Rules,
    grid: &Grid,
    body: u32,
    triangle: [[f64; 3]; 3],
    sign: f64,
) -> Result<(), TooManyCells> {
    let own = table.slab;
    table.add_fragments(grid, body, triangle, &own, &mut |sums, cell, polygon| {
        let Some(sums) = sums else {
            return;
        };
        rules.integrate(polygon, &mut |p, vector| {
            let [x, y, z]: [f64; 3] = std::array::from_fn(|a| 2.0 * (p[a] - cell[a] as f64) - 1.0);
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
            if !ALL {
                sums.shadow[0] += w;
                sums.own[0] += w * primitive[0];
                return;
            }
            for (n, (shadow, own)) in (sums.shadow.iter_mut())
                .zip(sums.own.chunks_exact_mut(POWERS))
                .enumerate()
            {
                let share = w * y[n % POWERS] * z[n / POWERS];
                *shadow += share;
                for (own, f) in own.iter_mut().zip(primitive) {
                    *own += share * f;
                }
            }
        });
    })
}

/// A sheet's triangle with its thickness (mesh units); `weight` is the share of it that counts.
fn add_sheet<const ALL: bool>(
    table: &mut Table,
    rules: &Rules,
    grid: &Grid,
    body: u32,
    triangle: [[f64; 3]; 3],
    (thickness, weight): (f64, f64),
) -> Result<(), TooManyCells> {
    let [a, b, c] = triangle;
    let normal = cross(sub(b, a), sub(c, a));
    let length = norm(normal);
    if length.is_nan() || length <= 0.0 {
        return Ok(());
    }
    let normal = scale(normal, thickness / length);
    let moved = |share: f64| triangle.map(|p| add(p, scale(normal, share)));
    if thickness > grid.cell_size {
        // Layers would not fit the cells evenly: the prism that it is.
        let (low, high) = (moved(-0.5), moved(0.5));
        add_solid::<ALL>(table, rules, grid, body, high, weight)?;
        add_solid::<ALL>(table, rules, grid, body, [low[0], low[2], low[1]], weight)?;
        for i in 0..3 {
            let j = (i + 1) % 3;
            add_solid::<ALL>(table, rules, grid, body, [low[i], low[j], high[j]], weight)?;
            add_solid::<ALL>(table, rules, grid, body, [low[i], high[j], high[i]], weight)?;
        }
        return Ok(());
    }
    // Two Gauss layers carry the bending stiffness.
    let gauss = 1.0 / 12f64.sqrt();
    let depth = 0.5 * weight * thickness / grid.cell_size;
    let next = scale(normal, 2.0 * gauss / grid.cell_size);
    add_layer::<ALL>(table, rules, grid, body, (moved(-gauss), depth, next))?;
    add_layer::<ALL>(table, rules, grid, body, (moved(gauss), depth, [0.0; 3]))
}

/// One layer of a sheet: its triangle, the thickness it stands for and the way to the next one
/// (cells).
fn add_layer<const ALL: bool>(
    table: &mut Table,
    rules: &Rules,
    grid: &Grid,
    body: u32,
    (layer, depth, next): ([[f64; 3]; 3], f64, [f64; 3]),
) -> Result<(), TooManyCells> {
    // Cells whose lower face lies between this layer and the next, with the face's axis: fragments in the next slabs'
    // cells know of some too.
    let mut between = Vec::new();
    let around = table.slab.widened();
    table.add_fragments(grid, body, layer, &around, &mut |sums, cell, polygon| {
        let corners = polygon.corners();
        let edges = || (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
        for (p, q) in edges() {
            let other = grid.cell_of(add(scale(add(p, q), 0.5), next));
            let mut differing = (0..3).filter(|&a| other[a] != cell[a]);
            if let (Some(axis), None) = (differing.next(), differing.next()) {
                let mut upper = cell;
                upper[axis] = cell[axis].max(other[axis]);
                between.push((upper, axis));
            }
        }
        let Some(sums) = sums else {
            return;
        };
        for (p, q) in edges() {
            for (a, crossed) in sums.crossed.iter_mut().enumerate() {
                let plane = cell[a] as f64;
                // Cutting puts corners exactly into the plane.
                if p[a] == plane && q[a] == plane {
                    *crossed += norm(sub(q, p)) * depth;
                }
            }
        }
        rules.integrate(polygon, &mut |p, vector| {
            let w = norm(vector) * depth;
            if !ALL {
                sums.own[0] += w;
                return;
            }
            let [x, y, z]: [[f64; POWERS]; 3] =
                std::array::from_fn(|a| powers(2.0 * (p[a] - cell[a] as f64) - 1.0));
            let plane: [f64; POWERS * POWERS] =
                std::array::from_fn(|n| w * x[n % POWERS] * y[n / POWERS]);
            for (own, z) in sums.own.chunks_exact_mut(plane.len()).zip(z) {
                for (own, share) in own.iter_mut().zip(plane) {
                    *own += share * z;
                }
            }
        });
    })?;
    between.retain(|(upper, _)| table.slab.contains(*upper));
    for (upper, axis) in between {
        table.entry(grid.key(upper), body)?.crossed[axis] += 1.0;
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
    use crate::elastic::element::moments::full_cell;
    use crate::elastic::surface::components::find_components;

    /// What fills a small lattice.
    fn filled(
        grid: &Grid,
        surface: &[SurfaceComponent],
        corners: &(dyn Fn(u32) -> [[f64; 3]; 3] + Sync),
        thickness: f64,
    ) -> Vec<Filling> {
        let material = Material {
            surface,
            corners,
            thickness,
        };
        let filled = fill::<true>(grid, &material, 1000, 1);
        filled.unwrap_or_default().list
    }

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
        let surface = find_components(&p, &triangles).list;
        let corners = |id: u32| triangles[id as usize].map(|v| p[v as usize]);
        let cells = filled(&grid, &surface, &corners, 0.1);
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
        let want = crate::vec3::dot(a, cross(b, c)).abs() / 6.0;
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
        let surface = find_components(&p, &triangles).list;
        let corners = |id: u32| triangles[id as usize].map(|v| p[v as usize]);
        for (z, thickness) in [(0.0, 0.2), (0.3, 0.2), (0.0, 2.5)] {
            let grid = Grid {
                origin: [0.0, 0.0, z],
                cell_size: 1.0,
                dims: [4, 4, 4],
            };
            let cells = filled(&grid, &surface, &corners, thickness);
            let volume: f64 = cells
                .iter()
                .map(|f| f.moments.as_ref().map_or(1.0, |m| m[0]))
                .sum();
            assert!((volume - 16.0 * thickness).abs() < 1e-9, "{volume}");
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
            let mut surface = find_components(&p, &triangles).list;
            surface[1].body = 0;
            let corners = |id: u32| triangles[id as usize].map(|v: u32| p[v as usize]);
            let grid = Grid {
                origin: [0.0; 3],
                cell_size: 1.0,
                dims: [4; 3],
            };
            let cells = filled(&grid, &surface, &corners, 0.1);
            assert_eq!(cells.len(), 64);
            for f in cells {
                let want = [0.0, 1.0, 0.0, 1.0][grid.cell(f.key)[axis]];
                assert!((f.faces[axis] - want).abs() < 1e-12, "{axis} {f:?}");
            }
        }
    }
}
