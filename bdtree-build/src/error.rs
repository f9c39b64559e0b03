//! What can be wrong with a bake: every problem with its stage and place, not only the first.

use std::fmt;

/// One problem, and where it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The stage of the bake that found it: `input`, `basis`, `tree`, `encode`, `file`.
    pub stage: &'static str,
    /// Where: `mesh.obj:12`, `U.npy: shape`, `vertex 7`. Empty when the problem has no place.
    pub place: String,
    /// What is wrong and, where it is known, what would be right.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.is_empty() {
            write!(f, "{}", self.message)
        } else {
            write!(f, "{}: {}", self.place, self.message)
        }
    }
}

/// Why a bake failed: one problem or more, in the order they were met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BakeError {
    /// Never empty.
    pub problems: Vec<Problem>,
}

impl BakeError {
    /// A failure with a single problem.
    pub fn one(stage: &'static str, place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            problems: vec![Problem {
                stage,
                place: place.into(),
                message: message.into(),
            }],
        }
    }
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for BakeError {}
