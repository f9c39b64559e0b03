//! obvhs: a binary box tree, refitted in one sweep. It has no query for pairs: two trees are walked here.

use std::ops::Range;
use std::time::Duration;

use bdtree_runtime::{Contact, PairContact};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use super::vertices::{Vertices, box_of};
use super::{PairPeer, Peer, Target};
use crate::Body;
use crate::leaf;

/// A leaf's triangles, as places in the order of the leaves.
fn places(leaf: &Bvh2Node) -> Range<usize> {
    let first = leaf.first_index as usize;
    first..first + leaf.prim_count as usize
}

/// A body in obvhs.
#[derive(Clone)]
pub struct Obvhs {
    tree: Bvh2,
    /// Corners in the order of the leaves.
    corners: Vec<[u32; 3]>,
    vertices: Vertices,
    /// Nodes of this tree and the other that are still to be looked at.
    pairs: Vec<[u32; 2]>,
}

impl Obvhs {
    /// Of a body at rest: the medium build without split triangles, which could not be refitted.
    pub fn new(body: &Body) -> Self {
        let vertices = Vertices::new(body);
        let triangles: Vec<Triangle> = body
            .triangles
            .iter()
            .map(|t| {
                let [v0, v1, v2] = vertices.corners(*t);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let settings = BvhBuildParams {
            pre_split: false,
            ..BvhBuildParams::medium_build()
        };
        let mut tree = build_bvh2_from_tris(&triangles, settings, &mut Duration::default());
        // Refitting is fastest in this order.
        tree.reorder_in_stack_traversal_order();
        let corners = tree.primitive_indices.iter();
        Self {
            corners: corners.map(|i| body.triangles[*i as usize]).collect(),
            tree,
            vertices,
            pairs: Vec::new(),
        }
    }

    /// How many boxes a ball is tested with: both children of every inner node that it reaches, whose own
    /// box is not tested before (as obvhs walks), or the only node.
    pub fn box_tests(&self, center: [f64; 3], radius: f64) -> u64 {
        let [low, high] = box_of(center, radius);
        let ball = Aabb::new(low, high);
        let nodes = &self.tree.nodes;
        let mut stack: Vec<u32> = match nodes.first() {
            None => return 0,
            Some(root) if root.is_leaf() => return 1,
            Some(root) => vec![root.first_index],
        };
        let mut tests = 0;
        while let Some(first) = stack.pop() {
            for index in [first, first + 1] {
                tests += 1;
                let node = &nodes[index as usize];
                if !node.is_leaf() && node.aabb().intersect_aabb(&ball) {
                    stack.push(node.first_index);
                }
            }
        }
        tests
    }
}

impl Peer for Obvhs {
    fn update_with(&mut self, to: Target<'_>, scratch: &mut Vec<f32>, deformed: &mut dyn FnMut()) {
        to.write(scratch, &mut self.vertices.0);
        deformed();
        for node in &mut self.tree.nodes {
            if !node.is_leaf() {
                continue;
            }
            let mut around = Aabb::empty();
            for corners in &self.corners[places(node)] {
                for p in self.vertices.corners(*corners) {
                    around.extend(p);
                }
            }
            node.set_aabb(around);
        }
        self.tree.refit_all();
    }

    fn ball(&mut self, center: [f64; 3], radius: f64, found: &mut Vec<Contact>) {
        let [low, high] = box_of(center, radius);
        self.tree.aabb_traverse(Aabb::new(low, high), |tree, node| {
            for i in places(&tree.nodes[node as usize]) {
                let corners = self.vertices.exact(self.corners[i]);
                leaf::ball(tree.primitive_indices[i], &corners, center, radius, found);
            }
            true
        });
    }

    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
        let ray = Ray::new_inf(origin.into(), direction.into());
        let mut hit = RayHit::none();
        self.tree.ray_traverse(ray, &mut hit, |ray, i| {
            let [a, b, c] = self.vertices.corners(self.corners[i]);
            RtTriangle::new(a, b, c).intersect(ray)
        });
        hit.t.is_finite().then_some(f64::from(hit.t))
    }
}

impl PairPeer for Obvhs {
    fn pair(&mut self, other: &mut Self, found: &mut Vec<PairContact>) {
        self.pairs.clear();
        self.pairs.push([0, 0]);
        while let Some([i, j]) = self.pairs.pop() {
            let (a, b) = (&self.tree.nodes[i as usize], &other.tree.nodes[j as usize]);
            if !a.aabb().intersect_aabb(b.aabb()) {
                continue;
            }
            match (a.is_leaf(), b.is_leaf()) {
                (false, false) => {
                    for k in 0..4 {
                        self.pairs
                            .push([a.first_index + (k >> 1), b.first_index + (k & 1)]);
                    }
                }
                (false, true) => self
                    .pairs
                    .extend([[a.first_index, j], [a.first_index + 1, j]]),
                (true, false) => self
                    .pairs
                    .extend([[i, b.first_index], [i, b.first_index + 1]]),
                (true, true) => {
                    for k in places(a) {
                        let one = self.vertices.exact(self.corners[k]);
                        let id1 = self.tree.primitive_indices[k];
                        for l in places(b) {
                            let two = other.vertices.exact(other.corners[l]);
                            let id2 = other.tree.primitive_indices[l];
                            leaf::pair((id1, &one), (id2, &two), found);
                        }
                    }
                }
            }
        }
    }
}
