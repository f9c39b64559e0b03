//! Where the vertices lie in the lattice, and how they follow its nodes.

use crate::elastic::assemble::constraint::Anchor;
use crate::elastic::element::spline::spline;
use crate::elastic::lattice::{Lattice, Subject};

/// Follows nodes beyond the cell at most this far (in half cells from its middle).
const REACH: f64 = 3.0;

/// The anchor of every vertex. A vertex follows a cell that its own body fills: the one it lies
/// in, else the nearest one. A vertex that no surface component uses follows the cell it lies in, if that is
/// filled, and stays where it is otherwise.
pub(crate) fn anchors(subject: &Subject<'_>, lattice: &Lattice) -> Vec<Option<Anchor>> {
    let surface = &subject.surface;
    subject
        .mesh
        .positions
        .iter()
        .zip(&surface.of_vertex)
        .map(|(&p, component)| {
            let p = lattice.grid.local(p);
            match component {
                Some(component) => {
                    let body = surface.list[*component as usize].body as u32;
                    lattice
                        .nearest_part(body, p)
                        .map(|part| anchor(lattice, part, p))
                }
                None => {
                    let inside = (0..3).all(|a| p[a] >= 0.0 && p[a] <= lattice.grid.dims[a] as f64);
                    lattice
                        .part_at(p)
                        .filter(|_| inside)
                        .map(|part| anchor(lattice, part, p))
                }
            }
        })
        .collect()
}

/// The anchor of a lattice point in a part.
pub(crate) fn anchor(lattice: &Lattice, part: usize, p: [f64; 3]) -> Anchor {
    let part = lattice.parts[part];
    let values: [[f64; 3]; 3] = std::array::from_fn(|a| {
        spline((2.0 * (p[a] - part.cell[a] as f64) - 1.0).clamp(-REACH, REACH))
    });
    let component = part.component as usize;
    Anchor {
        component,
        nodes: lattice.components[component].cells[part.place as usize],
        weights: std::array::from_fn(|i| {
            values[0][i % 3] * values[1][i / 3 % 3] * values[2][i / 9]
        }),
    }
}
