//! Why a model cannot become a shape.

use core::fmt;

use bdtree_runtime::{FormatError, PoseError, QueryError};

/// Why a model, a q or a step is refused.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ShapeError {
    /// The asset is damaged.
    Format(FormatError),
    /// q or the scale is not one that the asset takes.
    Pose(PoseError),
    /// A query failed, which it does on a damaged asset alone.
    Query(QueryError),
    /// Modes, mass or step are not what an oscillator can be made of; the text says which.
    Dynamics(String),
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(error) => error.fmt(f),
            Self::Pose(error) => error.fmt(f),
            Self::Query(error) => error.fmt(f),
            Self::Dynamics(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for ShapeError {}

impl From<FormatError> for ShapeError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

impl From<PoseError> for ShapeError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}

impl From<QueryError> for ShapeError {
    fn from(error: QueryError) -> Self {
        Self::Query(error)
    }
}
