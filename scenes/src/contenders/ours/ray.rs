//! The product's ray query.

use bdtree_runtime::{Asset, Pose, StackEntry, Transform, query};

use bdtree_measure::clock::Clock;

use super::{Cache, cache};
use bdtree_measure::turns::{Frame, Nodes};

/// An asset with the memory that it is asked in.
pub struct OurRays<'a> {
    asset: Asset<'a>,
    memory: Vec<f32>,
    cache: Cache,
    stack: Vec<StackEntry>,
}

impl<'a> OurRays<'a> {
    /// On an asset.
    pub fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: vec![0.0; asset.pose_len()],
            // Random rays seldom meet a leaf twice: keeping leaves costs more than it saves.
            cache: cache(asset.node_count(), 0),
            stack: vec![StackEntry::default(); asset.stack_len()],
            asset,
        }
    }

    /// Pose and rays (origin, direction).
    pub fn frame(
        &mut self,
        q: &[f32],
        rays: impl ExactSizeIterator<Item = [[f32; 3]; 2]>,
    ) -> Frame {
        let asset = &self.asset;
        let start = Clock::start();
        let pose = Pose::new(asset, q, Transform::IDENTITY, &mut self.memory);
        let pose = pose.expect("q within limits");
        let stack = &mut self.stack;
        // What one ray computes no other asks for.
        let mut kept = (rays.len() > 1).then(|| self.cache.start(&pose));
        let (mut found, mut nodes) = (0, Nodes::default());
        for ray in rays {
            let [origin, direction] = ray.map(|v| v.map(f64::from));
            let nearest = match &mut kept {
                None => query::ray(asset, &pose, origin, direction, f64::INFINITY, stack),
                Some(kept) => query::ray(asset, kept, origin, direction, f64::INFINITY, stack),
            };
            let nearest = nearest.expect("a sound asset");
            found += u64::from(nearest.hit.is_some());
            nodes.visited += nearest.nodes_visited;
            nodes.updated += nearest.nodes_updated;
        }
        Frame {
            query: start.seconds(),
            found,
            nodes,
            ..Frame::default()
        }
    }
}
