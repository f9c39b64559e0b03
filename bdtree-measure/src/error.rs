//! Why something could not be measured.

use bdtree_build::advise::AdviceError;
use bdtree_build::advise::works::WorksError;
use bdtree_runtime::{FormatError, PoseError, QueryError, SkeletonError};

/// Why an asset could not be measured: of a file whose rules were checked before, one that changed since, say.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
#[non_exhaustive]
pub enum MeasureError {
    /// The file breaks a rule of the format.
    Format(#[from] FormatError),
    /// A pose is beyond the asset's limits.
    Pose(#[from] PoseError),
    /// A query gave no answer.
    Query(#[from] QueryError),
    /// A clip cannot be played.
    Skeleton(#[from] SkeletonError),
    /// Bones at rest are refused.
    Works(#[from] WorksError),
    /// The asset could not be baked with fewer modes.
    Advice(#[from] AdviceError),
}
