//! The product's ray query.

use bdtree_runtime::{Asset, Pose, StackEntry, Transform, query};

use bdtree_scenes::clock::Clock;

use super::{Cache, cache};
use crate::workloads::contest::Frame;

/// An asset with the memory that it is asked in.
pub(crate) struct OurRays<'a> {
    asset: Asset<'a>,
    memory: Vec<f32>,
    cache: Cache,
    stack: Vec<StackEntry>,
}

impl<'a> OurRays<'a> {
    pub(crate) fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: vec![0.0; asset.pose_len()],
            // Random rays seldom meet a leaf twice: keeping leaves costs more than it saves.
            cache: cache(asset.node_count(), 0),
            stack: vec![StackEntry::default(); asset.stack_len()],
            asset,
        }
    }

    /// Pose and rays (origin, direction).
    pub(crate) fn frame(&mut self, q: &[f32], rays: impl Iterator<Item = [[f32; 3]; 2]>) -> Frame {
        let asset = &self.asset;
        let start = Clock::start();
        let pose = Pose::new(asset, q, Transform::IDENTITY, &mut self.memory);
        let pose = pose.expect("q within limits");
        let mut kept = self.cache.start(&pose);
        let mut found = 0;
        for ray in rays {
            let [origin, direction] = ray.map(|v| v.map(f64::from));
            let stack = &mut self.stack;
            let nearest = query::ray(asset, &mut kept, origin, direction, f64::INFINITY, stack);
            found += u64::from(nearest.expect("a sound asset").hit.is_some());
        }
        Frame {
            query: start.seconds(),
            found,
            ..Frame::default()
        }
    }
}
