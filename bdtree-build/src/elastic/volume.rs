//! A given volume mesh as finite elements: its components, their systems.

use std::borrow::Cow;

use super::assemble::{ElementMatrices, NodeLists, Source};
use super::dissection::dissect_mesh;
use super::joints::{Blocks, TooManyBlocks, find_blocks};
use super::law::Law;
use super::pieces::DisjointSets;
use super::system::System;
use super::{hexahedron, tetrahedron};

/// Elements that hang together by nodes: their own vibrating body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part {
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
    /// Law and density of each material.
    pub materials: Vec<(Law, f64)>,
    /// Material of each element; empty: the first.
    pub material_of: Vec<u32>,
    /// Whether the mass is summed up on the diagonal.
    pub lumped: bool,
}

impl Model {
    /// The parts, in the order of their first nodes.
    ///
    /// # Errors
    /// A part of more blocks than can be handled: its first node.
    pub(crate) fn parts(&self) -> Result<Vec<Part>, (u32, TooManyBlocks)> {
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
        let mut parts: Vec<Part> = Vec::new();
        let mut part_of = vec![u32::MAX; count];
        let mut place = vec![0u32; count];
        for n in (0..count).filter(|&n| used[n]) {
            let root = sets.find(n);
            if part_of[root] == u32::MAX {
                part_of[root] = parts.len() as u32;
                parts.push(Part::default());
            }
            let own = &mut parts[part_of[root] as usize];
            place[n] = own.nodes.len() as u32;
            own.nodes.push(n as u32);
        }
        for (e, corners) in self.elements.iter().enumerate() {
            let Some(&first) = corners.first() else {
                continue;
            };
            let own = &mut parts[part_of[sets.find(first as usize)] as usize];
            own.elements.push(e as u32);
            own.corners.push(corners.iter().map(|&n| place[n as usize]));
        }
        for own in &mut parts {
            let positions = self.positions_of(own);
            own.blocks = find_blocks(&positions, &own.corners).map_err(|e| (own.nodes[0], e))?;
        }
        Ok(parts)
    }

    fn positions_of(&self, part: &Part) -> Vec<[f64; 3]> {
        let nodes = part.nodes.iter();
        nodes.map(|&n| self.positions[n as usize]).collect()
    }

    /// The system of a part; `held` tells of every node of the mesh which axes are held.
    ///
    /// # Errors
    /// The place in the part of an element that has no stiffness.
    pub(crate) fn system(&self, part: &Part, held: &[[bool; 3]]) -> Result<System, usize> {
        let positions = self.positions_of(part);
        let source = Source {
            order: dissect_mesh(&positions, &part.corners),
            positions,
            elements: Cow::Borrowed(&part.corners),
            grips: &[],
            held: part.nodes.iter().map(|&n| held[n as usize]).collect(),
            blocks: Cow::Borrowed(&part.blocks),
        };
        System::assemble(&source, |e| {
            self.matrices(part.elements[e] as usize).map(Cow::Owned)
        })
    }

    /// Stiffness and mass of an element.
    fn matrices(&self, element: usize) -> Option<ElementMatrices> {
        let (law, density) = self.material(element);
        let corners = self.elements.get(element);
        let mut own = if let Some(p) = self.corners(corners) {
            tetrahedron::matrices(&p, law, density)
        } else {
            hexahedron::matrices(&self.corners(corners)?, law, density)?
        };
        if self.lumped {
            own.lump();
        }
        Some(own)
    }

