//! The product's pair query.

use bdtree_measure::Place;
use bdtree_measure::clock::Clock;
use bdtree_runtime::{Asset, PairStackEntry, Pose, Transform, TrianglePair, query};

use bdtree_measure::ours::{Cache, cache};
use bdtree_measure::turns::{Frame, Nodes};

/// Two instances of an asset with the memory that they are asked in.
pub struct OurPair<'a> {
    asset: Asset<'a>,
    memory: [Vec<f32>; 2],
    caches: [Cache; 2],
    stack: Vec<PairStackEntry>,
    found: Vec<TrianglePair>,
}

impl<'a> OurPair<'a> {
    /// On an asset.
    pub fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]],
            caches: [0; 2].map(|_| cache(asset.node_count(), asset.triangle_count() / 2)),
            stack: vec![PairStackEntry::default(); asset.pair_stack_len(&asset)],
            found: Vec::new(),
            asset,
        }
    }

    /// Poses and question.
    pub fn frame(&mut self, [qa, qb]: [&[f32]; 2], place: &Place) -> Frame {
        let asset = &self.asset;
        let [memory_a, memory_b] = &mut self.memory;
        self.found.clear();
        let start = Clock::start();
        let a = Pose::new(asset, qa, Transform::IDENTITY, memory_a).expect("q within limits");
        let b = Pose::new(asset, qb, place.transform(), memory_b).expect("q within limits");
        let [cache_a, cache_b] = &mut self.caches;
        let outcome = query::touching(
            (asset, &mut cache_a.start(&a)),
            (asset, &mut cache_b.start(&b)),
            0.0,
            &mut self.stack,
            &mut self.found,
        )
        .expect("a sound asset");
        let query = start.seconds();
        let mut nodes = Nodes::default();
        nodes.add(&outcome);
        Frame {
            query,
            found: self.found.len() as u64,
            nodes,
            ..Frame::default()
        }
    }
}
