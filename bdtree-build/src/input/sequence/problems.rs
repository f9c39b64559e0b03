//! Problems in the order they are met, the first hundred in full.

use crate::error::{BakeError, Problem};

/// Most problems that are listed one by one.
const PROBLEM_CAP: usize = 100;

/// The problems of one source.
#[derive(Debug)]
pub(crate) struct Problems {
    stage: &'static str,
    listed: Vec<Problem>,
    count: usize,
}

impl Problems {
    /// None yet.
    pub(crate) fn new(stage: &'static str) -> Self {
        Self {
            stage,
            listed: Vec::new(),
            count: 0,
        }
    }

    /// One more; what it says is asked for only if it is listed.
    pub(crate) fn add(&mut self, say: impl FnOnce() -> (String, String)) {
        self.count += 1;
        if self.listed.len() < PROBLEM_CAP {
            let (place, message) = say();
            self.listed.push(Problem {
                stage: self.stage,
                place,
                message,
            });
        }
    }

    /// All problems of another failure.
    pub(crate) fn join(&mut self, error: BakeError) {
        for problem in error.problems {
            self.add(|| (problem.place, problem.message));
        }
    }

    /// A failure if there are problems; `place` is where those that are only counted lie.
    pub(crate) fn into_result(mut self, place: &str) -> Result<(), BakeError> {
        if self.count == 0 {
            return Ok(());
        }
        let more = self.count - self.listed.len();
        if more > 0 {
            self.listed.push(Problem {
                stage: self.stage,
                place: place.to_string(),
                message: format!("{more} more problems"),
            });
        }
        Err(BakeError {
            problems: self.listed,
        })
    }
}
