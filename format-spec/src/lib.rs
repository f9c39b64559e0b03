//! Record layouts of the `.bdt` file: the one source of truth in code for `SPEC.md`.
//!
//! No logic lives here: only magic numbers, section kinds and plain records. A test of the
//! workspace compares every offset below with the tables of `SPEC.md`.
//!
//! All multi-byte values are little-endian. Header, mode and section records use unaligned
//! little-endian types; the big arrays (nodes, rows, triangles, vertices) are native `u32`,
//! `u16` and `f32` viewed in place, so nothing here compiles for big-endian targets.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "metadata")]
extern crate std;

#[cfg(target_endian = "big")]
compile_error!(
    "a .bdt file's arrays are viewed as they lie, little-endian: big-endian targets are not supported"
);

mod frame;
mod header;
mod mass;
#[cfg(feature = "metadata")]
mod metadata;
mod mode;
mod node;
mod section;
mod skin;
mod triangle;
mod vertex;

pub use frame::{FrameRecord, ROTATION_TOLERANCE, TIME_UNKNOWN, TRANSLATION_MAX};
pub use header::{Header, MAGIC, VERSION_MAJOR, VERSION_MINOR};
pub use mass::{MASS_TOLERANCE, MassRecord, ModeMomentum, mass_source};
#[cfg(feature = "metadata")]
pub use metadata::{ErrorMetadata, Metadata, MetadataError, ModeMetadata};
pub use mode::ModeRecord;
pub use node::{
    LANES, ModePair, NodeRecord, PairRow, ROW_CENTER_X, ROW_CENTER_Y, ROW_CENTER_Z, ROW_RADIUS,
    ROWS_FIXED, ROWS_LEADING, ROWS_PER_PAIR, Row, pair_count, pair_row, row_count,
};
pub use section::{
    SECTION_LAYOUTS, SECTION_ORDER, SECTIONS_ALWAYS, SECTIONS_OF_CLIPS, SECTIONS_OF_SKINS,
    SectionKind, SectionRecord, is_required,
};
pub use skin::{
    BONE_COUNT_MAX, BONE_ROW_DEFECT, BONE_ROW_SPREAD, BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY,
    BoneEntry, BoneRecord, ChannelRecord, ClipRecord, INFLUENCES_MAX, InfluenceRecord, NO_PARENT,
    SKELETON_NODES_MAX, SkeletonNode, SkinRecord, WEIGHT_MAX, WEIGHT_MIN, bone_row_count,
    channel_path, interpolation, local_kind,
};
pub use triangle::{GroupRecord, TriangleRecord, group_kind};
pub use vertex::VertexModes;

/// Sections start at multiples of this many bytes (SPEC 3).
pub const SECTION_ALIGNMENT: usize = 64;

/// Alignment that the first byte of a file needs in memory (SPEC 3).
pub const BASE_ALIGNMENT: usize = 4;

/// Largest magnitude of the length unit's exponent (SPEC 5.2): beyond it predicates would leave the range in which
/// they are exact.
pub const UNIT_EXPONENT_MAX: i32 = 100;

/// Most modes that the rounding constants are proved for (SPEC 5).
pub const MODE_COUNT_MAX: usize = 512;

/// Most node levels, so that a reader's stacks are bounded (SPEC 6).
pub const DEPTH_MAX: usize = 32;

/// Most triangles in one leaf lane (SPEC 6).
pub const LEAF_TRIANGLES_MAX: usize = 255;

/// Layout id of most sections (SPEC 4).
pub const LAYOUT_1: u32 = 1;

/// Layout id of the nodes (with exponents of the units of their rows), of displacements of each
/// vertex's mode list, and of the metadata (errors with their place) (SPEC 4).
pub const LAYOUT_2: u32 = 2;

/// Layout id of the rows (modes in pairs, in 16 bits) (SPEC 4).
pub const LAYOUT_3: u32 = 3;
