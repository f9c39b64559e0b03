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
    /// This or less.
    AtMost(f64),
    /// This or more.
    AtLeast(f64),
    /// The first or more, and the second or less.
    Within(f64, f64),
    /// Less than this: an index, of so many elements.
    Below(u64),
}

impl Datum {
    /// [`Datum::AtMost`] of a number.
    pub(crate) fn at_most(limit: impl Into<Self>) -> Self {
        Self::AtMost(limit.into().number())
    }

    /// [`Datum::AtLeast`] of a number.
    pub(crate) fn at_least(limit: impl Into<Self>) -> Self {
        Self::AtLeast(limit.into().number())
    }

    /// NaN where it is none.
    fn number(self) -> f64 {
        match self {
            Self::Integer(x) | Self::Below(x) => x as f64,
            Self::Signed(x) => x as f64,
            Self::Real(x) | Self::AtMost(x) | Self::AtLeast(x) => x,
            Self::Text(_) | Self::Kind(_) | Self::Within(..) => f64::NAN,
        }
    }
}

impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Integer(x) => write!(f, "{x}"),
            Self::Signed(x) => write!(f, "{x}"),
            Self::Real(x) => write!(f, "{x:?}"),
            Self::Kind(kind) => write!(f, "{kind}"),
            Self::AtMost(x) => write!(f, "at most {x}"),
            Self::AtLeast(x) => write!(f, "at least {x}"),
            Self::Within(low, high) => write!(f, "{low} to {high}"),
            Self::Below(count) => write!(f, "less than {count}"),
        }
    }
}

/// What a rule compares, as the datum of its kind.
macro_rules! datum_from {
    ($($variant:ident: $($type:ty),+;)+) => {
        $($(impl From<$type> for Datum {
            fn from(x: $type) -> Self {
                Self::$variant(x.into())
            }
        })+)+
    };
}

datum_from! {
    Text: &'static str;
    Integer: u8, u16, u32, u64;
    Signed: i8, i32;
    Real: f32, f64;
    Kind: SectionKind;
}

impl From<usize> for Datum {
    fn from(x: usize) -> Self {
        Self::Integer(x as u64)
    }
}

/// The pseudo-section under which errors of the header block are reported.
pub const HEADER_SECTION: SectionKind = SectionKind(*b"HEAD");

/// Bytes that break a rule of the format: where, which rule, what it asks and what is there.
///
/// Functions that take a triangle id, a vertex id or a slice return it too where that does not fit the asset, and then
/// the file may be sound. The text then names the argument instead of a place, and `rule` is
/// `SPEC 7.2: a triangle id is below F`, `SPEC 7.1: a vertex id is below N`, or the name of the slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormatError {
    /// The section, or [`HEADER_SECTION`].
    pub section: SectionKind,
    /// Offset from the start of the file.
    pub byte: u64,
    /// Number and words of the rule in `SPEC.md`, or which argument is wrong.
    pub rule: &'static str,
    /// What the rule asks for; of an index [`Datum::Below`].
    pub expected: Datum,
    /// What the file holds, or what was given.
    pub found: Datum,
}

/// The rule of the first bytes.
pub(crate) const MAGIC_BYTES: &str = "SPEC 9.1: the file starts with the magic bytes";
/// The rule that a file too short for a header breaks.
pub(crate) const WHOLE_HEADER: &str = "SPEC 2.1: a file starts with a whole header";
/// The rule that a file too short for its tables breaks.
pub(crate) const WHOLE_TABLES: &str = "SPEC 3.4: the header block lies inside the file";
/// The rule of the file's length.
pub(crate) const FILE_LENGTH: &str = "SPEC 3.4: file_bytes is the file's length";
/// The rule of the version.
pub(crate) const ONE_VERSION: &str = "SPEC 9.1: readers know one major version";
/// The rule of the header's checksum.
pub(crate) const HEADER_CRC: &str = "SPEC 2.4: header_crc is the CRC-32 of the header block";
/// The rule of the sections' checksums.
pub(crate) const SECTION_CRC: &str = "SPEC 4.1: a section's bytes have its checksum";
/// What a caller's triangle id breaks.
pub(crate) const TRIANGLE_BELOW: &str = "SPEC 7.2: a triangle id is below F";
/// What a caller's vertex id breaks.
pub(crate) const VERTEX_BELOW: &str = "SPEC 7.1: a vertex id is below N";
/// What a caller's slice of generalised forces, or of displacements, breaks.
pub(crate) const OUT_LENGTH: &str = "argument `out`: one number per mode";

