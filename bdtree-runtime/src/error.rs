//! What can be wrong, one type per boundary; none allocates.

use bdtree_format::SectionKind;
use core::fmt;

/// A value that a rule expected or found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Datum {
    /// Words.
    Text(&'static str),
    /// A count, offset or checksum.
    Integer(u64),
    /// A signed number.
    Signed(i64),
    /// A real number.
    Real(f64),
    /// A section kind.
    Kind(SectionKind),
}

impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Integer(x) => write!(f, "{x}"),
            Self::Signed(x) => write!(f, "{x}"),
            Self::Real(x) => write!(f, "{x:?}"),
            Self::Kind(kind) => write!(f, "{kind}"),
        }
    }
}

/// The pseudo-section under which errors of the header block are reported.
pub const HEADER_SECTION: SectionKind = SectionKind(*b"HEAD");

/// Bytes that break a rule of the format: where, which rule, what it asks and what is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormatError {
    /// The section, or [`HEADER_SECTION`].
    pub section: SectionKind,
    /// Offset from the start of the file.
    pub byte: u64,
    /// Number and words of the rule in `SPEC.md`.
    pub rule: &'static str,
    /// What the rule asks for.
    pub expected: Datum,
    /// What the file holds.
    pub found: Datum,
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "section {} at byte {}: {}: expected {}, found {}",
            self.section, self.byte, self.rule, self.expected, self.found
        )
    }
}

impl core::error::Error for FormatError {}

/// Why a pose or a placement is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PoseError {
    /// q has another length than the asset has modes.
    ModeCount {
        /// Modes of the asset.
        expected: usize,
        /// Length of q.
        found: usize,
    },
    /// The caller's memory is shorter than q.
    Memory {
        /// Numbers needed.
        needed: usize,
        /// Numbers given.
        found: usize,
    },
    /// An entry of q is NaN or infinite.
    NotFinite {
        /// Its index.
        mode: usize,
    },
    /// An entry of q is beyond the asset's hard limit.
    OverLimit {
        /// Its index.
        mode: usize,
        /// |q_j|.
        found: f32,
        /// The asset's limit.
        limit: f32,
    },
    /// The tolerance is NaN or negative.
    Tolerance,
    /// The quaternion is not finite or its norm is off by more than 1e-3.
    Rotation,
    /// A translation is not finite or beyond 2^80.
    Translation,
    /// The reference is not the pose that the cache was started with, or a pose is one of another asset.
    Reference,
    /// The scale is not within 2^-60 … 2^60.
    Scale,
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ModeCount { expected, found } => {
                write!(
                    f,
                    "q has {found} entries but the asset has {expected} modes"
                )
            }
            Self::Memory { needed, found } => {
                write!(f, "pose memory holds {found} numbers, {needed} are needed")
            }
            Self::NotFinite { mode } => write!(f, "q[{mode}] is not a finite number"),
            Self::OverLimit { mode, found, limit } => {
                write!(
                    f,
                    "q[{mode}]: |{found}| is over the asset's limit of {limit}"
                )
            }
            Self::Tolerance => f.write_str("the pose's tolerance is NaN or negative"),
            Self::Rotation => {
                f.write_str("rotation is not a quaternion within 1e-3 of unit length")
            }
            Self::Translation => f.write_str("translation is not finite or beyond 2^80"),
            Self::Reference => f.write_str(
                "the reference is not the pose that the cache was started with, or of another asset",
            ),
            Self::Scale => f.write_str("scale is not one positive number between 2^-60 and 2^60"),
        }
    }
}

impl core::error::Error for PoseError {}

/// Why a query gives no answer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum QueryError {
    /// The pose was made for another asset.
    PoseMismatch,
    /// An argument is NaN, infinite, beyond 2^100, a zero vector, or negative where a length is
    /// meant. The text names it.
    Argument(&'static str),
    /// The caller's memory is shorter than `Asset::stack_len`, `Asset::pair_stack_len` or
    /// `broad::grid_slots` says.
    Memory {
        /// Entries needed.
        needed: usize,
        /// Entries given.
        found: usize,
    },
    /// The asset's bytes break a rule that only the deep check reads; run `verify`.
    Corrupt(FormatError),
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PoseMismatch => f.write_str("the pose was made for another asset"),
            Self::Argument(what) => f.write_str(what),
            Self::Memory { needed, found } => {
                write!(
                    f,
                    "the caller's memory holds {found} entries, {needed} are needed"
                )
            }
            Self::Corrupt(error) => write!(f, "corrupt asset: {error}"),
        }
    }
}

impl core::error::Error for QueryError {}

impl From<FormatError> for QueryError {
    fn from(error: FormatError) -> Self {
        Self::Corrupt(error)
    }
}
