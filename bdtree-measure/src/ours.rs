//! The product as one of those who are compared: a pose, then queries, in memory that is kept.

use bdtree_runtime::{
    Asset, CachedPose, Contact, LeafSlot, NodeSlot, Pose, Posed, StackEntry, StepCache, Transform,
    query,
};

use crate::MeasureError;
use crate::clock::Clock;
use crate::comparison::CACHED;
use crate::turns::{Frame, Nodes};

/// What an instance keeps during a step.
pub type Cache = StepCache<Vec<NodeSlot>, Vec<LeafSlot>>;

/// Room for so many nodes and leaves.
pub fn cache(nodes: usize, leaves: usize) -> Cache {
    StepCache::new(vec![NodeSlot::EMPTY; nodes], vec![LeafSlot::EMPTY; leaves])
}

/// An asset with the memory that it is asked in.
pub struct Ours<'a> {
    asset: Asset<'a>,
    memory: Vec<f32>,
    stack: Vec<StackEntry>,
    /// For steps of [`CACHED`] queries and more.
    cache: Option<Cache>,
    found: Vec<Contact>,
}

/// What a step's queries found.
#[derive(Debug, Clone, Copy, Default)]
pub struct Answer {
    /// Contacts or hits.
    pub found: u64,
    /// Nodes of the tree.
    pub nodes: Nodes,
}

/// A body in a step, with or without a cache.
enum Step<'s, 'p> {
    Plain(&'s Pose<'p>),
    Kept(&'s mut CachedPose<'p>),
}

impl Step<'_, '_> {
    fn posed(&mut self) -> Posed<'_> {
        match self {
            Self::Plain(pose) => (*pose).into(),
            Self::Kept(cached) => (&mut **cached).into(),
        }
    }
}

impl<'a> Ours<'a> {
    /// On an asset; nothing is kept from one query to the next.
    pub fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: vec![0.0; asset.pose_len()],
            stack: vec![StackEntry::default(); asset.stack_len()],
            cache: None,
            found: Vec::new(),
            asset,
        }
    }

    /// The same, all nodes and so many leaves kept during a step from [`CACHED`] queries on.
    pub fn keeping(asset: Asset<'a>, leaves: usize) -> Self {
        Self {
            cache: Some(cache(asset.node_count(), leaves)),
            ..Self::new(asset)
        }
    }

    /// Contacts of the last ball.
    pub fn found(&self) -> &[Contact] {
        &self.found
    }

    /// A pose and so many queries, each of which adds to what the step found.
    fn step<Q>(
        &mut self,
        q: &[f32],
        queries: impl ExactSizeIterator<Item = Q>,
        mut ask: impl FnMut(&Asset<'a>, Posed<'_>, &mut [StackEntry], &mut Vec<Contact>, Q) -> Asked,
    ) -> Result<Answer, MeasureError> {
        let Self {
            asset,
            memory,
            stack,
            cache,
            found,
        } = self;
        let pose = Pose::new(asset, q, Transform::IDENTITY, memory)?;
        let cache = cache.as_mut().filter(|_| queries.len() >= CACHED);
        let mut kept = cache.map(|cache| cache.start(&pose));
        let mut step = match &mut kept {
            Some(kept) => Step::Kept(kept),
            None => Step::Plain(&pose),
        };
        let mut answer = Answer::default();
        for query in queries {
            let own = ask(asset, step.posed(), stack, found, query)?;
            answer.found += own.found;
            answer.nodes.visited += own.nodes.visited;
            answer.nodes.updated += own.nodes.updated;
        }
        Ok(answer)
    }

    /// A step of balls, by center and radius.
    ///
    /// # Errors
    /// q beyond its limits, a ball that is none.
    pub fn balls(
        &mut self,
        q: &[f32],
        balls: impl ExactSizeIterator<Item = ([f64; 3], f64)>,
    ) -> Result<Answer, MeasureError> {
        self.step(q, balls, |asset, posed, stack, found, (center, radius)| {
            found.clear();
            let outcome = query::ball(asset, posed, center, radius, stack, found)?;
            Ok(Answer {
                found: found.len() as u64,
                nodes: Nodes {
                    visited: outcome.nodes_visited,
                    updated: outcome.nodes_updated,
                },
            })
        })
    }

    /// A step of rays, by origin and direction: the nearest hit of each.
    ///
    /// # Errors
    /// q beyond its limits, a ray that is none.
    pub fn rays(
        &mut self,
        q: &[f32],
        rays: impl ExactSizeIterator<Item = [[f64; 3]; 2]>,
    ) -> Result<Answer, MeasureError> {
        self.step(q, rays, |asset, posed, stack, _, [origin, direction]| {
            let nearest = query::ray(asset, posed, origin, direction, f64::INFINITY, stack)?;
            Ok(Answer {
                found: u64::from(nearest.hit.is_some()),
                nodes: Nodes {
                    visited: nearest.nodes_visited,
                    updated: nearest.nodes_updated,
                },
            })
        })
    }
}

/// A query's answer.
type Asked = Result<Answer, MeasureError>;

/// A step of the product as a frame of a comparison, all of it in the time of the queries.
///
/// # Panics
/// Where the step is refused: comparisons are of sound assets at q within their limits.
pub fn frame(step: impl FnOnce() -> Result<Answer, MeasureError>) -> Frame {
    let start = Clock::start();
    let answer = step();
    let query = start.seconds();
    let Answer { found, nodes } = answer.expect("a sound asset at q within its limits");
    Frame {
        query,
        found,
        nodes,
        ..Frame::default()
    }
}
