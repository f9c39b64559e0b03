//! The product as one of those who are compared: a pose, then queries, in memory that is kept.

use bdtree_runtime::{
    Asset, Ball, BoneMatrices, CacheSize, Contact, Query, QueryError, Ray, RefinedPose, StepCache,
    Transform, Workspace,
};

use crate::MeasureError;
use crate::clock::Clock;
use crate::comparison::CACHED;
use crate::turns::{Frame, Nodes};

/// What a body is posed by.
#[derive(Debug, Clone, Copy)]
pub struct Posture<'a> {
    /// One number per mode.
    pub q: &'a [f32],
    /// Where its bones are.
    pub bones: BoneMatrices<'a>,
}

/// Bones at rest, or none.
impl<'a, Q: AsRef<[f32]> + ?Sized> From<&'a Q> for Posture<'a> {
    fn from(q: &'a Q) -> Self {
        Self {
            q: q.as_ref(),
            bones: BoneMatrices::Rest,
        }
    }
}

/// An asset with the memory that it is asked in.
pub struct Ours<'a> {
    asset: Asset<'a>,
    memory: Vec<f32>,
    workspace: Workspace<'static>,
    /// For steps of [`CACHED`] queries and more.
    cache: Option<StepCache<'static>>,
    refined: Option<RefinedPose<'static>>,
    /// Contacts of the last ball.
    pub found: Vec<Contact>,
}

/// What a step's queries found.
#[derive(Debug, Clone, Copy, Default)]
pub struct Answer {
    /// Contacts or hits.
    pub found: u64,
    /// Nodes of the tree.
    pub nodes: Nodes,
}

impl<'a> Ours<'a> {
    /// On an asset; nothing is kept from one query to the next.
    pub fn new(asset: Asset<'a>) -> Self {
        Self {
            memory: vec![0.0; asset.pose_len()],
            workspace: Workspace::new(),
            cache: None,
            refined: None,
            found: Vec::new(),
            asset,
        }
    }

    /// The same, all nodes and so many leaves kept during a step from [`CACHED`] queries on.
    pub fn keeping(asset: Asset<'a>, leaves: usize) -> Self {
        let nodes = asset.node_count();
        Self {
            cache: Some(StepCache::new(CacheSize { nodes, leaves })),
            ..Self::new(asset)
        }
    }

    /// On an asset, with the whole pose refined first in each step.
    pub fn refining(asset: Asset<'a>) -> Self {
        Self {
            refined: Some(RefinedPose::new()),
            ..Self::new(asset)
        }
    }

    /// A pose and so many queries, each of which adds what it found to the step's.
    fn step<Q>(
        &mut self,
        Posture { q, bones }: Posture<'_>,
        queries: impl ExactSizeIterator<Item = Q>,
        mut ask: impl FnMut(&mut Query<'_, '_>, &mut Vec<Contact>, Q) -> Result<u64, QueryError>,
    ) -> Result<Answer, MeasureError> {
        let here = Transform::IDENTITY;
        let pose = self
            .asset
            .pose_with_bones(q, bones, here, &mut self.memory)?;
        let mut step = pose.query(&mut self.workspace);
        if let Some(cache) = self.cache.as_mut().filter(|_| queries.len() >= CACHED) {
            cache.start(&pose);
            step = step.cached(cache);
        }
        if let Some(refined) = &mut self.refined {
            refined.prepare(&pose)?;
            step = step.refined(refined);
        }
        let mut answer = Answer::default();
        for query in queries {
            answer.found += ask(&mut step, &mut self.found, query)?;
            answer.nodes.add(step.stats());
        }
        Ok(answer)
    }

    /// A step of balls, by center and radius.
    ///
    /// # Errors
    /// A posture beyond the limits, a ball that is none.
    pub fn balls<'p>(
        &mut self,
        posture: impl Into<Posture<'p>>,
        balls: impl ExactSizeIterator<Item = ([f64; 3], f64)>,
    ) -> Result<Answer, MeasureError> {
        self.step(posture.into(), balls, |step, found, (center, radius)| {
            found.clear();
            step.contacts(Ball::new(center, radius), found)?;
            Ok(found.len() as u64)
        })
    }

    /// A step of rays, by origin and direction: the nearest hit of each.
    ///
    /// # Errors
    /// A posture beyond the limits, a ray that is none.
    pub fn rays<'p>(
        &mut self,
        posture: impl Into<Posture<'p>>,
        rays: impl ExactSizeIterator<Item = [[f64; 3]; 2]>,
    ) -> Result<Answer, MeasureError> {
        self.step(posture.into(), rays, |step, _, [origin, direction]| {
            let hit = step.cast_ray(&Ray::new(origin, direction))?;
            Ok(u64::from(hit.is_some()))
        })
    }
}

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
