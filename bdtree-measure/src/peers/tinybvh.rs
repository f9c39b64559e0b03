//! tinybvh: its binary tree (surface area heuristic, several triangles per leaf), refitted and
//! walked here.
//!
//! The crate binds the library to triangles without shared vertices: refitting there would first
//! have to gather three vertices per triangle. So the tree that it builds is taken over, and its refit, one sweep
//! from the last node to the first, reads shared vertices. It has no query for balls and pairs.

mod pair;

use bdtree_runtime::Contact;
use glam::{Vec3A, Vec4};
use tinybvh_rs::bvh;

use super::vertices::{Vertices, box_of};
use super::{Peer, Target};
use crate::Body;
use crate::leaf;

/// A node of 32 bytes as in tinybvh: a box with two whole numbers in the fourth lanes.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Lane 3: the first child or the first triangle.
    low: Vec4,
    /// Lane 3: the number of triangles, 0 for an inner node.
    high: Vec4,
}

impl Node {
    fn first(&self) -> usize {
        self.low.w.to_bits() as usize
    }

    fn count(&self) -> usize {
        self.high.w.to_bits() as usize
    }

    #[inline(always)]
    fn set(&mut self, low: Vec4, high: Vec4) {
        self.low = low.with_w(self.low.w);
        self.high = high.with_w(self.high.w);
    }

    #[inline(always)]
    fn meets(&self, low: Vec3A, high: Vec3A) -> bool {
        (self.low().cmple(high) & self.high().cmpge(low)).all()
    }

    #[inline(always)]
    fn low(&self) -> Vec3A {
        Vec3A::from_vec4(self.low)
    }

    #[inline(always)]
    fn high(&self) -> Vec3A {
        Vec3A::from_vec4(self.high)
    }
}

/// A body in a tree of tinybvh.
#[derive(Debug, Clone)]
pub struct TinyBvh {
    nodes: Vec<Node>,
    /// Triangle ids and corners in the order of the leaves.
    ids: Vec<u32>,
    corners: Vec<[u32; 3]>,
    vertices: Vertices,
    stack: Vec<(u32, f32)>,
    pairs: Vec<(u32, u32)>,
}

impl TinyBvh {
    /// Of a body at rest.
    ///
    /// # Panics
    /// When tinybvh refuses the mesh.
    pub fn new(body: &Body) -> Self {
        let corners = body.triangles.as_flattened().iter();
        let soup: Vec<[f32; 4]> = corners
            .map(|v| {
                let [x, y, z] = body.at_rest()[*v as usize];
                [x, y, z, 0.0]
            })
            .collect();
        let tree = bvh::BVH::new(soup.as_slice().into()).expect("whole triangles");
        let nodes = tree.nodes().iter().map(|node| Node {
            low: Vec3A::from_array(node.min).extend(f32::from_bits(node.left_first)),
            high: Vec3A::from_array(node.max).extend(f32::from_bits(node.tri_count)),
        });
        let ids = tree.indices().to_vec();
        Self {
            nodes: nodes.collect(),
            corners: ids.iter().map(|i| body.triangles[*i as usize]).collect(),
            ids,
            vertices: Vertices::new(body),
            stack: Vec::new(),
            pairs: Vec::new(),
        }
    }

    fn refit(&mut self) {
        for i in (0..self.nodes.len()).rev() {
            // The library leaves the second node empty, so that siblings share a cache line.
            if i == 1 {
                continue;
            }
            let node = self.nodes[i];
            let first = node.first();
            let (mut low, mut high) = (Vec4::MAX, Vec4::MIN);
            if node.count() == 0 {
                let (a, b) = (self.nodes[first], self.nodes[first + 1]);
                low = a.low.min(b.low);
                high = a.high.max(b.high);
            } else {
                for corners in &self.corners[first..first + node.count()] {
                    for p in self.vertices.corners(*corners) {
                        let p = p.extend(0.0);
                        low = low.min(p);
                        high = high.max(p);
                    }
                }
            }
            self.nodes[i].set(low, high);
        }
    }
}

impl Peer for TinyBvh {
    fn update_with(&mut self, to: Target<'_>, scratch: &mut Vec<f32>, deformed: &mut dyn FnMut()) {
        to.write(scratch, &mut self.vertices.0);
        deformed();
        self.refit();
    }

    fn ball(&mut self, center: [f64; 3], radius: f64, found: &mut Vec<Contact>) {
        let [low, high] = box_of(center, radius);
        self.stack.clear();
        self.stack.push((0, 0.0));
        while let Some((i, _)) = self.stack.pop() {
            let node = self.nodes[i as usize];
            if !node.meets(low, high) {
                continue;
            }
            let first = node.first();
            if node.count() == 0 {
                self.stack.push((first as u32 + 1, 0.0));
                self.stack.push((first as u32, 0.0));
                continue;
            }
            for k in first..first + node.count() {
                let corners = self.vertices.exact(self.corners[k]);
                leaf::ball(self.ids[k], &corners, center, radius, found);
            }
        }
    }

    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
        let (origin, direction) = (Vec3A::from_array(origin), Vec3A::from_array(direction));
        let inverse = direction.recip();
        let enter = |node: &Node| {
            let near = (node.low() - origin) * inverse;
            let far = (node.high() - origin) * inverse;
            let from = near.min(far).max_element().max(0.0);
            // A few roundings: what is met at a box's face is not lost.
            let to = near.max(far).min_element() * (1.0 + 4.0 * f32::EPSILON);
            if from <= to { from } else { f32::INFINITY }
        };
        let mut best = f32::INFINITY;
        self.stack.clear();
        self.stack.push((0, enter(&self.nodes[0])));
        while let Some((i, key)) = self.stack.pop() {
            if key >= best {
                continue;
            }
            let node = self.nodes[i as usize];
            let first = node.first();
            if node.count() == 0 {
                let keys = [first, first + 1].map(|i| enter(&self.nodes[i]));
                let order = if keys[0] <= keys[1] { [1, 0] } else { [0, 1] };
                for k in order {
                    if keys[k] < best {
                        self.stack.push(((first + k) as u32, keys[k]));
                    }
                }
                continue;
            }
            for corners in &self.corners[first..first + node.count()] {
                let t = ray_triangle(origin, direction, self.vertices.corners(*corners));
                best = best.min(t);
            }
        }
        best.is_finite().then_some(f64::from(best))
    }
}

/// Distance along a ray to a two-sided triangle, infinite where it is missed (Möller and Trumbore
/// 1997), in f32 as tinybvh does.
fn ray_triangle(origin: Vec3A, direction: Vec3A, [a, b, c]: [Vec3A; 3]) -> f32 {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let inverse = ab.dot(across).recip();
    let from = origin - a;
    let u = from.dot(across) * inverse;
    let turned = from.cross(ab);
    let v = direction.dot(turned) * inverse;
    let t = ac.dot(turned) * inverse;
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 {
        t
    } else {
        f32::INFINITY
    }
}