    fn material(&self, element: usize) -> (&Law, f64) {
        let index = self.material_of.get(element).map_or(0, |&m| m as usize);
        let (law, density) = &self.materials[index];
        (law, *density)
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
                longest = longest.max(super::vec3::norm(super::vec3::sub(a, b)));
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
mod tests {
    use super::*;
    use crate::elastic::dense::all_modes;
    use crate::elastic::rigid::rigid_motions;
    use crate::elastic::solve::{Limits, solve};
    use crate::progress::Silent;

    /// A block of cells whose inner and outer nodes are moved about, of hexahedra, of tetrahedra
    /// (six per cell) or of both, in two materials.
    fn jittered(n: [usize; 3], tetrahedra: impl Fn(usize) -> bool, lumped: bool) -> Model {
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        let mut model = Model {
            materials: vec![(Law::new(1.0, 0.3), 1.0), (Law::new(0.3, 0.45), 0.6)],
            lumped,
            ..Model::default()
        };
        let at = |c: [usize; 3]| ((c[2] * (n[1] + 1) + c[1]) * (n[0] + 1) + c[0]) as u32;
        for i in 0..(n[0] + 1) * (n[1] + 1) * (n[2] + 1) {
            let c = [
                i % (n[0] + 1),
                i / (n[0] + 1) % (n[1] + 1),
                i / (n[0] + 1) / (n[1] + 1),
            ];
            model.positions.push(c.map(|x| x as f64 + 0.3 * random()));
        }
        for i in 0..n[0] * n[1] * n[2] {
            let [x, y, z] = [i % n[0], i / n[0] % n[1], i / n[0] / n[1]];
            let c = [
                [0, 0, 0],
                [1, 0, 0],
                [1, 1, 0],
                [0, 1, 0],
                [0, 0, 1],
                [1, 0, 1],
                [1, 1, 1],
                [0, 1, 1],
            ]
            .map(|c: [usize; 3]| at([x + c[0], y + c[1], z + c[2]]));
            let material = (i % 2) as u32;
            if tetrahedra(i) {
                for [a, b] in [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]] {
                    model.elements.push([c[0], c[a], c[b], c[6]]);
                    model.material_of.push(material);
                }
            } else {
                model.elements.push(c);
                model.material_of.push(material);
            }
        }
        model
    }

    /// The lowest modes against all of them, computed at once; the number of motions without
    /// strain is known.
    fn check(model: &Model, held: &[[bool; 3]], still: usize) {
        for e in 0..model.elements.len() {
            assert!(model.shape(e).1 > 1e-2, "element {e}");
        }
        let parts = model.parts().expect("few blocks");
        let limits = Limits {
            wanted: 12,
            bytes: 1 << 30,
            verify_dof_max: 70_000,
        };
        let sizes: Vec<usize> = parts.iter().map(|p| p.nodes.len()).collect();
        let system = |c: usize| model.system(&parts[c], held);
        let found = solve(&sizes, system, limits, &Silent).expect("modes");
        assert!(found.checked);
        let mut want = Vec::new();
        let mut motions = 0;
        for part in &parts {
            let system = model.system(part, held).expect("a system");
            let rigid = rigid_motions(&system);
            let energy = rigid.transpose() * system.apply_stiffness(rigid.as_ref());
            for j in 0..rigid.ncols() {
                assert!(energy[(j, j)].abs() < 1e-12);
            }
            motions += rigid.ncols();
            want.extend(all_modes(&system, rigid.ncols()).expect("all").values);
        }
        assert_eq!(motions, still);
        want.sort_by(f64::total_cmp);
        assert!(want[0] > 1e-5, "a motion without strain was not found");
        assert_eq!(found.modes.len(), 12);
        for (mode, want) in found.modes.iter().zip(want) {
            assert!(
                (mode.value / want - 1.0).abs() < 1e-8,
                "{} {want}",
                mode.value
            );
            let own = &parts[mode.component].nodes;
            for (i, u) in mode.vector.iter().enumerate() {
                if held[own[i / 3] as usize][i % 3] {
                    assert_eq!(*u, 0.0);
                }
            }
        }
    }

    #[test]
    fn free_bodies_meet_the_dense_solution() {
        let n = [4, 3, 2];
        for lumped in [false, true] {
            let kinds: [fn(usize) -> bool; 3] = [|_| false, |_| true, |i| i % 4 == 0];
            // Tetrahedra beside hexahedra leave gaps in the faces, but are one body all the same.
            for kind in kinds {
                let model = jittered(n, kind, lumped);
                check(&model, &vec![[false; 3]; model.positions.len()], 6);
            }
        }
    }

    #[test]
    fn held_bodies_meet_the_dense_solution() {
        let n = [4, 3, 2];
        let model = jittered(n, |_| false, false);
        let none = vec![[false; 3]; model.positions.len()];
        let with = |nodes: &[usize], axes: [bool; 3]| {
            let mut held = none.clone();
            nodes.iter().for_each(|&n| held[n] = axes);
            held
        };
        let all = [true; 3];
        let z = [false, false, true];
        check(&model, &with(&[0], all), 3);
        check(&model, &with(&[0, 7], all), 1);
        check(&model, &with(&[0, 7, 31], all), 0);
        check(&model, &with(&[0, 7, 31], z), 3);
        check(&model, &with(&[3], z), 5);
        let face: Vec<usize> = (0..60).step_by(5).collect();
        check(&model, &with(&face, all), 0);
        check(&model, &with(&face, z), 3);
    }

    /// Three points on a line, but for the rounding of their coordinates, leave the body to turn.
    #[test]
    fn points_that_are_nearly_on_a_line_are_a_hinge() {
        let mut model = jittered([4, 2, 2], |_| true, false);
        for n in 0..5 {
            model.positions[n] = [n as f64, 1e-8 * (n * n) as f64, 0.0];
        }
        let mut held = vec![[false; 3]; model.positions.len()];
        held[..5].fill([true; 3]);
        check(&model, &held, 1);
    }

    /// Two cells with a common edge, and a third one that shares a corner with the second.
    #[test]
    fn joints_move_without_strain() {
        let mut model = jittered([4, 3, 2], |_| false, false);
        let kept = [0, 5, 6, 23];
        let elements: Vec<Vec<u32>> = kept.map(|e| model.elements.get(e).to_vec()).to_vec();
        model.elements = NodeLists::default();
        elements.into_iter().for_each(|e| model.elements.push(e));
        model.material_of.truncate(4);
        let parts = model.parts().expect("few blocks");
        // Cells 0 and 5 share an edge, 6 lies beside 5 and shares a corner with 23.
        assert_eq!(parts.len(), 1);
        assert_eq!(parts[0].blocks.further, 2);
        let mut held = vec![[false; 3]; model.positions.len()];
        check(&model, &held, 6 + 1 + 3);
        let first = model.elements.get(0)[0] as usize;
        held[first] = [true; 3];
        check(&model, &held, 3 + 1 + 3);
    }

    #[test]
    fn parts_that_share_no_node_vibrate_apart() {
        let mut model = jittered([4, 3, 2], |_| false, false);
        let kept = [0, 1, 3];
        let elements: Vec<Vec<u32>> = kept.map(|e| model.elements.get(e).to_vec()).to_vec();
        model.elements = NodeLists::default();
        elements.into_iter().for_each(|e| model.elements.push(e));
        model.material_of.truncate(3);
        assert_eq!(model.parts().expect("few blocks").len(), 2);
        check(&model, &vec![[false; 3]; model.positions.len()], 12);
    }
}
