//! Queries that stop after a number of node visits and say what they may have missed.

mod guided;

use super::ball::Ball;
use super::closest::Closest;
use super::line::Line;
use super::ray::First;
use super::{length, limit};
use crate::cache::{OwnCache, Posed};
use crate::contact::{ClosestPoint, Contact, PairContact, RayHit, Sink};
use crate::error::QueryError;
use crate::traverse::{BudgetedOne, Gap, Guided, LeafPairs, NearestTwo, Queue, SearchEntry};
use crate::view::Asset;
use guided::Deepest;

/// What a query may cost, and memory for what it has not looked at. Its methods are the queries of
/// this module that visit the most promising nodes first, at most `max_visits` of them.
///
/// With each further visit the answer can only get better and its bound can only rise. Without
/// limit, and with memory enough, they return what the plain queries return.
#[derive(Debug)]
pub struct Budget<'s> {
    max_visits: u64,
    queue: &'s mut [SearchEntry],
}

/// What a query found within its budget, and a bound for what it left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budgeted<T> {
    /// The best that was found.
    pub found: T,
    /// Nothing was left out: this is the plain query's answer.
    pub complete: bool,
    /// Certified: the plain query's distance is not below this (world). For a ball, no triangle that
    /// was left out has a `dist` below this. It is the distance itself when `complete`, or the limit
    /// when there is nothing within it.
    pub at_least: f64,
    /// Nodes whose spheres were tested; for distances, pairs of a node and a part of the other asset.
    pub nodes_visited: u64,
    /// Of them, those whose spheres were evaluated.
    pub nodes_updated: u64,
}

/// What a budgeted ball query knows of triangles that it did not report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unseen {
    /// At most this many triangles were neither tested nor ruled out.
    pub triangles: u64,
    /// The sink had no room for everything.
    pub truncated: bool,
}

impl<'s> Budget<'s> {
    /// At most `max_visits` node visits. `queue` may have any length: what finds no room is left out
    /// and counts in the bound; [`Budget::queue_len`] entries always suffice.
    pub fn new(max_visits: u64, queue: &'s mut [SearchEntry]) -> Self {
        Self { max_visits, queue }
    }

    /// Entries that suffice for so many visits, since each puts at most eight in place of one. Queries
    /// of one asset never need more than [`Asset::node_count`].
    pub fn queue_len(max_visits: u64) -> usize {
        usize::try_from(max_visits.saturating_mul(7).saturating_add(1)).unwrap_or(usize::MAX)
    }

