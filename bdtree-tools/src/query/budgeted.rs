//! Queries within a number of node visits.

use bdtree_format::LANES;
use bdtree_runtime::query::{Budget, Budgeted};
use bdtree_runtime::{QueryError, SearchEntry};
use serde::Serialize;

use super::{Answer, Solver, two};
use crate::scene::Query;

/// Entries that one query may queue; what finds no room is left out and counts in the bound.
const QUEUE_MAX: usize = 1 << 20;

/// What a query left out.
#[derive(Debug, Serialize)]
pub struct Certificate {
    /// Nothing was left out.
    pub complete: bool,
    /// Nothing that was left out is nearer (ball: has a smaller `dist`); null: nothing is there at
    /// all.
    pub at_least: f64,
    /// ball: at most so many triangles were not looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unseen: Option<u64>,
}

impl<T> From<&Budgeted<T>> for Certificate {
    fn from(answer: &Budgeted<T>) -> Self {
        Self {
            complete: answer.complete,
            at_least: answer.at_least,
            unseen: None,
        }
    }
}

impl Solver<'_, '_> {
    /// Kind, answer, nodes visited and what was left out; `None` for kinds that have no such form.
    pub(super) fn solve_within(
        &mut self,
        query: &Query,
        max_visits: u64,
    ) -> Result<Option<(&'static str, Answer, u64, Certificate)>, QueryError> {
        let room = match *query {
            Query::Ball { instance, .. }
            | Query::Closest { instance, .. }
            | Query::Ray { instance, .. } => self.placed[instance].0.node_count(),
            Query::Distance { a, b, .. } => {
                // Pairs of what lanes lead to.
                let lanes = |instance: usize| LANES * self.placed[instance].0.node_count();
                lanes(a).saturating_mul(lanes(b)).min(QUEUE_MAX)
            }
            _ => return Ok(None),
        };
        let mut queue = vec![SearchEntry::default(); Budget::queue_len(max_visits).min(room)];
        let mut budget = Budget::new(max_visits, &mut queue);
        let solved = match *query {
            Query::Ball {
                instance,
                center,
                radius,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let mut contacts = Vec::new();
                let answer = budget.ball(asset, &mut *pose, center, radius, &mut contacts)?;
                let mut certificate = Certificate::from(&answer);
                certificate.unseen = Some(answer.found.triangles);
                let visits = answer.nodes_visited;
                ("ball", Answer::contacts(contacts), visits, certificate)
            }
            Query::Closest {
                instance,
                point,
                max_distance,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let answer = budget.closest(asset, &mut *pose, point, max_distance)?;
                let certificate = Certificate::from(&answer);
                let visits = answer.nodes_visited;
                let found = Answer::Nearest(answer.found.into());
                ("closest", found, visits, certificate)
            }
            Query::Ray {
                instance,
                origin,
                direction,
                max_distance,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let answer = budget.ray(asset, &mut *pose, origin, direction, max_distance)?;
                let certificate = Certificate::from(&answer);
                let visits = answer.nodes_visited;
                let found = Answer::Nearest(answer.found.into());
                ("ray", found, visits, certificate)
            }
            Query::Distance { a, b, max_distance } => {
                let [(asset_a, pose_a), (asset_b, pose_b)] = two(self.placed, a, b)?;
                let answer = budget.distance((asset_a, pose_a), (asset_b, pose_b), max_distance)?;
                let certificate = Certificate::from(&answer);
                let visits = answer.nodes_visited;
                (
                    "distance",
                    Answer::distance(answer.found),
                    visits,
                    certificate,
                )
            }
            _ => return Ok(None),
        };
        Ok(Some(solved))
    }
}
