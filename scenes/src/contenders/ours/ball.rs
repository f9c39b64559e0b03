//! The product's ball query.

use bdtree_runtime::{Asset, Contact, Pose, StackEntry, Transform, query};

use bdtree_baselines::clock::Clock;

use crate::contenders::contest::{Frame, Nodes};

/// An asset with the memory that it is asked in.
pub struct OurBall<'a> {
    asset: Asset<'a>,
    memory: Vec<f32>,
    stack: Vec<StackEntry>,
    found: Vec<Contact>,
}

impl<'a> OurBall<'a> {
    /// On an asset.
    pub fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: vec![0.0; asset.pose_len()],
            stack: vec![StackEntry::default(); asset.stack_len()],
            found: Vec::new(),
            asset,
        }
    }

    /// Pose and question.
    pub fn frame(&mut self, q: &[f32], [x, y, z, radius]: [f32; 4]) -> Frame {
        let center = [x, y, z].map(f64::from);
        self.found.clear();
        let start = Clock::start();
        let pose = Pose::new(&self.asset, q, Transform::IDENTITY, &mut self.memory);
        let outcome = query::ball(
            &self.asset,
            &pose.expect("q within limits"),
            center,
            f64::from(radius),
            &mut self.stack,
            &mut self.found,
        );
        let query = start.seconds();
        let mut nodes = Nodes::default();
        nodes.add(&outcome.expect("a sound asset"));
        Frame {
            query,
            found: self.found.len() as u64,
            nodes,
            ..Frame::default()
        }
    }
}
