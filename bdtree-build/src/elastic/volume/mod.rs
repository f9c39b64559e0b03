//! A given volume mesh as finite elements: its components, their systems.

mod mass;

use std::borrow::Cow;

use crate::disjoint_sets::DisjointSets;
use crate::elastic::assemble::Source;
use crate::elastic::assemble::dissection::dissect_mesh;
use crate::elastic::assemble::joints::{Blocks, TooManyBlocks, find_blocks};
use crate::elastic::assemble::system::System;
use crate::elastic::element::material::Material;
use crate::elastic::element::{ElementMatrices, NodeLists};
use crate::elastic::element::{hexahedron, tetrahedron};
use crate::vec3::{norm, sub};

pub(crate) use mass::ModelMass;

/// Elements connected through nodes: they vibrate on their own.
#[derive(Debug, Clone, Default)]
pub(crate) struct Component {
    /// Nodes of the mesh, ascending.
    pub nodes: Vec<u32>,
    /// Elements of the mesh, ascending.
    pub elements: Vec<u32>,
    /// Places in `nodes` of each element's corners.
    pub corners: NodeLists,
    /// What of it is stiff in itself.
    pub blocks: Blocks,
}

/// Elements, and what they are made of, in units of their size, stiffness and density.
#[derive(Debug, Clone, Default)]
pub(crate) struct Model {
    /// Node positions.
    pub positions: Vec<[f64; 3]>,
    /// Corners of each element, tetrahedra and hexahedra.
    pub elements: NodeLists,
    /// Each material and its density.
    pub materials: Vec<(Material, f64)>,
    /// Material of each element; empty: the first.
    pub material_of: Vec<u32>,
    /// Whether the mass is summed up on the diagonal.
    pub lumped: bool,
}

impl Model {
    /// The components, in the order of their first nodes.
    ///
    /// # Errors
    /// A component of more blocks than can be handled: its first node.
    pub(crate) fn components(&self) -> Result<Vec<Component>, (u32, TooManyBlocks)> {
        let count = self.positions.len();
        let mut sets = DisjointSets::new(count);
        for corners in self.elements.iter() {
            for pair in corners.windows(2) {
                sets.join(pair[0] as usize, pair[1] as usize);
            }
        }
        let mut used = vec![false; count];
        for &n in self.elements.iter().flatten() {
            used[n as usize] = true;
        }
        let mut components: Vec<Component> = Vec::new();
        let mut component_of = vec![u32::MAX; count];
        let mut place = vec![0u32; count];
        for n in (0..count).filter(|&n| used[n]) {
            let root = sets.find(n);
            if component_of[root] == u32::MAX {
                component_of[root] = components.len() as u32;
                components.push(Component::default());
            }
            let own = &mut components[component_of[root] as usize];
            place[n] = own.nodes.len() as u32;
            own.nodes.push(n as u32);
        }
        for (e, corners) in self.elements.iter().enumerate() {
            let Some(&first) = corners.first() else {
                continue;
            };
            let own = &mut components[component_of[sets.find(first as usize)] as usize];
            own.elements.push(e as u32);
            own.corners.push(corners.iter().map(|&n| place[n as usize]));
        }
        for own in &mut components {
            let positions = self.positions_of(own);
            own.blocks = find_blocks(&positions, &own.corners).map_err(|e| (own.nodes[0], e))?;
        }
        Ok(components)
    }

    fn positions_of(&self, component: &Component) -> Vec<[f64; 3]> {
        let nodes = component.nodes.iter();
        nodes.map(|&n| self.positions[n as usize]).collect()
    }

    /// The system of a component; `held` tells of every node of the mesh which axes are held.
    ///
    /// # Errors
    /// The place in the component of an element that has no stiffness.
    pub(crate) fn system(
        &self,
        component: &Component,
        held: &[[bool; 3]],
    ) -> Result<System, usize> {
        let positions = self.positions_of(component);
        let source = Source {
            order: dissect_mesh(&positions, &component.corners),
            positions,
            elements: Cow::Borrowed(&component.corners),
            constraints: &[],
            held: component.nodes.iter().map(|&n| held[n as usize]).collect(),
            blocks: Cow::Borrowed(&component.blocks),
        };
        System::assemble(&source, |e| {
            self.matrices(component.elements[e] as usize)
                .map(Cow::Owned)
        })
    }

    /// Stiffness and mass of an element.
    fn matrices(&self, element: usize) -> Option<ElementMatrices> {
        let (material, density) = self.material(element);
        let corners = self.elements.get(element);
        let mut own = if let Some(p) = self.corners(corners) {
            tetrahedron::matrices(&p, material, density)
        } else {
            hexahedron::matrices(&self.corners(corners)?, material, density)?
        };
        if self.lumped {
            own.lump();
        }
        Some(own)
    }

    fn material(&self, element: usize) -> (&Material, f64) {
        let index = self.material_of.get(element).map_or(0, |&m| m as usize);
        let (material, density) = &self.materials[index];
        (material, *density)
    }

    /// Positions of N corners, if there are so many.
    fn corners<const N: usize>(&self, corners: &[u32]) -> Option<[[f64; 3]; N]> {
        let corners: &[u32; N] = corners.try_into().ok()?;
        Some(corners.map(|n| self.positions[n as usize]))
    }

    /// Volume of an element, and how far it is from being turned inside out anywhere: its least
    /// Jacobian determinant over the cube of its longest edge.
    pub(crate) fn shape(&self, element: usize) -> (f64, f64) {
        let corners = self.elements.get(element);
        let (volume, least) = if let Some(p) = self.corners(corners) {
            let volume = tetrahedron::volume(&p);
            (volume, volume)
        } else if let Some(p) = self.corners(corners) {
            (hexahedron::volume(&p), hexahedron::least_determinant(&p))
        } else {
            return (0.0, 0.0);
        };
        let mut longest = 0.0f64;
        for &a in corners {
            for &b in corners {
                let [a, b] = [a, b].map(|n| self.positions[n as usize]);
                longest = longest.max(norm(sub(a, b)));
            }
        }
        (volume, least / longest.powi(3))
    }

    /// Mass of an element of this volume.
    pub(crate) fn mass(&self, element: usize, volume: f64) -> f64 {
        self.material(element).1 * volume
    }
}

#[cfg(test)]
mod tests;
