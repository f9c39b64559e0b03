//! Triangles in leaf order and the source's groups (SPEC 7).

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// A triangle, 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct TriangleRecord {
    /// Vertex indices of the corners, in the source's order.
    pub corners: [u32; 3],
    /// Triangle id: its number in the source.
    pub id: u32,
}

const _: () = assert!(size_of::<TriangleRecord>() == 16);

/// A run of triangle ids that the source put under one name, 20 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct GroupRecord {
    /// First triangle id.
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// See [`group_kind`].
    pub kind: u32,
    /// First byte of the name in the group-name section.
    pub name_start: u32,
    /// Length of the name in bytes.
    pub name_bytes: u32,
}

const _: () = assert!(size_of::<GroupRecord>() == 20);

/// Values of [`GroupRecord::kind`].
pub mod group_kind {
    /// OBJ `o`.
    pub const OBJECT: u32 = 0;
    /// OBJ `g`.
    pub const GROUP: u32 = 1;
    /// OBJ `usemtl`.
    pub const MATERIAL: u32 = 2;
}
