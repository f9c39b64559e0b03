//! The mass of a lattice's filled cells, and the momenta of its modes: those of the mass matrix that modes are found
//! with.

use super::Lattice;
use crate::elastic::element::spline::resultants;
use crate::elastic::solve::ComponentMode;
use crate::mass::Momentum;
use crate::mass::integrals::{Frame, Integrals};
use crate::vec3::{add, cross, scale};

/// Row sums of the mass matrix, plain and weighted with where the functions' centers are.
#[derive(Debug, Clone)]
pub(crate) struct LatticeMass {
    /// Integrals over all filled cells, in cells.
    pub integrals: Integrals,
    /// What they count from.
    pub frame: Frame,
    /// Per component and node: ∫ N and ∫ N x, in cells.
    nodes: Vec<Vec<(f64, [f64; 3])>>,
}

impl LatticeMass {
    /// Sums over the cells, in their order.
    pub(crate) fn new(lattice: &Lattice) -> Self {
        let grid = lattice.grid;
        let middle = grid.dims.map(|n| 0.5 * n as f64);
        let frame = Frame {
            about: add(grid.origin, scale(middle, grid.cell_size)),
            length: grid.cell_size,
        };
        let mut integrals = Integrals::default();
        let mut nodes = Vec::with_capacity(lattice.components.len());
        for component in &lattice.components {
            let mut sums = vec![(0.0, [0.0; 3]); component.nodes.len()];
            for (cell, moments) in component.cells.iter().zip(&component.moments) {
                // The function in the middle of the 27 is the cell's own.
                let own = component.nodes[cell[cell.len() / 2] as usize];
                let at: [f64; 3] = std::array::from_fn(|a| f64::from(own[a]) + 0.5 - middle[a]);
                let found = resultants(moments);
                integrals.merge(&found.filling.moved(at));
                for (&n, (whole, first)) in cell.iter().zip(found.functions) {
                    let (sum, along) = &mut sums[n as usize];
                    *sum += whole;
                    *along = add(*along, add(first, scale(at, whole)));
                }
            }
            nodes.push(sums);
        }
        Self {
            integrals,
            frame,
            nodes,
        }
    }

    /// The momentum of a mode at unit speed, a full cell weighing `cell_mass` kg.
    pub(crate) fn momentum(&self, mode: &ComponentMode, cell_mass: f64) -> Momentum {
        let values = mode.vector.as_chunks::<3>().0;
        momentum(&self.nodes[mode.component], values, self.frame, cell_mass)
    }
}

/// The momentum of nodes of these masses and first moments (of the unit `mass_kg`) that move with these velocities.
pub(crate) fn momentum(
    nodes: &[(f64, [f64; 3])],
    velocities: &[[f64; 3]],
    frame: Frame,
    mass_kg: f64,
) -> Momentum {
    let (mut linear, mut angular) = ([0.0; 3], [0.0; 3]);
    for ((whole, first), u) in nodes.iter().zip(velocities) {
        linear = add(linear, scale(*u, *whole));
        angular = add(angular, cross(*first, *u));
    }
    Momentum {
        about: frame.about,
        linear: scale(linear, mass_kg),
        angular: scale(angular, mass_kg * frame.length),
    }
}
