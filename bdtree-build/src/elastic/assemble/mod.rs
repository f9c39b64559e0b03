//! Adds up elements and springs to a system.

pub(crate) mod constraint;
pub(crate) mod dissection;
pub(crate) mod joints;
pub(crate) mod ordering;
pub(crate) mod system;

use std::borrow::Cow;

use crate::elastic::assemble::constraint::Constraint;
use crate::elastic::assemble::joints::Blocks;
use crate::elastic::assemble::system::System;
use crate::elastic::element::{ElementMatrices, NodeLists};

/// Stiffness of the springs at held points, per cell, in units of Young's modulus times the cell
/// size: they give way by a thousandth of what the cell itself does.
const SPRING: f64 = 1e3;

/// What a component consists of; nodes are numbered as in `positions`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Source<'a> {
    /// Where each node is, in units of about an element.
    pub positions: Vec<[f64; 3]>,
    /// The nodes in order of elimination.
    pub order: Vec<u32>,
    /// Nodes of each element.
    pub elements: Cow<'a, NodeLists>,
    /// Points that springs hold.
    pub constraints: &'a [Constraint],
    /// Whether each node's x, y, z are held; empty if nothing is.
    pub held: Cow<'a, [[bool; 3]]>,
    /// What of it is stiff in itself.
    pub blocks: Cow<'a, Blocks>,
}

impl System {
    /// Adds up the elements, whose matrices `matrices` tells, and the springs.
    ///
    /// # Errors
    /// The element that has no matrices.
    pub(crate) fn assemble<'m>(
        source: &Source<'_>,
        matrices: impl Fn(usize) -> Option<Cow<'m, ElementMatrices>>,
    ) -> Result<Self, usize> {
        let mut place = vec![0u32; source.order.len()];
        for (n, &old) in source.order.iter().enumerate() {
            place[old as usize] = n as u32;
        }
        let elements = source.elements.renumbered(&place);
        let (starts, rows) = adjacency(&elements, place.len());
        let mut held: Vec<usize> = (source.held.iter().zip(&place))
            .flat_map(|(axes, &n)| (0..3).filter(|&a| axes[a]).map(move |a| 3 * n as usize + a))
            .collect();
        held.sort_unstable();
        let mut system = Self {
            nodes: (source.order.iter())
                .map(|&n| source.positions[n as usize])
                .collect(),
            constraints: source.constraints.to_vec(),
            held,
            blocks: source.blocks.renumbered(&place),
            place,
            stiffness: vec![[0.0; 9]; rows.len()],
            mass: vec![0.0; rows.len()],
            starts,
            rows,
            threads: 1,
        };
        for (e, nodes) in elements.iter().enumerate() {
            let own = matrices(e).ok_or(e)?;
            let count = nodes.len();
            system.for_each_pair(nodes, |system, at, a, b| {
                system.mass[at] += own.mass[count * a + b];
                let block = &own.stiffness[count * a + b];
                for (sum, k) in system.stiffness[at].iter_mut().zip(block) {
                    *sum += k;
                }
            });
        }
        for n in 0..system.constraints.len() {
            let constraint = &mut system.constraints[n];
            constraint.anchor.nodes = constraint
                .anchor
                .nodes
                .map(|node| system.place[node as usize]);
            let Constraint {
                anchor,
                axes,
                share,
            } = constraint.clone();
            system.for_each_pair(&anchor.nodes, |system, at, a, b| {
                let spring = SPRING * share * anchor.weights[a] * anchor.weights[b];
                for (axis, held) in axes.iter().enumerate() {
                    system.stiffness[at][4 * axis] += if *held { spring } else { 0.0 };
                }
            });
        }
        Ok(system)
    }

    /// Calls `add(self, entry, row, column)` for the lower triangle's pairs of an element's nodes.
    fn for_each_pair(
        &mut self,
        nodes: &[u32],
        mut add: impl FnMut(&mut Self, usize, usize, usize),
    ) {
        for (b, &column) in nodes.iter().enumerate() {
            let range = self.starts[column as usize]..self.starts[column as usize + 1];
            for (a, &row) in nodes.iter().enumerate() {
                if row >= column
                    && let Ok(at) = self.rows[range.clone()].binary_search(&row)
                {
                    add(self, range.start + at, a, b);
                }
            }
        }
    }
}

/// Lower adjacency of the nodes by columns (start of each, and their end; rows): the node itself
/// first, then its later neighbours.
pub(crate) fn adjacency(elements: &NodeLists, count: usize) -> (Vec<usize>, Vec<u32>) {
    let mut first = vec![0usize; count + 1];
    for n in elements.iter().flatten() {
        first[*n as usize + 1] += 1;
    }
    for n in 0..count {
        first[n + 1] += first[n];
    }
    let mut cursor = first.clone();
    let mut elements_of = vec![0u32; first[count]];
    for (e, nodes) in elements.iter().enumerate() {
        for &n in nodes {
            elements_of[cursor[n as usize]] = e as u32;
            cursor[n as usize] += 1;
        }
    }
    let mut starts = Vec::with_capacity(count + 1);
    let mut rows = Vec::new();
    let mut own = Vec::new();
    starts.push(0);
    for n in 0..count {
        own.clear();
        own.push(n as u32);
        for &e in &elements_of[first[n]..first[n + 1]] {
            let nodes = elements.get(e as usize).iter();
            own.extend(nodes.filter(|&&m| m > n as u32));
        }
        own.sort_unstable();
        own.dedup();
        rows.extend_from_slice(&own);
        starts.push(rows.len());
    }
    (starts, rows)
}

/// Strain energy of an element whose nodes move so.
#[cfg(test)]
pub(crate) fn energy(own: &ElementMatrices, moved: &[[f64; 3]]) -> f64 {
    let count = moved.len();
    let mut sum = 0.0;
    for i in 0..count {
        for j in 0..count {
            for (n, k) in own.stiffness[count * i + j].iter().enumerate() {
                sum += 0.5 * moved[i][n / 3] * k * moved[j][n % 3];
            }
        }
    }
    sum
}
