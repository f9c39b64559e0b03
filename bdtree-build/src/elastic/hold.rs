//! Which unknowns `--fix` holds.

use super::lattice::{Lattice, Subject};
use super::locate::nearest_cell;
use super::slice::for_each_fragment;

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
}

/// Marks, per component and unknown, what a region holds along `axes`; returns how many nodes.
///
/// Held are the lattice nodes nearest to the surface in the region (taken at the corners of its
/// fragments, one cell apart or less) and, in a box, the nodes inside the material.
pub(crate) fn hold(
    subject: &Subject<'_>,
    lattice: &Lattice,
    region: &Region<'_>,
    axes: [bool; 3],
    held: &mut [Vec<bool>],
) -> usize {
    let grid = &lattice.grid;
    let slack = 1e-6;
    let (lo, hi) = match region {
        Region::Box { min, max } => (
            grid.local(*min).map(|x| x - slack),
            grid.local(*max).map(|x| x + slack),
        ),
        Region::Triangles(_) => ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]),
    };
    let inside = |p: [f64; 3]| (0..3).all(|a| lo[a] <= p[a] && p[a] <= hi[a]);
    let mut count = 0;
    let mut mark = |component: usize, node: u32| {
        count += 1;
        for (a, on) in axes.iter().enumerate() {
            if *on {
                held[component][3 * node as usize + a] = true;
            }
        }
    };
    for piece in &subject.pieces.list {
        let body = piece.body as u32;
        for &(id, _) in &piece.triangles {
            if let Region::Triangles(ranges) = region
                && !ranges.iter().any(|r| r.contains(&id))
            {
                continue;
            }
            let triangle = subject.mesh.triangles[id as usize]
                .map(|v| grid.local(subject.mesh.positions[v as usize]));
            let apart = (0..3).any(|a| {
                triangle.iter().all(|p| p[a] < lo[a]) || triangle.iter().all(|p| p[a] > hi[a])
            });
            if apart {
                continue;
            }
            for_each_fragment(triangle, grid.dims, &mut |_, polygon| {
                for &p in polygon.corners().iter().filter(|p| inside(**p)) {
                    if let Some(cell) = nearest_cell(lattice, body, p) {
                        let (component, node) = nearest_node(lattice, cell, p);
                        mark(component, node);
                    }
                }
            });
        }
    }
    if let Region::Box { .. } = region {
        for (component, own) in lattice.components.iter().enumerate() {
            let mut full = vec![0u8; own.nodes.len()];
            for (cell, moments) in own.cells.iter().zip(&own.moments) {
                for &n in cell {
                    full[n as usize] += u8::from(moments[0] >= 1.0);
                }
            }
            for (n, node) in own.nodes.iter().enumerate() {
                if full[n] == 8 && inside(node.map(f64::from)) {
                    mark(component, n as u32);
                }
            }
        }
    }
    count
}

fn nearest_node(lattice: &Lattice, cell: usize, p: [f64; 3]) -> (usize, u32) {
    let corner = lattice.grid.cell(lattice.keys[cell]);
    let (component, place) = lattice.places[cell];
    let mut node = 0;
    for a in 0..3 {
        if p[a] - corner[a] as f64 > 0.5 {
            node |= 1 << a;
        }
    }
    let nodes = &lattice.components[component as usize].cells[place as usize];
    (component as usize, nodes[node])
}
