//! Walks over the paper's binary tree for whatever spheres its nodes have at the moment: computed from
//! q when first visited, or refitted beforehand.

use bdtree_runtime::narrow::{PreparedRay, Triangle, ray_hit};
use bdtree_runtime::{Contact, PairContact};

use super::PaperTree;
use super::query::SKIP;
use crate::Place;
use crate::leaf;
use crate::place::{matrix, undo_after};

/// Spheres of nodes and places of vertices at the current step.
pub trait Spheres {
    /// `[c', R']` of a node in the body's frame, rounding included.
    fn sphere(&mut self, tree: &PaperTree, node: usize) -> [f32; 4];
    /// A vertex in the world.
    fn vertex(&mut self, vertex: u32) -> [f64; 3];
}

/// Where the second body's frame stands in the first's.
#[derive(Debug, Clone, Copy)]
pub struct Between {
    /// Rows of rotation and translation.
    pub rows: [[f32; 4]; 3],
    /// Rounding of moved centers, added to every radius of the second.
    pub extra: f32,
}

impl Between {
    /// Of the second body's place seen from the first's.
    pub fn new(first: &Place, second: &Place) -> Self {
        let apart = [0, 1, 2].map(|k| second.translation[k] - first.translation[k]);
        let back = matrix(first.rotation);
        let offset = [0, 1, 2]
            .map(|k| back[0][k] * apart[0] + back[1][k] * apart[1] + back[2][k] * apart[2]);
        let seen = Place {
            rotation: undo_after(first.rotation, second.rotation),
            translation: offset,
        };
        // Bodies of these workloads lie within two units of their origin.
        let size = 4.0 + offset.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        Self {
            rows: seen.rows(),
            extra: (2e-6 * size) as f32,
        }
    }

    fn carry(&self, [x, y, z, r]: [f32; 4]) -> [f32; 4] {
        let [a, b, c] = self.rows.map(|m| m[0] * x + m[1] * y + m[2] * z + m[3]);
        [a, b, c, r + self.extra]
    }
}

/// Whether spheres certainly lie apart; NaN does not.
pub(super) fn apart(a: [f32; 4], b: [f32; 4]) -> bool {
    let (dx, dy, dz) = (a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    let touch = a[3] + b[3];
    (dx * dx + dy * dy + dz * dz) * SKIP > touch * touch
}

impl PaperTree {
    fn triangle(&self, spheres: &mut impl Spheres, id: u32) -> Triangle {
        self.corners[id as usize].map(|v| spheres.vertex(v))
    }

    /// Appends the triangles within a ball, given in the world, which is the body's frame.
    pub fn walk_ball(
        &self,
        spheres: &mut impl Spheres,
        (center, radius): ([f64; 3], f64),
        found: &mut Vec<Contact>,
    ) {
        let [x, y, z] = center.map(|c| c as f32);
        let size = center.iter().fold(radius, |m, c| m.max(c.abs()));
        let ball = [x, y, z, (radius + 1e-6 * size) as f32];
        let mut stack = vec![0_u32];
        while let Some(node) = stack.pop() {
            if apart(spheres.sphere(self, node as usize), ball) {
                continue;
            }
            let link = self.links[node as usize];
            if let Some(id) = link.triangle() {
                leaf::ball(id, &self.triangle(spheres, id), center, radius, found);
            } else {
                stack.push(link.0);
                stack.push(node + 1);
            }
        }
    }

    /// Distance to the first triangle that a ray in the body's frame meets.
    pub fn walk_ray(
        &self,
        spheres: &mut impl Spheres,
        origin: [f32; 3],
        direction: [f32; 3],
    ) -> Option<f64> {
        let ray = PreparedRay::new(origin.map(f64::from), leaf::unit(direction.map(f64::from)));
        // Where a sphere is entered (or the ray is nearest to one around its origin), if it is met.
        let enter = |[cx, cy, cz, r]: [f32; 4]| {
            let c = [cx - origin[0], cy - origin[1], cz - origin[2]];
            let along = c[0] * direction[0] + c[1] * direction[1] + c[2] * direction[2];
            let t = along.max(0.0);
            let off = [0, 1, 2].map(|k| c[k] - t * direction[k]);
            // Distances of a few body sizes lose some digits more.
            let r = r * (1.0 + 1e-5) + 1e-5 * along.abs();
            let met = off[0] * off[0] + off[1] * off[1] + off[2] * off[2] <= r * r;
            met.then_some(along - r)
        };
        let mut best = f64::INFINITY;
        let mut stack = Vec::with_capacity(64);
        stack.extend(enter(spheres.sphere(self, 0)).map(|key| (0_u32, key)));
        while let Some((node, key)) = stack.pop() {
            if f64::from(key) > best {
                continue;
            }
            let link = self.links[node as usize];
            if let Some(id) = link.triangle() {
                let corners = self.triangle(spheres, id);
                if let Some(hit) = ray_hit(&ray, &corners, best) {
                    best = hit.t;
                }
                continue;
            }
            let children = [node + 1, link.0];
            let keys = children.map(|child| enter(spheres.sphere(self, child as usize)));
            let [first, second] = match keys {
                [Some(a), Some(b)] if a > b => [1, 0],
                _ => [0, 1],
            };
            // The nearer child comes off the stack first.
            for i in [second, first] {
                if let Some(key) = keys[i] {
                    stack.push((children[i], key));
                }
            }
        }
        best.is_finite().then_some(best)
    }

    /// Appends the touching pairs of triangles of two bodies, the tree of the larger sphere
    /// descended first.
    pub fn walk_pair(
        (tree_a, spheres_a): (&Self, &mut impl Spheres),
        (tree_b, spheres_b): (&Self, &mut impl Spheres),
        between: &Between,
        found: &mut Vec<PairContact>,
    ) {
        let mut stack = vec![(0_u32, 0_u32)];
        while let Some((a, b)) = stack.pop() {
            let sphere_a = spheres_a.sphere(tree_a, a as usize);
            let sphere_b = between.carry(spheres_b.sphere(tree_b, b as usize));
            if apart(sphere_a, sphere_b) {
                continue;
            }
            let (link_a, link_b) = (tree_a.links[a as usize], tree_b.links[b as usize]);
            match (link_a.triangle(), link_b.triangle()) {
                (Some(id_a), Some(id_b)) => {
                    let one = tree_a.triangle(spheres_a, id_a);
                    let two = tree_b.triangle(spheres_b, id_b);
                    leaf::pair((id_a, &one), (id_b, &two), found);
                }
                (None, other) if other.is_some() || sphere_a[3] >= sphere_b[3] => {
                    stack.push((link_a.0, b));
                    stack.push((a + 1, b));
                }
                _ => {
                    stack.push((a, link_b.0));
                    stack.push((a, b + 1));
                }
            }
        }
    }
}
