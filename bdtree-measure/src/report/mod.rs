//! The report on an asset: what each choice costs and buys, measured on the asset itself.
//!
//! [`measure`] fills a [`content::Content`]; [`page`] and the JSON of `bdtree report` are made of it. Counts and errors
//! are the same in every run on processors of the same kind, times are not.

mod advice;
mod comparison;
pub mod content;
mod depth;
mod lanes;
mod measure;
mod modes;
mod page;
mod sample;
mod sections;
mod text;
mod tightness;
mod tolerance;
mod words;

use bdtree_build::advise::AdviceError;
use bdtree_runtime::{FormatError, PoseError, QueryError};

pub use measure::{Subject, measure};
pub use page::page;

/// Repetitions of which times are medians.
const REPETITIONS: usize = 5;

/// Why an asset could not be measured: of a file whose rules were checked before, one that changed since, say.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
#[non_exhaustive]
pub enum ReportError {
    /// The file breaks a rule of the format.
    Format(#[from] FormatError),
    /// A sample is beyond the asset's limits.
    Pose(#[from] PoseError),
    /// A query gave no answer.
    Query(#[from] QueryError),
    /// The asset could not be baked with fewer modes.
    Advice(#[from] AdviceError),
}
