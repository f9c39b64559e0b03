//! The mass of a volume mesh's elements, and of its nodes.

use super::Model;
use crate::elastic::element::{hexahedron, tetrahedron};
use crate::mass::integrals::{Integrals, products};
use crate::vec3::{add, scale};

/// Sums of the mass matrix over the elements, in the model's units.
#[derive(Debug, Clone)]
pub(crate) struct ModelMass {
    /// Integrals over the elements, each with its density: exact also where the mass matrix is lumped.
    pub integrals: Integrals,
    /// Volume of all elements.
    pub volume: f64,
    /// Per node: its row's sum, plain and weighted with positions, of the matrix that modes are found with.
    pub nodes: Vec<(f64, [f64; 3])>,
}

impl Model {
    /// Sums over the elements, in their order.
    pub(crate) fn mass_sums(&self) -> ModelMass {
        let mut sums = ModelMass {
            integrals: Integrals::default(),
            volume: 0.0,
            nodes: vec![(0.0, [0.0; 3]); self.positions.len()],
        };
        for (e, corners) in self.elements.iter().enumerate() {
            let (_, density) = self.material(e);
            // In exact arithmetic the same as 1ᵀM1, but this is the mass that reports have always told.
            let volume = self.shape(e).0;
            sums.volume += volume;
            let mass = if let Some(p) = self.corners(corners) {
                tetrahedron::mass(&p, density)
            } else if let Some(p) = self.corners(corners) {
                hexahedron::mass(&p, density)
            } else {
                continue;
            };
            let count = corners.len();
            let (mut first, mut second) = ([0.0; 3], [0.0; 6]);
            for (i, row) in mass.chunks_exact(count).enumerate() {
                let at = |k: usize| self.positions[corners[k] as usize];
                let (mut whole, mut along) = (0.0, [0.0; 3]);
                for (j, m) in row.iter().enumerate() {
                    whole += m;
                    along = add(along, scale(at(j), *m));
                }
                let own = products(at(i), along);
                second = std::array::from_fn(|k| second[k] + own[k]);
                first = add(first, along);
                let along = if self.lumped {
                    scale(at(i), whole)
                } else {
                    along
                };
                let (sum, weighted) = &mut sums.nodes[corners[i] as usize];
                *sum += whole;
                *weighted = add(*weighted, along);
            }
            sums.integrals.add(self.mass(e, volume), first, second);
        }
        sums
    }
}
