//! Which points `--fix` holds.

use crate::elastic::assemble::constraint::Constraint;
use crate::elastic::lattice::grid::Slab;
use crate::elastic::lattice::locate::anchor;
use crate::elastic::lattice::slice::{Rules, for_each_fragment};
use crate::elastic::lattice::{Lattice, Subject};

/// A region to hold, as the lattice sees it.
#[derive(Debug, Clone)]
pub(crate) enum Region<'a> {
    /// Box in mesh units, inclusive.
    Box {
        /// Lower corner.
        min: [f64; 3],
        /// Upper corner.
        max: [f64; 3],
    },
    /// Triangle ids.
    Triangles(&'a [std::ops::Range<u32>]),
    /// Vertices, ascending, and the triangles that have no other corners.
    Vertices(&'a [u32]),
}

impl Region<'_> {
    /// Whether it holds of a triangle all that lies in its box.
    fn takes(&self, id: u32, corners: [u32; 3]) -> bool {
        match self {
            Self::Box { .. } => true,
            Self::Triangles(ranges) => ranges.iter().any(|r| r.contains(&id)),
            Self::Vertices(list) => corners.iter().all(|c| list.binary_search(c).is_ok()),
        }
    }
}

/// What a region holds.
#[derive(Debug, Default)]
pub(crate) struct Constrained {
    /// Its points.
    pub constraints: Vec<Constraint>,
    /// Whether no point of the surface lies outside the region.
    pub everything: bool,
}

/// The points that a region holds along `axes`: of the surface in the region the corners and
/// inner points of its fragments (16 and more in a cell) and, in a box, those of full cells.
pub(crate) fn constrain(
    subject: &Subject<'_>,
    lattice: &Lattice,
    region: &Region<'_>,
    axes: [bool; 3],
) -> Constrained {
    let grid = &lattice.grid;
    let slack = 1e-6;
    let (lo, hi) = match region {
        Region::Box { min, max } => (
            grid.local(*min).map(|x| x - slack),
            grid.local(*max).map(|x| x + slack),
        ),
        _ => ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]),
    };
    let inside = |p: [f64; 3]| (0..3).all(|a| lo[a] <= p[a] && p[a] <= hi[a]);
    let rules = Rules::new();
    let mut everything = true;
    // Part and point; several fragments share corners.
    let mut points: Vec<(usize, [f64; 3])> = Vec::new();
    for component in &subject.surface.list {
        let body = component.body as u32;
        for &(id, _) in &component.triangles {
            if !region.takes(id, subject.mesh.triangles[id as usize]) {
                everything = false;
                continue;
            }
            let triangle = subject.mesh.triangles[id as usize]
                .map(|v| grid.local(subject.mesh.positions[v as usize]));
            everything &= triangle.iter().all(|p| inside(*p));
            let apart = (0..3).any(|a| {
                triangle.iter().all(|p| p[a] < lo[a]) || triangle.iter().all(|p| p[a] > hi[a])
            });
            if apart {
                continue;
            }
            for_each_fragment(triangle, grid.dims, &Slab::ALL, &mut |_, polygon| {
                let mut polygon = *polygon;
                if matches!(region, Region::Box { .. }) {
                    for a in 0..3 {
                        polygon = polygon.clip(a, lo[a], 1.0).clip(a, hi[a], -1.0);
                    }
                }
                let mut add = |p: [f64; 3]| {
                    if let Some(part) = lattice.nearest_part(body, p) {
                        points.push((part, p));
                    }
                };
                // Corners too: a line or a point that is held has no area.
                polygon.corners().iter().for_each(|&p| add(p));
                rules.for_each_point(&polygon, &mut add);
            });
        }
    }
    if let Region::Vertices(list) = region {
        for &v in *list {
            let component = subject.surface.of_vertex[v as usize];
            let Some(body) = component.map(|p| subject.surface.list[p as usize].body) else {
                continue; // no triangle with area uses it
            };
            let p = grid.local(subject.mesh.positions[v as usize]);
            if let Some(part) = lattice.nearest_part(body as u32, p) {
                points.push((part, p));
            }
        }
    }
    if let Region::Box { .. } = region {
        for (n, part) in lattice.parts.iter().enumerate() {
            let own = &lattice.components[part.component as usize];
            if own.moments[part.place as usize][0] < 1.0 {
                continue;
            }
            let from: [f64; 3] = std::array::from_fn(|a| lo[a].max(part.cell[a] as f64));
            let to: [f64; 3] = std::array::from_fn(|a| hi[a].min((part.cell[a] + 1) as f64));
            if (0..3).all(|a| from[a] <= to[a]) {
                points.extend((0..27usize).map(|i| {
                    let step = [i % 3, i / 3 % 3, i / 9].map(|k| 0.5 * k as f64);
                    let p = std::array::from_fn(|a| from[a] + step[a] * (to[a] - from[a]));
                    (n, p)
                }));
            }
        }
    }
    points.sort_by(|a, b| {
        let order = |k: usize| a.1[k].total_cmp(&b.1[k]);
        a.0.cmp(&b.0).then(order(0)).then(order(1)).then(order(2))
    });
    points.dedup();
    let mut constraints = Vec::with_capacity(points.len());
    for own in points.chunk_by(|a, b| a.0 == b.0) {
        constraints.extend(own.iter().map(|&(part, p)| Constraint {
            anchor: anchor(lattice, part, p),
            axes,
            share: 1.0 / own.len() as f64,
        }));
    }
    Constrained {
        constraints,
        everything,
    }
}
