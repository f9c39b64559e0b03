//! Queries that stop after a number of node visits and say what they may have missed.

mod guided;

use super::ball::Ball;
use super::distance::whole;
use super::line::Line;
use super::project::Closest;
use super::ray::First;
use super::{length, limit};
use crate::cache::{OwnCache, Posed};
use crate::contact::{Contact, Coverage, PairContact, PointProjection, RayIntersection, Sink};
use crate::error::QueryError;
use crate::shape::{self, Ray};
use crate::traverse::{BudgetedOne, Gap, LeafPairs, NearestTwo, Queue, SearchEntry, Visitor, Walk};
use guided::Deepest;

/// The best that a query found within its budget, and a bound for what it left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budgeted<T> {
    /// The best that was found.
    pub found: T,
    /// Nothing was left out: this is the answer that the query gives without a budget.
    pub complete: bool,
    /// Certified: the distance that the query gives without a budget is not below this (world). It is the
    /// distance itself when `complete`, or the limit when there is nothing within it.
    pub at_least: f64,
}

/// What a query for contacts knows within its budget, besides those that it reported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetedContacts {
    /// Whether the sink had room for all.
    pub coverage: Coverage,
    /// Nothing was left out: all contacts were reported.
    pub complete: bool,
    /// At most this many triangles were neither tested nor ruled out.
    pub unseen_triangles: u64,
    /// Certified: no triangle that was left out has a contact distance below this (world).
    pub at_least: f64,
}

/// What a query may cost, and memory for what it has not looked at; what finds no room there is left out
/// and counts in the bound.
pub(super) struct Budget<'s> {
    pub(super) max_visits: u64,
    pub(super) queue: &'s mut [SearchEntry],
}

/// Entries that suffice for so many visits, since each puts at most eight in place of one. Queries
/// of one asset never need more than it has nodes.
pub(super) fn queue_len(max_visits: u64) -> usize {
    usize::try_from(max_visits.saturating_mul(7).saturating_add(1)).unwrap_or(usize::MAX)
}

impl Budget<'_> {
    /// [`super::project::project`] within the budget.
    pub(super) fn project(
        &mut self,
        posed: Posed<'_>,
        to: [f64; 3],
        max_distance: f64,
    ) -> Result<(Budgeted<Option<PointProjection>>, Walk), QueryError> {
        let pose = posed.pose;
        let mut visitor = Closest::new(pose, to, max_distance)?;
        let rest = self.one(posed, &mut visitor)?;
        let limit = visitor.best.map_or(max_distance, |best| best.distance);
        let found = visitor.projection(pose)?;
        Ok(rest.budgeted(found, limit, visitor.distance(rest.key)))
    }

    /// [`super::ray::first`] within the budget.
    pub(super) fn ray(
        &mut self,
        posed: Posed<'_>,
        ray: &Ray,
    ) -> Result<(Budgeted<Option<RayIntersection>>, Walk), QueryError> {
        let max_distance = ray.max_distance;
        let Some(line) = Line::new(posed.pose, ray, false)? else {
            return Ok(Rest::NONE.budgeted(None, max_distance, max_distance));
        };
        let mut visitor = First::new(line);
        let rest = self.one(posed, &mut visitor)?;
        let limit = visitor.best.map_or(max_distance, |best| best.distance);
        let left_out = visitor.line.distance(rest.key);
        Ok(rest.budgeted(visitor.best, limit, left_out))
    }

    /// [`super::ball::contacts`] within the budget, the nearest nodes first.
    pub(super) fn ball(
        &mut self,
        posed: Posed<'_>,
        ball: &shape::Ball,
        sink: &mut dyn Sink<Contact>,
    ) -> Result<(BudgetedContacts, Walk), QueryError> {
        let radius = length(ball.radius, "radius: negative, not finite or beyond 2^100")?;
        let triangles = posed.pose.asset.triangle_count() as u64;
        let near = Closest::new(posed.pose, ball.center, radius)?;
        let ball = Ball::new(posed.pose, ball, sink)?;
        let mut visitor = Deepest { near, ball };
        let rest = self.one(posed, &mut visitor)?;
        let left = triangles.saturating_sub(rest.settled);
        let (bound, walk) = rest.budgeted((), 0.0, visitor.near.distance(rest.key) - radius);
        let contacts = BudgetedContacts {
            coverage: Coverage::of(walk.stopped),
            complete: bound.complete,
            unseen_triangles: if bound.complete { 0 } else { left },
            at_least: bound.at_least,
        };
        Ok((contacts, walk))
    }

    /// [`super::distance::closest_points`] within the budget.
    pub(super) fn closest_points(
        &mut self,
        [posed1, posed2]: [Posed<'_>; 2],
        max_distance: f64,
    ) -> Result<(Budgeted<Option<PairContact>>, Walk), QueryError> {
        let max_distance = limit(max_distance)?;
        let (pose1, pose2) = (posed1.pose, posed2.pose);
        let (mut own1, mut own2) = (OwnCache::default(), OwnCache::default());
        let gap = Gap::new(&posed1, &posed2);
        let mut pairs = LeafPairs::new(max_distance);
        let mut queue = Queue::new(self.queue, self.max_visits);
        let walk = pose1.asset.kernel.run(NearestTwo {
            posed: [posed1.or_keep(&mut own1), posed2.or_keep(&mut own2)],
            gap: &gap,
            frontier: &mut queue,
            pairs: &mut pairs,
        })?;
        let rest = Rest {
            key: queue.rest(),
            complete: queue.is_done(gap.bound(pairs.limit())),
            walk,
            ..Rest::NONE
        };
        let found = whole([pose1, pose2], pairs.best)?;
        Ok(rest.budgeted(found, pairs.limit(), gap.distance(rest.key)))
    }

    fn one<V: Visitor>(&mut self, posed: Posed<'_>, visitor: &mut V) -> Result<Rest, QueryError> {
        let mut queue = Queue::new(self.queue, self.max_visits);
        let mut settled = 0;
        let walk = posed.pose.asset.kernel.run(BudgetedOne {
            posed: posed.shorter(),
            queue: &mut queue,
            visitor,
            settled: &mut settled,
        })?;
        Ok(Rest {
            key: queue.rest(),
            complete: !walk.stopped && queue.is_done(visitor.bound()),
            settled,
            walk,
        })
    }
}

/// How a budgeted search ended.
#[derive(Clone, Copy)]
struct Rest {
    /// Nothing that was left out has a lower key.
    key: f32,
    complete: bool,
    /// Triangles that were tested or ruled out.
    settled: u64,
    walk: Walk,
}

impl Rest {
    /// A search that had nothing to look at.
    const NONE: Self = Self {
        key: f32::INFINITY,
        complete: true,
        settled: 0,
        walk: Walk {
            nodes_visited: 0,
            nodes_updated: 0,
            triangles: 0,
            gain: 0,
            of_spheres: 0,
            stopped: false,
        },
    };

    /// `limit`: the best so far, or the query's limit; `left_out`: what is known of the rest.
    fn budgeted<T>(&self, found: T, limit: f64, left_out: f64) -> (Budgeted<T>, Walk) {
        let at_least = if self.complete {
            limit
        } else {
            left_out.min(limit)
        };
        let budgeted = Budgeted {
            found,
            complete: self.complete,
            at_least,
        };
        (budgeted, self.walk)
    }
}
