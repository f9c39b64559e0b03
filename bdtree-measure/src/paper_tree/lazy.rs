//! The paper's laziness: a node's sphere and a vertex are computed when first visited in a step and
//! kept until the next.

use bdtree_runtime::{Asset, Pose};

use super::walk::Spheres;
use super::{PaperTree, Step, Vertices};

/// Spheres of one instance that have been computed in this step.
#[derive(Debug, Clone)]
pub struct Memory {
    spheres: Vec<[f32; 4]>,
    step_of: Vec<u32>,
    now: u32,
    vertices: Vertices,
    step: Step,
}

impl Memory {
    /// Room for a tree's nodes and an asset's vertices.
    pub fn new(tree: &PaperTree, asset: &Asset<'_>) -> Self {
        Self {
            spheres: vec![[0.0; 4]; tree.node_count()],
            step_of: vec![0; tree.node_count()],
            now: 0,
            vertices: Vertices::new(asset),
            step: Step::default(),
        }
    }

    /// Forgets all of them and takes the next step's q.
    pub fn begin_step(&mut self, pose: &Pose<'_>) {
        self.now += 1;
        self.vertices.begin_step();
        self.step.prepare(pose);
    }

    /// The spheres at this step.
    pub fn at<'m>(&'m mut self, pose: &'m Pose<'m>) -> Lazy<'m> {
        Lazy { memory: self, pose }
    }
}

/// [`Memory`] with what computes the rest.
#[derive(Debug)]
pub struct Lazy<'m> {
    memory: &'m mut Memory,
    pose: &'m Pose<'m>,
}

impl Spheres for Lazy<'_> {
    #[inline]
    fn sphere(&mut self, tree: &PaperTree, node: usize) -> [f32; 4] {
        let memory = &mut *self.memory;
        if memory.step_of[node] != memory.now {
            memory.step_of[node] = memory.now;
            memory.spheres[node] = tree.sphere(&memory.step, node);
        }
        memory.spheres[node]
    }

    #[inline]
    fn vertex(&mut self, vertex: u32) -> [f64; 3] {
        self.memory.vertices.get(self.pose, vertex)
    }
}
