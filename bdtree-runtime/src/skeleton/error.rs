//! Why a skeleton has no pose.

use core::fmt;

use crate::error::FormatError;

/// Why a skeleton has no pose.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SkeletonError {
    /// The asset has no skin, so no skeleton.
    NoSkin,
    /// There is no such clip.
    NoClip {
        /// Clips of the asset.
        count: usize,
        /// What was asked for.
        found: usize,
    },
    /// The time is not finite.
    Time,
    /// The weight of a blend is not finite.
    Weight,
    /// A slice of the caller's has another length than it must have.
    Length {
        /// What it holds.
        what: &'static str,
        /// How many of them there are.
        expected: usize,
        /// Length of the slice.
        found: usize,
    },
    /// The file breaks a rule of the format there.
    Corrupt(FormatError),
}

impl From<FormatError> for SkeletonError {
    fn from(error: FormatError) -> Self {
        Self::Corrupt(error)
    }
}

impl fmt::Display for SkeletonError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSkin => f.write_str("the asset has no skin"),
            Self::NoClip { count, found } => {
                write!(f, "there is no clip {found}: the asset has {count}")
            }
            Self::Time => f.write_str("the time is not a finite number"),
            Self::Weight => f.write_str("the weight is not a finite number"),
            Self::Length {
                what,
                expected,
                found,
            } => write!(f, "{found} {what} are given, {expected} are needed"),
            Self::Corrupt(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for SkeletonError {}

/// Refuses a slice of another length.
pub(super) fn same_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), SkeletonError> {
    if found == expected {
        return Ok(());
    }
    Err(SkeletonError::Length {
        what,
        expected,
        found,
    })
}