impl FormatError {
    /// What is wrong, in words, without place and rule.
    fn fault(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (expected, found) = (self.expected, self.found);
        match (self.rule, expected, found) {
            (MAGIC_BYTES, ..) => {
                f.write_str("not a .bdt file, or one that was transferred as text")
            }
            (ONE_VERSION, ..) => write!(
                f,
                "format version {found} is not supported (this program reads {expected})"
            ),
            (WHOLE_HEADER, Datum::AtLeast(bytes), _) => {
                write!(f, "the file has {found} bytes, its header needs {bytes}")
            }
            (WHOLE_TABLES, Datum::AtLeast(bytes), _) => write!(
                f,
                "the file has {found} bytes, its header and tables need {bytes}"
            ),
            (FILE_LENGTH, ..) => {
                write!(f, "the file has {found} bytes, its header says {expected}")
            }
            (HEADER_CRC, Datum::Integer(bytes), Datum::Integer(stored)) => write!(
                f,
                "checksum mismatch: the header says {stored:08x}, the bytes give {bytes:08x}"
            ),
            (TRIANGLE_BELOW, Datum::Below(count), _) => {
                write!(f, "there is no triangle {found}: the asset has {count}")
            }
            (VERTEX_BELOW, Datum::Below(count), _) => {
                write!(f, "there is no vertex {found}: the asset has {count}")
            }
            (OUT_LENGTH, Datum::AtLeast(modes), _) => write!(
                f,
                "argument `out` holds {found} numbers, the asset has {modes} modes"
            ),
            (SECTION_CRC, Datum::Integer(stored), Datum::Integer(bytes)) => write!(
                f,
                "checksum mismatch: the section table says {stored:08x}, the bytes give {bytes:08x}"
            ),
            _ => write!(f, "found {found}, expected {expected}"),
        }
    }
}

impl fmt::Display for FormatError {
    /// The place, the fault, and behind it the rule; of an argument the fault alone.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if matches!(self.rule, TRIANGLE_BELOW | VERTEX_BELOW | OUT_LENGTH) {
            return self.fault(f);
        }
        write!(f, "section {} at byte {}: ", self.section, self.byte)?;
        self.fault(f)?;
        write!(f, " ({})", self.rule)
    }
}

impl core::error::Error for FormatError {}

/// A place in a file, and the rule that is checked there.
#[derive(Clone, Copy)]
pub(crate) struct Check {
    section: SectionKind,
    byte: u64,
    rule: &'static str,
}

impl Check {
    /// The place of a byte of the file, in a section's records or in the header block.
    pub(crate) fn at(section: SectionKind, byte: u64) -> Self {
        let rule = "";
        Self {
            section,
            byte,
            rule,
        }
    }

    /// Number and words of the rule in `SPEC.md`.
    pub(crate) fn rule(self, rule: &'static str) -> Self {
        Self { rule, ..self }
    }

