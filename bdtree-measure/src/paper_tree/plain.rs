//! The same tree as one writes it down from the paper: a record per node, a loop over modes, triangles
//! deformed where a leaf is reached. No layout for vector instructions, no vertex kept for the next leaf.

use bdtree_runtime::{Contact, Pose, VertexId};

use super::query::{SKIP, reach_of};
use super::{BallCounts, PaperTree, Step};
use crate::leaf;

/// A node's numbers (stored units).
#[derive(Debug, Clone)]
struct PlainNode {
    center: [f32; 3],
    radius: f32,
    /// Ū_j.
    mean: Vec<[f32; 3]>,
    /// ΔR_j.
    growth: Vec<f32>,
    children: Option<[u32; 2]>,
    /// A leaf's triangle.
    triangle: u32,
}

/// The paper's tree, written plainly.
#[derive(Debug, Clone)]
pub struct PlainTree {
    nodes: Vec<PlainNode>,
    corners: Vec<[u32; 3]>,
}

impl PlainTree {
    /// The same nodes with the same numbers.
    pub fn of(tree: &PaperTree) -> Self {
        let nodes = (0..tree.node_count()).map(|i| {
            let [own, modes @ ..] = tree.numbers(i) else {
                unreachable!("a node has a center")
            };
            let link = tree.links[i];
            PlainNode {
                center: [own[0], own[1], own[2]],
                radius: own[3],
                mean: modes.iter().map(|m| [m[0], m[1], m[2]]).collect(),
                growth: modes.iter().map(|m| m[3]).collect(),
                children: link.triangle().is_none().then_some([i as u32 + 1, link.0]),
                triangle: link.triangle().unwrap_or(0),
            }
        });
        Self {
            nodes: nodes.collect(),
            corners: tree.corners.clone(),
        }
    }

    /// Appends the triangles within `radius` of `center` with their contacts.
    pub fn ball(
        &self,
        pose: &Pose<'_>,
        step: &Step,
        (center, radius): ([f64; 3], f64),
        stack: &mut Vec<u32>,
        found: &mut Vec<Contact>,
    ) -> BallCounts {
        let [x, y, z, reach] = reach_of(pose.asset(), step, center, radius);
        let q = pose.q();
        let mut counts = BallCounts::default();
        stack.clear();
        stack.push(0);
        while let Some(i) = stack.pop() {
            counts.spheres += 1;
            let node = &self.nodes[i as usize];
            let mut moved = [0.0_f32; 3];
            let mut growth = 0.0_f32;
            for j in 0..q.len() {
                for k in 0..3 {
                    moved[k] += node.mean[j][k] * q[j];
                }
                growth += node.growth[j] * q[j].abs();
            }
            let dx = moved[0] + node.center[0] - x;
            let dy = moved[1] + node.center[1] - y;
            let dz = moved[2] + node.center[2] - z;
            let touch = growth + node.radius + step.slack + reach;
            if (dx * dx + dy * dy + dz * dz) * SKIP > touch * touch {
                continue;
            }
            if let Some([left, right]) = node.children {
                stack.push(right);
                stack.push(left);
                continue;
            }
            counts.triangles += 1;
            let corners = self.corners[node.triangle as usize].map(|v| {
                pose.deformed(VertexId(v))
                    .expect("the tree's vertices are the asset's")
            });
            leaf::ball(node.triangle, &corners, center, radius, found);
        }
        counts
    }
}
