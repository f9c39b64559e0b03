//! Which modes move a vertex (SPEC 7.6).

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Where a vertex's displacements and its mode list begin, 8 bytes. The next record's
/// `first_entry` ends its displacements, so it has as many modes as lie between the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct VertexModes {
    /// Index of the vertex's first entry in the displacement section.
    pub first_entry: u32,
    /// Index of the vertex's first mode index in the mode-list section.
    pub mode_list_start: u32,
}

const _: () = assert!(size_of::<VertexModes>() == 8);
