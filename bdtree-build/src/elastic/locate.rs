//! Where the vertices lie in the lattice, and how they follow its nodes.

use super::lattice::{Lattice, Subject};

/// A point's cell in a component, and the weight of each of its nodes.
#[derive(Debug, Clone)]
pub(crate) struct Anchor {
    /// Component.
    pub component: usize,
    /// Nodes of that component.
    pub nodes: [u32; 8],
    /// Trilinear weights; they add up to 1.
    pub weights: [f64; 8],
}

/// Follows nodes beyond the cell at most this far (in half cells from its middle).
const REACH: f64 = 3.0;

/// The anchor of every vertex. A vertex follows a cell that its own body fills: the one it lies
/// in, else the nearest one. A vertex that no piece uses follows the cell it lies in, if that is
/// filled, and stays where it is otherwise.
pub(crate) fn anchors(subject: &Subject<'_>, lattice: &Lattice) -> Vec<Option<Anchor>> {
    let pieces = &subject.pieces;
    subject
        .mesh
        .positions
        .iter()
        .zip(&pieces.of_vertex)
        .map(|(&p, piece)| {
            let p = lattice.grid.local(p);
            match piece {
                Some(piece) => {
                    let body = pieces.list[*piece as usize].body as u32;
                    nearest_cell(lattice, body, p).map(|c| anchor(lattice, c, p))
                }
                None => {
                    let inside = (0..3).all(|a| p[a] >= 0.0 && p[a] <= lattice.grid.dims[a] as f64);
                    let key = lattice.grid.key(lattice.grid.cell_of(p));
                    lattice
                        .find(key)
                        .filter(|_| inside)
                        .map(|c| anchor(lattice, c, p))
                }
            }
        })
        .collect()
}

/// Index of the cell nearest to a lattice point among those that `body` fills.
pub(crate) fn nearest_cell(lattice: &Lattice, body: u32, p: [f64; 3]) -> Option<usize> {
    let centre = lattice.grid.cell_of(p);
    let own = lattice.grid.key(centre);
    if lattice.holds(own, body) {
        return lattice.find(own);
    }
    let around = (0..27usize).filter_map(|n| {
        let step = [n % 3, n / 3 % 3, n / 9];
        let cell: [usize; 3] = std::array::from_fn(|a| (centre[a] + step[a]).wrapping_sub(1));
        let within = (0..3).all(|a| cell[a] < lattice.grid.dims[a]);
        let key = within.then(|| lattice.grid.key(cell))?;
        lattice.holds(key, body).then_some(key)
    });
    let all = lattice
        .fillings
        .iter()
        .filter(|f| f.body == body)
        .map(|f| f.key);
    // Only parts of a piece that hold no material at all are far from all its cells.
    let best = closest(lattice, p, around).or_else(|| closest(lattice, p, all));
    best.and_then(|key| lattice.find(key))
}

/// The first of the cells with the least distance to a lattice point.
fn closest(lattice: &Lattice, p: [f64; 3], keys: impl Iterator<Item = u64>) -> Option<u64> {
    let mut best: Option<(f64, u64)> = None;
    for key in keys {
        let cell = lattice.grid.cell(key);
        let distance: f64 = (0..3)
            .map(|a| {
                let lo = cell[a] as f64;
                (lo - p[a]).max(p[a] - lo - 1.0).max(0.0).powi(2)
            })
            .sum();
        if best.is_none_or(|b| distance < b.0) {
            best = Some((distance, key));
        }
    }
    best.map(|b| b.1)
}

/// The anchor of a lattice point in a cell.
fn anchor(lattice: &Lattice, cell: usize, p: [f64; 3]) -> Anchor {
    let corner = lattice.grid.cell(lattice.keys[cell]);
    let local: [f64; 3] =
        std::array::from_fn(|a| (2.0 * (p[a] - corner[a] as f64) - 1.0).clamp(-REACH, REACH));
    let (component, place) = lattice.places[cell];
    Anchor {
        component: component as usize,
        nodes: lattice.components[component as usize].cells[place as usize],
        weights: std::array::from_fn(|i| {
            (0..3)
                .map(|a| 0.5 * (1.0 + if i >> a & 1 == 1 { local[a] } else { -local[a] }))
                .product()
        }),
    }
}
