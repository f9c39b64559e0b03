//! A ball that asks the asset what it touches.

use std::time::{Duration, Instant};

use bdtree_render::NodeSphere;
use bdtree_runtime::{
    Asset, Contact, LeafSlot, NodeSlot, Pose, StackEntry, StepCache, Transform, query,
};

/// The ball (world).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Its centre.
    pub center: [f64; 3],
    /// Its radius.
    pub radius: f64,
}

/// What it touches, and what it took to know.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Every triangle within the ball.
    pub contacts: Vec<Contact>,
    /// Nodes whose spheres were tested.
    pub nodes_visited: u64,
    /// The query's time, for a pose that is prepared and keeps nothing.
    pub time: Duration,
    /// Spheres of visited nodes that lead to no visited node: where the query ended.
    pub ends: Vec<NodeSphere>,
}

impl Answer {
    /// How deep the ball is in the mesh: the largest penetration; `None` without contact.
    pub fn depth(&self) -> Option<f64> {
        self.contacts
            .iter()
            .map(|contact| -contact.dist)
            .reduce(f64::max)
    }
}

/// Memory for the queries of an asset.
#[derive(Debug)]
pub struct Asker {
    pose: Vec<f32>,
    stack: Vec<StackEntry>,
    cache: StepCache<Vec<NodeSlot>, [LeafSlot; 0]>,
}

impl Asker {
    /// For an asset.
    pub fn new(asset: &Asset<'_>) -> Self {
        let slots = vec![NodeSlot::EMPTY; asset.node_count()];
        Self {
            pose: vec![0.0; asset.pose_len()],
            stack: vec![StackEntry::default(); asset.stack_len()],
            cache: StepCache::new(slots, [LeafSlot::EMPTY; 0]),
        }
    }

    /// What a probe touches of the asset at q.
    ///
    /// # Errors
    /// In words: q, placement or probe that the runtime refuses, a corrupt asset.
    pub fn ask(
        &mut self,
        asset: &Asset<'_>,
        q: &[f32],
        transform: &Transform,
        probe: Probe,
    ) -> Result<Answer, String> {
        let Probe { center, radius } = probe;
        let pose = Pose::new(asset, q, *transform, &mut self.pose).map_err(|e| e.to_string())?;
        let mut contacts = Vec::new();
        let begin = Instant::now();
        let outcome = query::ball(asset, &pose, center, radius, &mut self.stack, &mut contacts);
        let time = begin.elapsed();
        let outcome = outcome.map_err(|error| error.to_string())?;
        // Once more with memory for all nodes: those that are in it afterwards were visited.
        let mut cached = self.cache.start(&pose);
        let mut again: Vec<Contact> = Vec::new();
        query::ball(
            asset,
            &mut cached,
            center,
            radius,
            &mut self.stack,
            &mut again,
        )
        .map_err(|error| error.to_string())?;
        let visited: Vec<u32> = (0..asset.node_count() as u32)
            .filter(|n| cached.keeps(*n))
            .collect();
        let spheres = NodeSphere::of_nodes(asset, &pose, visited.iter().copied());
        let mut ends = spheres.map_err(|error| error.to_string())?;
        ends.retain(|sphere| {
            let is_visited = |child: u32| visited.binary_search(&child).is_ok();
            !sphere.child.is_some_and(is_visited)
        });
        Ok(Answer {
            contacts,
            nodes_visited: outcome.nodes_visited,
            time,
            ends,
        })
    }
}
