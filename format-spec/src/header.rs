//! The fixed header at byte 0 (SPEC 2).

use zerocopy::little_endian::{F32, F64, I32, U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The first eight bytes. Like PNG's, they reveal transfers that strip the high bit, translate
/// line ends or stop at a DOS end-of-file.
pub const MAGIC: [u8; 8] = *b"\x89BDT\r\n\x1a\n";

/// Readers refuse files of another major version.
pub const VERSION_MAJOR: u16 = 0;

/// Raised when sections or layouts are added.
pub const VERSION_MINOR: u16 = 5;

/// The fixed header, 128 bytes. The mode table and the section table follow it without a gap;
/// together they are the *header block*, whose length is [`Header::header_bytes`] and whose
/// checksum is [`Header::header_crc`].
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`VERSION_MAJOR`].
    pub version_major: U16,
    /// [`VERSION_MINOR`] of the writer.
    pub version_minor: U16,
    /// Length of the header block: a multiple of 64, zero-padded.
    pub header_bytes: U32,
    /// Length of the whole file.
    pub file_bytes: U64,
    /// CRC-32/ISO-HDLC of the header block, computed with this field as zero.
    pub header_crc: U32,
    /// Feature bits that a reader must know; none is defined yet.
    pub features_required: U32,
    /// Feature bits that a reader may ignore; none is defined yet.
    pub features_optional: U32,
    /// Exponent e of the length unit: stored lengths times 2^e are mesh units.
    pub unit_exponent: I32,
    /// Origin in mesh units; stored positions are relative to it.
    pub origin: [F64; 3],
    /// Number of vertices N.
    pub vertex_count: U32,
    /// Number of triangles F.
    pub triangle_count: U32,
    /// Number of modes M.
    pub mode_count: U32,
    /// Number of eight-wide nodes.
    pub node_count: U32,
    /// Number of node levels; the root is level 0.
    pub depth: U32,
    /// Number of section records.
    pub section_count: U32,
    /// P: an upper bound of the norms of all stored rest positions and lane centers
    /// (stored units).
    pub position_norm_max: F32,
    /// Most triangles in one leaf lane.
    pub leaf_triangles_max: U32,
    /// Zero.
    pub reserved: [u8; 32],
}

const _: () = assert!(size_of::<Header>() == 128);
