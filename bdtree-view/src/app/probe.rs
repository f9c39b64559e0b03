//! A ball that asks the asset what it touches.

use std::time::{Duration, Instant};

use bdtree_render::NodeSphere;
use bdtree_runtime::{Asset, Ball, CacheSize, Contact, Pose, StepCache, Workspace};

/// The ball (world).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Its center.
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
            .map(|contact| -contact.distance)
            .reduce(f64::max)
    }
}

/// Memory for the queries of an asset.
#[derive(Debug)]
pub struct Asker {
    workspace: Workspace<'static>,
    cache: StepCache<'static>,
}

impl Asker {
    /// For an asset.
    pub fn new(asset: &Asset<'_>) -> Self {
        let nodes = asset.node_count();
        Self {
            workspace: Workspace::new(),
            cache: StepCache::new(CacheSize { nodes, leaves: 0 }),
        }
    }

    /// What a probe touches of a pose of the asset.
    ///
    /// # Errors
    /// In words: a probe that the runtime refuses, a corrupt asset.
    pub fn ask(&mut self, pose: &Pose<'_>, probe: Probe) -> Result<Answer, String> {
        let ball = Ball::new(probe.center, probe.radius);
        let mut contacts = Vec::new();
        let begin = Instant::now();
        let mut query = pose.query(&mut self.workspace);
        let asked = query.contacts(ball, &mut contacts);
        let time = begin.elapsed();
        asked.map_err(|error| error.to_string())?;
        let nodes_visited = query.stats().nodes_visited;
        // Once more with memory for all nodes: those that are in it afterwards were visited.
        self.cache.start(pose);
        let mut again: Vec<Contact> = Vec::new();
        let query = pose.query(&mut self.workspace);
        let asked = query.cached(&mut self.cache).contacts(ball, &mut again);
        asked.map_err(|error| error.to_string())?;
        let visited: Vec<u32> = (0..pose.asset().node_count() as u32)
            .filter(|n| self.cache.keeps(*n))
            .collect();
        let spheres = NodeSphere::of_nodes(pose, visited.iter().copied());
        let mut ends = spheres.map_err(|error| error.to_string())?;
        ends.retain(|sphere| {
            let is_visited = |child: u32| visited.binary_search(&child).is_ok();
            !sphere.child.is_some_and(is_visited)
        });
        Ok(Answer {
            contacts,
            nodes_visited,
            time,
            ends,
        })
    }
}