    /// The error of bytes that break the rule.
    #[cold]
    pub(crate) fn broken(self, expected: impl Into<Datum>, found: impl Into<Datum>) -> FormatError {
        FormatError {
            section: self.section,
            byte: self.byte,
            rule: self.rule,
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// [`Check::broken`] unless `ok`.
    pub(crate) fn holds(
        self,
        ok: bool,
        expected: impl Into<Datum>,
        found: impl Into<Datum>,
    ) -> Result<(), FormatError> {
        if ok {
            Ok(())
        } else {
            Err(self.broken(expected, found))
        }
    }
}

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
    /// The caller's memory is shorter than [`Asset::pose_len`](crate::Asset::pose_len).
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
        /// The entry, q_j.
        found: f32,
        /// The asset's limit.
        limit: f32,
    },
    /// Matrices for the bones of an asset that has none.
    NoSkin,
    /// Another number of joint matrices than the asset has joints.
    JointCount {
        /// Joints of the asset.
        expected: usize,
        /// Matrices given.
        found: usize,
    },
    /// Another number of skinning matrices than the asset has bones.
    BoneCount {
        /// Bones of the asset.
        expected: usize,
        /// Matrices given.
        found: usize,
    },
    /// A matrix of a joint or bone has an element that is not finite, or moves vertices beyond 2^60 stored units.
    MatrixRange {
        /// Its index.
        index: usize,
    },
    /// The tolerance is NaN or negative.
    Tolerance,
    /// The quaternion is not finite or its norm is off by more than 1e-3.
    Rotation,
    /// A translation is not finite or beyond 2^80.
    Translation,
    /// The matrix is not a rotation with one positive scale and a translation.
    Matrix,
    /// The last row of a placement's or a joint's matrix is not 0, 0, 0, 1.
    Projection,
    /// The scale is not between 2^-60 and 2^60.
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
            Self::NoSkin => f.write_str("matrices are given but the asset has no skin"),
            Self::JointCount { expected, found } => write!(
                f,
                "{found} joint matrices are given but the asset has {expected} joints"
            ),
            Self::BoneCount { expected, found } => write!(
                f,
                "{found} skinning matrices are given but the asset has {expected} bones"
            ),
            Self::MatrixRange { index } => write!(
                f,
                "matrix {index} is not finite or moves vertices beyond 2^60 stored units"
            ),
            Self::OverLimit { mode, found, limit } => {
                write!(f, "q[{mode}] = {found} exceeds the limit of {limit}")
            }
            Self::Tolerance => f.write_str("the pose's tolerance is NaN or negative"),
            Self::Rotation => {
                f.write_str("rotation is not a quaternion within 1e-3 of unit length")
            }
            Self::Translation => f.write_str("translation is not finite or beyond 2^80"),
            Self::Matrix => f.write_str(
                "the matrix is not a rotation with one positive scale and a translation",
            ),
            Self::Projection => f.write_str(
                "the matrix projects: its last row is not 0, 0, 0, 1 (are rows and columns exchanged?)",
            ),
            Self::Scale => f.write_str("scale is not between 2^-60 and 2^60"),
        }
    }
}

impl core::error::Error for PoseError {}

/// Why a query gives no answer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum QueryError {
    /// The cache was started with another pose, or not at all: call [`StepCache::start`](crate::StepCache::start) with
    /// this one.
    Cache,
    /// The pose has no [`Motion`](crate::Motion), which a front needs, or the motion was last advanced to another pose.
    Motion,
    /// An argument is NaN, infinite, beyond 2^100, a zero vector, or a negative length; an option cannot be combined
    /// with this query or with another option; a slice for answers is too short. The text names it.
    Argument(&'static str),
    /// The bytes of a workspace or cache are too few:
    /// [`Workspace::bytes_for`](crate::Workspace::bytes_for).
    Memory {
        /// Bytes needed, from an address that is a multiple of eight.
        needed: usize,
        /// Bytes given.
        found: usize,
    },
    /// The sink of proxies was full, and the query's return type cannot say that the answer is incomplete:
    /// [`Query::max_level`](crate::Query::max_level).
    Proxies,
    /// The asset's bytes break a rule that only the deep check reads; run `verify`.
    Corrupt(FormatError),
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cache => f.write_str("the cache was not started with this pose"),
            Self::Motion => f.write_str(
                "the pose has no Motion, or the Motion was last advanced to another pose",
            ),
            Self::Argument(what) => f.write_str(what),
            Self::Memory { needed, found } => {
                write!(
                    f,
                    "the query needs {needed} bytes of memory, it has {found}"
                )
            }
            Self::Proxies => {
                f.write_str("the sink of proxies has no room: the answer would be incomplete")
            }
            Self::Corrupt(error) => write!(f, "damaged .bdt file: {error}"),
        }
    }
}

impl core::error::Error for QueryError {}

impl From<FormatError> for QueryError {
    fn from(error: FormatError) -> Self {
        Self::Corrupt(error)
    }
}
