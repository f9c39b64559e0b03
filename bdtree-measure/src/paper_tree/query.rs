//! Queries on the paper's tree: spheres where visited, triangles where reached.

use bdtree_runtime::{Asset, Contact, Pose, VertexId};

use super::PaperTree;
use super::walk::apart;
use crate::leaf;
use crate::vector::length;

/// Unit roundoff of f32.
const U32: f64 = 1.0 / (1_u64 << 24) as f64;

/// Relative error of squared f32 distances, as in the runtime.
pub(super) const SKIP: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// Relative error of the f64 maps between world and stored coordinates, as in the runtime.
const FRAME: f64 = 1.0 / (1_u64 << 44) as f64;

/// What a query did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BallCounts {
    /// Spheres updated and tested.
    pub spheres: u64,
    /// Triangles deformed and tested.
    pub triangles: u64,
}

/// World vertices, deformed when first asked for in a step.
#[derive(Debug, Clone)]
pub struct Vertices {
    world: Vec<[f64; 3]>,
    step_of: Vec<u32>,
    step: u32,
}

impl Vertices {
    /// Room for an asset's vertices.
    pub fn new(asset: &Asset<'_>) -> Self {
        Self {
            world: vec![[0.0; 3]; asset.vertex_count()],
            step_of: vec![0; asset.vertex_count()],
            step: 0,
        }
    }

    /// Forgets all of them.
    pub fn begin_step(&mut self) {
        self.step += 1;
    }

    #[inline]
    pub(super) fn get(&mut self, pose: &Pose<'_>, vertex: u32) -> [f64; 3] {
        let i = vertex as usize;
        if self.step_of[i] != self.step {
            self.step_of[i] = self.step;
            self.world[i] = pose
                .deformed(VertexId(vertex))
                .expect("the tree's vertices are the asset's");
        }
        self.world[i]
    }
}

/// q prepared once per step; world and mesh coordinates are the same.
#[derive(Debug, Clone, Default)]
pub struct Step {
    /// `[q, q, q, |q|]` per mode.
    q: Vec<[f32; 4]>,
    /// Rounding of centers, radii and vertices (stored units).
    pub(super) slack: f32,
    /// P + S(q).
    reach: f64,
}

impl Step {
    /// Prepares q, as the pose holds it.
    pub fn prepare(&mut self, pose: &Pose<'_>) {
        let asset = pose.asset();
        self.q.clear();
        self.q
            .extend(pose.q().iter().map(|q| [*q, *q, *q, q.abs()]));
        let p = f64::from(asset.header().position_norm_max.get());
        let s: f64 = asset
            .modes()
            .iter()
            .zip(&self.q)
            .map(|(mode, q)| f64::from(mode.field_norm_max.get()) * f64::from(q[3]))
            .sum();
        // The runtime's slack, and another (M + 4) u T with T ≤ 2 (P + S) for the sum R + s.
        let m = self.q.len() as f64;
        let slack = U32 * (8.0 * p + (2.0 * m + 8.0) * s + (2.0 * m + 8.0) * (p + s));
        self.slack = (slack + 2.0_f64.powi(-54)) as f32 * 1.000_001;
        self.reach = p + s;
    }
}

/// A ball's center in stored units and its radius there, rounding included.
pub(super) fn reach_of(asset: &Asset<'_>, step: &Step, center: [f64; 3], radius: f64) -> [f32; 4] {
    let (origin, unit) = (asset.origin(), asset.unit());
    let stored = [0, 1, 2].map(|k| (center[k] - origin[k]) / unit);
    let world = length(center) + radius + length(origin);
    let reach = radius / unit * (1.0 + 4.0 * U32)
        + FRAME * (world / unit + step.reach)
        + 2.0 * U32 * length(stored);
    let [x, y, z] = stored.map(|c| c as f32);
    [x, y, z, reach as f32 * (1.0 + 4.0 * U32 as f32)]
}

impl PaperTree {
    /// `[c', R']` of a node (eqs. 5 and 7), rounding included.
    #[inline]
    pub fn sphere(&self, step: &Step, node: usize) -> [f32; 4] {
        let numbers = self.numbers(node);
        let mut moved = [0.0_f32; 4];
        for (row, q) in numbers[1..].iter().zip(&step.q) {
            for k in 0..4 {
                moved[k] += row[k] * q[k];
            }
        }
        for k in 0..4 {
            moved[k] += numbers[0][k];
        }
        moved[3] += step.slack;
        moved
    }

    /// Appends the triangles within `radius` of `center` with their contacts.
    pub fn ball(
        &self,
        pose: &Pose<'_>,
        step: &Step,
        (center, radius): ([f64; 3], f64),
        (vertices, stack): (&mut Vertices, &mut Vec<u32>),
        found: &mut Vec<Contact>,
    ) -> BallCounts {
        let ball = reach_of(pose.asset(), step, center, radius);
        let mut counts = BallCounts::default();
        stack.clear();
        stack.push(0);
        while let Some(node) = stack.pop() {
            counts.spheres += 1;
            if apart(self.sphere(step, node as usize), ball) {
                continue;
            }
            let link = self.links[node as usize];
            let Some(id) = link.triangle() else {
                stack.push(link.0);
                stack.push(node + 1);
                continue;
            };
            counts.triangles += 1;
            let corners = self.corners[id as usize].map(|v| vertices.get(pose, v));
            leaf::ball(id, &corners, center, radius, found);
        }
        counts
    }
}
