//! The product on many instances of one asset: poses, root spheres, those that meet, pair queries.

use crate::workloads::pile::{COUNT, Pile};
use bdtree_measure::clock::Clock;
use bdtree_runtime::broad::{self, GridSlot};
use bdtree_runtime::query::{self, BoundingSphere};
use bdtree_runtime::{Asset, PairStackEntry, Pose, TrianglePair};

use bdtree_measure::ours::{Cache, cache};
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
    caches: Vec<Cache>,
    stack: Vec<PairStackEntry>,
    grid: Vec<GridSlot>,
    spheres: Vec<BoundingSphere>,
    pairs: Vec<[u32; 2]>,
    found: Vec<TrianglePair>,
}

impl<'a> OurPile<'a> {
    /// With so many node slots for each instance between its pairs. A pair's query has sixteen for
    /// itself where there are fewer.
    pub fn new(asset: Asset<'a>, nodes: usize) -> Self {
        Self {
            at_rest: false,
            memory: vec![0.0; COUNT * asset.pose_len()],
            caches: (0..COUNT).map(|_| cache(nodes, LEAVES)).collect(),
            stack: vec![PairStackEntry::default(); asset.pair_stack_len(&asset)],
            grid: vec![GridSlot::EMPTY; broad::grid_slots(COUNT)],
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
                Pose::new(asset, q, place, memory).expect("q within limits")
            })
            .collect();
        self.spheres.clear();
        for pose in &poses {
            let sphere = query::root_sphere(asset, pose).expect("a sound asset");
            self.spheres.push(sphere);
        }
        self.pairs.clear();
        broad::pairs(&self.spheres, 0.0, &mut self.grid, &mut self.pairs).expect("finite spheres");
        // One body's pairs after each other, so that its numbers stay near.
        self.pairs.sort_unstable();
        let caches = self.caches.iter_mut().zip(&poses);
        let mut kept: Vec<_> = caches.map(|(cache, pose)| cache.start(pose)).collect();
        let mut nodes = Nodes::default();
        for pair in &self.pairs {
            let [Ok(a), Ok(b)] = pair.map(usize::try_from) else {
                continue;
            };
            let Ok([a, b]) = kept.get_disjoint_mut([a, b]) else {
                continue;
            };
            let outcome = query::touching(
                (asset, a),
                (asset, b),
                0.0,
                &mut self.stack,
                &mut self.found,
            )
            .expect("a sound asset");
            nodes.add(&outcome);
        }
        Frame {
            query: start.seconds(),
            found: self.found.len() as u64,
            nodes,
            ..Frame::default()
        }
    }
}
