//! Queries within a number of node visits.

use bdtree_runtime::{Budgeted, Contact, QueryError, Shape};
use serde::Serialize;

use super::{Answer, Solver};
use crate::scene::Query;

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

impl Solver<'_> {
    /// The answer and what was left out; `None` for kinds that have no such form.
    pub(super) fn solve_within(
        &mut self,
        query: &Query,
        max_visits: u64,
    ) -> Result<Option<(Answer, Certificate)>, QueryError> {
        let solved = match *query {
            Query::Contacts {
                instance,
                shape: Shape::Ball(ball),
            } => {
                let mut contacts: Vec<Contact> = Vec::new();
                let mut query = self.whole(instance).max_visits(max_visits);
                let rest = query.contacts(ball, &mut contacts)?;
                let certificate = Certificate {
                    complete: rest.complete,
                    at_least: rest.at_least,
                    unseen: Some(rest.unseen_triangles),
                };
                (Answer::contacts(contacts), certificate)
            }
            Query::Closest {
                instance,
                point,
                max_distance,
            } => {
                let mut query = self.whole(instance).max_visits(max_visits);
                let answer = query.project_point(point, max_distance)?;
                let certificate = Certificate::from(&answer);
                (Answer::Nearest(answer.found.into()), certificate)
            }
            Query::Ray { instance, ref ray } => {
                let answer = self.whole(instance).max_visits(max_visits).cast_ray(ray)?;
                let certificate = Certificate::from(&answer);
                (Answer::Nearest(answer.found.into()), certificate)
            }
            Query::Distance { a, b, max_distance } => {
                let mut query = self.whole_pair([a, b])?.max_visits(max_visits);
                let answer = query.closest_points(max_distance)?;
                let certificate = Certificate::from(&answer);
                (Answer::distance(answer.found), certificate)
            }
            _ => return Ok(None),
        };
        Ok(Some(solved))
    }
}
