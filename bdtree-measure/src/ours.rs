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
    is_refined: bool,
    /// Contacts of the last ball.
    pub found: Vec<Contact>,
}

/// Rays that are asked together.
const BATCH: usize = 128;

const NO_RAY: Ray = Ray {
    origin: [0.0; 3],
    direction: [0.0; 3],
    max_distance: 0.0,
};

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
            is_refined: false,
            found: Vec::new(),
            asset,
        }
    }

    /// The same, all nodes and so many leaves kept during a step from [`CACHED`] queries on, and poses refined where it pays.
    pub fn keeping(asset: Asset<'a>, leaves: usize) -> Self {
        let nodes = asset.node_count();
        let cache = StepCache::new(CacheSize { nodes, leaves });
        Self {
            cache: Some(cache.refining(RefinedPose::new())),
            ..Self::new(asset)
        }
    }

    /// Whether the last step has refined its pose by itself.
    pub fn is_refined(&self) -> bool {
        self.is_refined
    }

    /// On an asset, with the whole pose refined first in each step.
    pub fn refining(asset: Asset<'a>) -> Self {
        Self {
            refined: Some(RefinedPose::new()),
            ..Self::new(asset)
        }
    }

    /// A pose and so many queries, which `ask` adds to the step's answer.
    fn step(
        &mut self,
        Posture { q, bones }: Posture<'_>,
        count: usize,
        ask: impl FnOnce(&mut Query<'_, '_>, &mut Vec<Contact>, &mut Answer) -> Result<(), QueryError>,
    ) -> Result<Answer, MeasureError> {
        let here = Transform::IDENTITY;
        let pose = self
            .asset
            .pose_with_bones(q, bones, here, &mut self.memory)?;
        let mut step = pose.query(&mut self.workspace);
        let is_cached = count >= CACHED;
        if let Some(cache) = self.cache.as_mut().filter(|_| is_cached) {
            cache.start(&pose);
            step = step.cached(cache);
        }
        if let Some(refined) = &mut self.refined {
            refined.prepare(&pose)?;
            step = step.refined(refined);
        }
        let mut answer = Answer::default();
        ask(&mut step, &mut self.found, &mut answer)?;
        let by_itself = self.cache.as_ref().is_some_and(StepCache::is_refined);
        self.is_refined = is_cached && by_itself;
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
        let count = balls.len();
        self.step(posture.into(), count, |step, found, answer| {
            for (center, radius) in balls {
                found.clear();
                step.contacts(Ball::new(center, radius), found)?;
                answer.found += found.len() as u64;
                answer.nodes.add(step.stats());
            }
            Ok(())
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
        let count = rays.len();
        self.step(posture.into(), count, |step, _, answer| {
            let mut rays = rays.map(|[origin, direction]| Ray::new(origin, direction));
            if count < BATCH {
                for ray in rays {
                    answer.found += u64::from(step.cast_ray(&ray)?.is_some());
                    answer.nodes.add(step.stats());
                }
                return Ok(());
            }
            let (mut batch, mut hits) = ([NO_RAY; BATCH], [None; BATCH]);
            loop {
                let len = batch
                    .iter_mut()
                    .zip(&mut rays)
                    .map(|(to, ray)| *to = ray)
                    .count();
                if len == 0 {
                    return Ok(());
                }
                step.cast_rays(&batch[..len], &mut hits)?;
                answer.found += hits[..len].iter().flatten().count() as u64;
                answer.nodes.add(step.stats());
            }
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
