//! The product on many instances of one asset: poses, root spheres, those that meet, pair queries.

use crate::workloads::pile::{COUNT, Pile};
use bdtree_measure::clock::Clock;
use bdtree_runtime::{
    Asset, BoundingSphere, CacheSize, Pose, StepCache, TrianglePair, Workspace, broad,
};

use bdtree_measure::turns::{Frame, Nodes};

/// Node slots of each instance. More save evaluations and no time: with a thousand bodies they are read from memory.
pub const NODES: usize = 16;
const LEAVES: usize = 0;

/// An asset with the memory that its instances are asked in.
pub struct OurPile<'a> {
    asset: Asset<'a>,
    /// Whether all q are 0.
    at_rest: bool,
    memory: Vec<f32>,
    caches: Vec<StepCache<'static>>,
    workspace: Workspace<'static>,
    spheres: Vec<BoundingSphere>,
    pairs: Vec<[usize; 2]>,
    found: Vec<TrianglePair>,
}

impl<'a> OurPile<'a> {
    /// With so many node slots for each instance between its pairs. A pair's query has sixteen for
    /// itself where there are fewer.
    pub fn new(asset: Asset<'a>, nodes: usize) -> Self {
        let leaves = LEAVES;
        let cache = |_| StepCache::new(CacheSize { nodes, leaves });
        Self {
            at_rest: false,
            memory: vec![0.0; COUNT * asset.pose_len()],
            caches: (0..COUNT).map(cache).collect(),
            workspace: Workspace::new(),
            spheres: Vec::new(),
            pairs: Vec::new(),
            found: Vec::new(),
            asset,
        }
    }

    /// The same with all q at 0.
    pub fn at_rest(mut self) -> Self {
        self.at_rest = true;
        self
    }

    /// A step.
    pub fn frame(&mut self, pile: &Pile, step: usize) -> Frame {
        let asset = &self.asset;
        let zeros = vec![0.0; asset.mode_count()];
        let zero = self.at_rest || asset.mode_count() == 0;
        self.found.clear();
        let start = Clock::start();
        let mut memories = self.memory.chunks_exact_mut(asset.pose_len().max(1));
        let poses: Vec<Pose<'_>> = (0..COUNT)
            .map(|i| {
                let q = if zero { &zeros } else { pile.q(step, i) };
                let memory = memories.next().unwrap_or_default();
                let place = pile.place(step, i).transform();
                asset.pose(q, place, memory).expect("q within limits")
            })
            .collect();
        self.spheres.clear();
        for pose in &poses {
            let sphere = pose.bounding_sphere().expect("a sound asset");
            self.spheres.push(sphere);
        }
        self.pairs.clear();
        let (spheres, workspace) = (&self.spheres, &mut self.workspace);
        broad::pairs(spheres, 0.0, workspace, &mut self.pairs).expect("finite spheres");
        // One body's pairs after each other, so that its numbers stay near.
        self.pairs.sort_unstable();
        for (cache, pose) in self.caches.iter_mut().zip(&poses) {
            cache.start(pose);
        }
        let mut nodes = Nodes::default();
        for [i, j] in self.pairs.iter().copied() {
            let Ok([a, b]) = self.caches.get_disjoint_mut([i, j]) else {
                continue;
            };
            let pair = poses[i].against(&poses[j], workspace);
            let mut pair = pair.cached(a, b);
            let asked = pair.triangle_pairs(0.0, &mut self.found);
            asked.expect("a sound asset");
            nodes.add(pair.stats());
        }
        Frame {
            query: start.seconds(),
            found: self.found.len() as u64,
            nodes,
            ..Frame::default()
        }
    }
}
