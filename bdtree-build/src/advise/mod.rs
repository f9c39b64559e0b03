//! What to bake with, from measurements on the asset itself: how many of its modes its motion needs, and how
//! many triangles a leaf takes.
//!
//! [`samples`] says at which q an asset is judged, [`works`] what is asked of it there; both take an opened
//! asset and serve everything that measures one. A [`Subject`] can be baked again with fewer modes: from a bake's
//! own mesh and fields or from those in a file. [`errors`] says what that costs, [`curve`] what it saves,
//! [`advise`] chooses, [`words`] tells. docs/advice.md has method, limits and how right it is.

pub mod choose;
pub mod curve;
pub mod errors;
pub mod samples;
pub mod subject;
pub mod words;
pub mod works;

use std::fmt;

use bdtree_runtime::FormatError;

use crate::error::BakeError;
pub use choose::{Advice, Goal, advise};
pub use subject::Subject;
use works::WorksError;

/// Why there is no advice.
#[derive(Debug, Clone, PartialEq)]
pub enum AdviceError {
    /// A bake was refused.
    Bake(BakeError),
    /// A file that was made is refused.
    Open(FormatError),
    /// The questions have no answer.
    Works(WorksError),
    /// There was nothing to choose from.
    NothingMeasured,
}

impl fmt::Display for AdviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bake(error) => write!(f, "{error}"),
            Self::Open(error) => write!(f, "{error}"),
            Self::Works(error) => write!(f, "{error}"),
            Self::NothingMeasured => f.write_str("no setting was measured"),
        }
    }
}

impl std::error::Error for AdviceError {}

impl From<BakeError> for AdviceError {
    fn from(error: BakeError) -> Self {
        Self::Bake(error)
    }
}

impl From<FormatError> for AdviceError {
    fn from(error: FormatError) -> Self {
        Self::Open(error)
    }
}

impl From<WorksError> for AdviceError {
    fn from(error: WorksError) -> Self {
        Self::Works(error)
    }
}
