//! The product's pair query.

use bdtree_measure::Place;
use bdtree_measure::clock::Clock;
use bdtree_measure::turns::{Frame, Nodes};
use bdtree_runtime::{Asset, CacheSize, StepCache, Transform, TrianglePair, Workspace};

/// Two instances of an asset with the memory that they are asked in.
pub struct OurPair<'a> {
    asset: Asset<'a>,
    memory: [Vec<f32>; 2],
    caches: [StepCache<'static>; 2],
    workspace: Workspace<'static>,
    found: Vec<TrianglePair>,
}

impl<'a> OurPair<'a> {
    /// On an asset.
    pub fn new(asset: Asset<'a>) -> Self {
        let size = CacheSize {
            nodes: asset.node_count(),
            leaves: asset.triangle_count() / 2,
        };
        Self {
            memory: [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]],
            caches: [StepCache::new(size), StepCache::new(size)],
            workspace: Workspace::new(),
            found: Vec::new(),
            asset,
        }
    }

    /// Poses and question.
    pub fn frame(&mut self, [qa, qb]: [&[f32]; 2], place: &Place) -> Frame {
        let asset = &self.asset;
        let [memory_a, memory_b] = &mut self.memory;
        let [cache_a, cache_b] = &mut self.caches;
        self.found.clear();
        let start = Clock::start();
        let a = asset.pose(qa, Transform::IDENTITY, memory_a);
        let b = asset.pose(qb, place.transform(), memory_b);
        let (a, b) = (a.expect("q within limits"), b.expect("q within limits"));
        cache_a.start(&a);
        cache_b.start(&b);
        let pair = a.against(&b, &mut self.workspace);
        let mut pair = pair.cached(cache_a, cache_b);
        let asked = pair.triangle_pairs(0.0, &mut self.found);
        asked.expect("a sound asset");
        let query = start.seconds();
        let mut nodes = Nodes::default();
        nodes.add(self.workspace.stats());
        Frame {
            query,
            found: self.found.len() as u64,
            nodes,
            ..Frame::default()
        }
    }
}
