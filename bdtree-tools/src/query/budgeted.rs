//! Queries within a number of node visits.

use bdtree_runtime::{Budgeted, Contact, QueryError, Shape};

use super::Solver;
use super::lines::{Answer, Certificate};
use crate::scene::Query;

impl Solver<'_> {
    /// The answer and what was left out; `None` for kinds that have no such form.
    pub(super) fn solve_within(
        &mut self,
        query: &Query,
        max_visits: u64,
    ) -> Result<Option<(Answer, Certificate)>, QueryError> {
        Ok(Some(match *query {
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
                told(answer, |hit| Answer::Nearest(hit.into()))
            }
            Query::Ray { instance, ref ray } => {
                let answer = self.whole(instance).max_visits(max_visits).cast_ray(ray)?;
                told(answer, |hit| Answer::Nearest(hit.into()))
            }
            Query::Distance { a, b, max_distance } => {
                let mut query = self.whole_pair([a, b])?.max_visits(max_visits);
                told(query.closest_points(max_distance)?, Answer::distance)
            }
            _ => return Ok(None),
        }))
    }
}

fn told<T>(answer: Budgeted<T>, line: impl FnOnce(T) -> Answer) -> (Answer, Certificate) {
    let certificate = Certificate {
        complete: answer.complete,
        at_least: answer.at_least,
        unseen: None,
    };
    (line(answer.found), certificate)
}
