//! The product's ball query.

use bdtree_runtime::{Asset, CachedPose, Contact, Pose, StackEntry, Transform, query};

use bdtree_measure::clock::Clock;
use bdtree_measure::comparison::{CACHED, LEAF_SLOTS};

use super::{Cache, cache};
use bdtree_measure::turns::{Frame, Nodes};

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

/// An asset with the memory in which balls are asked of it a step at a time.
pub struct OurBalls<'a> {
    asset: Asset<'a>,
    memory: Vec<f32>,
    stack: Vec<StackEntry>,
    cache: Cache,
    found: Vec<Contact>,
}

impl<'a> OurBalls<'a> {
    /// On an asset.
    pub fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: vec![0.0; asset.pose_len()],
            stack: vec![StackEntry::default(); asset.stack_len()],
            cache: cache(asset.node_count(), LEAF_SLOTS),
            found: Vec::new(),
            asset,
        }
    }

    /// Pose and questions, all in one time; from [`CACHED`] on with a cache of the step's nodes and leaves,
    /// as `bdtree report` asks.
    pub fn step(&mut self, q: &[f32], centers: &[[f32; 3]], radius: f32) -> Frame {
        let mut frame = Frame::default();
        let Self {
            asset,
            memory,
            stack,
            cache,
            found,
        } = self;
        let start = Clock::start();
        let pose = Pose::new(asset, q, Transform::IDENTITY, memory).expect("q within limits");
        let mut kept: Option<CachedPose<'_>> =
            (centers.len() >= CACHED).then(|| cache.start(&pose));
        for center in centers {
            found.clear();
            let (center, radius) = (center.map(f64::from), f64::from(radius));
            let outcome = match &mut kept {
                Some(kept) => query::ball(asset, kept, center, radius, stack, found),
                None => query::ball(asset, &pose, center, radius, stack, found),
            };
            frame.nodes.add(&outcome.expect("a sound asset"));
            frame.found += found.len() as u64;
        }
        frame.query = start.seconds();
        frame
    }
}