    /// [`closest`](super::closest()) within the budget.
    ///
    /// # Errors
    /// Its errors, but for the stack's.
    pub fn closest<'p>(
        &mut self,
        asset: &Asset<'_>,
        pose: impl Into<Posed<'p>>,
        to: [f64; 3],
        max_distance: f64,
    ) -> Result<Budgeted<Option<ClosestPoint>>, QueryError> {
        self.closest_posed(asset, pose.into(), to, max_distance)
    }

    /// [`Budget::closest`], compiled here for all callers.
    fn closest_posed(
        &mut self,
        asset: &Asset<'_>,
        posed: Posed<'_>,
        to: [f64; 3],
        max_distance: f64,
    ) -> Result<Budgeted<Option<ClosestPoint>>, QueryError> {
        let mut visitor = Closest::new(posed.pose, to, max_distance)?;
        let rest = self.one(asset, posed, &mut visitor)?;
        let limit = visitor.best.map_or(max_distance, |best| best.distance);
        Ok(rest.budgeted(visitor.best, limit, visitor.distance(rest.key)))
    }

    /// [`ray`](super::ray()) within the budget.
    ///
    /// # Errors
    /// Its errors, but for the stack's.
    pub fn ray<'p>(
        &mut self,
        asset: &Asset<'_>,
        pose: impl Into<Posed<'p>>,
        origin: [f64; 3],
        direction: [f64; 3],
        max_distance: f64,
    ) -> Result<Budgeted<Option<RayHit>>, QueryError> {
        self.ray_posed(asset, pose.into(), origin, direction, max_distance)
    }

    /// [`Budget::ray`], compiled here for all callers.
    fn ray_posed(
        &mut self,
        asset: &Asset<'_>,
        posed: Posed<'_>,
        origin: [f64; 3],
        direction: [f64; 3],
        max_distance: f64,
    ) -> Result<Budgeted<Option<RayHit>>, QueryError> {
        let Some(line) = Line::new(posed.pose, origin, direction, max_distance)? else {
            if !posed.pose.belongs_to(asset) {
                return Err(QueryError::PoseMismatch);
            }
            return Ok(Rest::NONE.budgeted(None, max_distance, max_distance));
        };
        let mut visitor = First::<false>::new(line);
        let rest = self.one(asset, posed, &mut visitor)?;
        let limit = visitor.best.map_or(max_distance, |best| best.distance);
        Ok(rest.budgeted(visitor.best, limit, visitor.line.distance(rest.key)))
    }

    /// [`ball`](super::ball()) within the budget, the nearest nodes first.
    ///
    /// # Errors
    /// Its errors, but for the stack's.
    pub fn ball<'p>(
        &mut self,
        asset: &Asset<'_>,
        pose: impl Into<Posed<'p>>,
        center: [f64; 3],
        radius: f64,
        sink: &mut impl Sink<Contact>,
    ) -> Result<Budgeted<Unseen>, QueryError> {
        self.ball_posed(asset, pose.into(), center, radius, sink)
    }

    /// [`Budget::ball`], compiled here for all callers.
    fn ball_posed(
        &mut self,
        asset: &Asset<'_>,
        posed: Posed<'_>,
        center: [f64; 3],
        radius: f64,
        sink: &mut dyn Sink<Contact>,
    ) -> Result<Budgeted<Unseen>, QueryError> {
        let radius = length(radius, "radius: negative, not finite or beyond 2^100")?;
        let ball = Ball::new(posed.pose, center, radius, sink)?;
        let near = Closest::new(posed.pose, center, radius)?;
        let mut visitor = Deepest { near, ball };
        let rest = self.one(asset, posed, &mut visitor)?;
        let left = (asset.triangle_count() as u64).saturating_sub(rest.settled);
        let unseen = Unseen {
            triangles: if rest.complete { 0 } else { left },
            truncated: rest.stopped,
        };
        let at_least = visitor.near.distance(rest.key) - radius;
        Ok(rest.budgeted(unseen, 0.0, at_least))
    }

    /// [`distance`](super::distance()) within the budget.
    ///
    /// # Errors
    /// Its errors, but for the stack's.
    pub fn distance<'p, 'q>(
        &mut self,
        (asset1, pose1): (&Asset<'_>, impl Into<Posed<'p>>),
        (asset2, pose2): (&Asset<'_>, impl Into<Posed<'q>>),
        max_distance: f64,
    ) -> Result<Budgeted<Option<PairContact>>, QueryError> {
        let posed = [pose1.into().shorter(), pose2.into().shorter()];
        self.distance_posed([asset1, asset2], posed, max_distance)
    }

    /// [`Budget::distance`], compiled here for all callers.
    fn distance_posed(
        &mut self,
        [asset1, asset2]: [&Asset<'_>; 2],
        posed: [Posed<'_>; 2],
        max_distance: f64,
    ) -> Result<Budgeted<Option<PairContact>>, QueryError> {
        let [posed1, posed2] = posed.map(Posed::shorter);
        let max_distance = limit(max_distance, "max_distance: negative, NaN or beyond 2^100")?;
        if !posed1.pose.belongs_to(asset1) || !posed2.pose.belongs_to(asset2) {
            return Err(QueryError::PoseMismatch);
        }
        let (mut own1, mut own2) = (OwnCache::default(), OwnCache::default());
        let gap = Gap::new(&posed1, &posed2);
        let mut pairs = LeafPairs::new(max_distance);
        let mut queue = Queue::new(self.queue, self.max_visits);
        let walk = asset1.kernel.run(NearestTwo {
            a: (asset1, posed1.or_keep(&mut own1)),
            b: (asset2, posed2.or_keep(&mut own2)),
            gap: &gap,
            frontier: &mut queue,
            pairs: &mut pairs,
        })?;
        let rest = Rest {
            key: queue.rest(),
            complete: queue.is_done(gap.bound(pairs.limit())),
            nodes_visited: walk.nodes_visited,
            nodes_updated: walk.nodes_updated,
            ..Rest::NONE
        };
        Ok(rest.budgeted(pairs.best, pairs.limit(), gap.distance(rest.key)))
    }

    fn one<V: Guided>(
        &mut self,
        asset: &Asset<'_>,
        posed: Posed<'_>,
        visitor: &mut V,
    ) -> Result<Rest, QueryError> {
        if !posed.pose.belongs_to(asset) {
            return Err(QueryError::PoseMismatch);
        }
        let mut queue = Queue::new(self.queue, self.max_visits);
        let mut settled = 0;
        let walk = asset.kernel.run(BudgetedOne {
            asset,
            posed: posed.shorter(),
            queue: &mut queue,
            visitor,
            settled: &mut settled,
        })?;
        Ok(Rest {
            key: queue.rest(),
            complete: !walk.stopped && queue.is_done(visitor.bound()),
            stopped: walk.stopped,
            settled,
            nodes_visited: walk.nodes_visited,
            nodes_updated: walk.nodes_updated,
        })
    }
}

/// How a budgeted search ended.
#[derive(Clone, Copy)]
struct Rest {
    /// Nothing that was left out has a lower key.
    key: f32,
    complete: bool,
    stopped: bool,
    settled: u64,
    nodes_visited: u64,
    nodes_updated: u64,
}

impl Rest {
    /// A search that had nothing to look at.
    const NONE: Self = Self {
        key: f32::INFINITY,
        complete: true,
        stopped: false,
        settled: 0,
        nodes_visited: 0,
        nodes_updated: 0,
    };

    /// `limit`: the best so far, or the query's limit; `left_out`: what is known of the rest.
    fn budgeted<T>(&self, found: T, limit: f64, left_out: f64) -> Budgeted<T> {
        Budgeted {
            found,
            complete: self.complete,
            at_least: if self.complete {
                limit
            } else {
                left_out.min(limit)
            },
            nodes_visited: self.nodes_visited,
            nodes_updated: self.nodes_updated,
        }
    }
}
