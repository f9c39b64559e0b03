//! What to bake with, from measurements on the asset itself: how many of its modes its motion needs, and how
//! many triangles a leaf takes.
//!
//! [`samples`] says at which q and with which bones an asset is judged, [`works`] what is asked of it there; both take an opened
//! asset and serve everything that measures one. A [`Subject`] can be baked again with fewer modes: from a bake's
//! own mesh and fields or from those in a file. [`errors`] says what that costs, [`curve`] what it saves,
//! [`advise`] chooses, [`words`] tells. docs/reference/advice.md has method, limits and how right it is.

pub mod choose;
pub mod curve;
pub mod errors;
mod from_file;
mod postures;
pub mod samples;
pub mod subject;
pub mod words;
pub mod works;

use bdtree_runtime::{FormatError, SkeletonError};

use crate::error::BakeError;
pub use choose::{Advice, Goal, advise};
pub use subject::Subject;
use works::WorksError;

/// Why there is no advice.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AdviceError {
    /// A bake was refused.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A file that was made is refused.
    #[error(transparent)]
    Open(#[from] FormatError),
    /// A clip cannot be played.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
    /// The questions have no answer.
    #[error(transparent)]
    Works(#[from] WorksError),
    /// There was nothing to choose from.
    #[error("no setting was measured")]
    NothingMeasured,
}
