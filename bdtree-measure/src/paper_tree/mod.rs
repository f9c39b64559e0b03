//! The paper's BD-Tree: the baseline that the product is measured against, written with care here and
//! once more plainly in [`PlainTree`].
//!
//! D. L. James and D. K. Pai, *BD-Tree: Output-Sensitive Collision Detection for Reduced
//! Deformable Models*, SIGGRAPH 2004: a binary tree of wrapped spheres with exactly one triangle
//! per leaf (3.1), split at the median along the longest axis in the manner of Quinlan; mean Ū_j
//! and ΔR_j per node and mode (eqs. 3–7); nodes deformed when they are visited, triangles when
//! a leaf is reached.
//!
//! An honest one: f32, one node's numbers side by side as four-lane rows (`[c, R]`, then
//! `[Ū_j, ΔR_j]` per mode) that compilers turn into vector instructions, nodes in depth-first
//! order, an explicit stack, vertices deformed once per step. The center c is the middle of the
//! vertices' box: cheap, as the paper leaves it open.
//!
//! It reads positions and displacements of an opened asset, uses the runtime's leaf arithmetic
//! and predicates, and pays for rounding in the same manner, so its answers are the same.

mod build;
mod layered;
mod lazy;
mod plain;
mod query;
mod walk;

pub use layered::Layered;
pub use lazy::{Lazy, Memory};
pub use plain::PlainTree;
pub use query::{BallCounts, Step, Vertices};
pub use walk::{Between, Spheres};

/// Set in the link of a leaf.
const LEAF: u32 = 1 << 31;

/// A leaf's triangle, or where an inner node's right child stands (the left one is next).
#[derive(Debug, Clone, Copy)]
struct Link(u32);

impl Link {
    fn triangle(self) -> Option<u32> {
        (self.0 & LEAF != 0).then_some(self.0 & !LEAF)
    }
}

/// The paper's tree (stored units).
#[derive(Debug, Clone)]
pub struct PaperTree {
    mode_count: usize,
    links: Vec<Link>,
    /// Per node `[c, R]` and then `[Ū_j, ΔR_j]` for every mode.
    numbers: Vec<[f32; 4]>,
    /// Corners by triangle id.
    pub corners: Vec<[u32; 3]>,
    /// Number of levels.
    pub depth: usize,
}

impl PaperTree {
    /// Number of nodes: 2F − 1.
    pub fn node_count(&self) -> usize {
        self.links.len()
    }

    /// Bytes of one node.
    pub fn node_bytes(&self) -> usize {
        4 + 16 * (1 + self.mode_count)
    }

    /// `[c, R]` and `[Ū_j, ΔR_j]` of a node.
    pub fn numbers(&self, node: usize) -> &[[f32; 4]] {
        let stride = 1 + self.mode_count;
        &self.numbers[node * stride..(node + 1) * stride]
    }

    /// Level and triangles of every node, in storage order; the root's level is 0.
    pub fn nodes(&self) -> Vec<(usize, Vec<u32>)> {
        let mut all = vec![(0, Vec::new()); self.links.len()];
        for i in (0..self.links.len()).rev() {
            match self.links[i].triangle() {
                Some(t) => all[i].1.push(t),
                None => {
                    let right = self.links[i].0 as usize;
                    all[i].1 = [all[i + 1].1.as_slice(), &all[right].1].concat();
                }
            }
        }
        for i in 0..self.links.len() {
            if self.links[i].triangle().is_none() {
                let level = all[i].0 + 1;
                all[i + 1].0 = level;
                all[self.links[i].0 as usize].0 = level;
            }
        }
        all
    }
}
