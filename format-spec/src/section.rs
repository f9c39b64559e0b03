//! The section table (SPEC 4).

use crate::{LAYOUT_1, LAYOUT_2, LAYOUT_3};
use zerocopy::little_endian::{U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A section's kind: four ASCII letters.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned,
)]
#[repr(C)]
pub struct SectionKind(pub [u8; 4]);

impl SectionKind {
    /// [`crate::NodeRecord`] per node, breadth first.
    pub const NODES: Self = Self(*b"NODE");
    /// [`crate::Row`]s of all nodes, in node order.
    pub const ROWS: Self = Self(*b"ROWS");
    /// `u16` mode indices: the mode lists that nodes and vertices share.
    pub const MODE_LISTS: Self = Self(*b"LIST");
    /// [`crate::TriangleRecord`] per triangle, in leaf order.
    pub const TRIANGLES: Self = Self(*b"TRIS");
    /// `u32` per triangle id: its place in [`Self::TRIANGLES`].
    pub const TRIANGLE_SLOTS: Self = Self(*b"SLOT");
    /// `[f32; 3]` per vertex: rest positions relative to the origin, stored units.
    pub const POSITIONS: Self = Self(*b"VERT");
    /// `[f32; 3]` per vertex and mode, vertex-major: U_ij, stored units per unit of q. In layout 2
    /// only of the modes that [`Self::VERTEX_MODES`] lists.
    pub const DISPLACEMENTS: Self = Self(*b"DISP");
    /// [`crate::VertexModes`] per vertex, and one that ends the last: which modes displacements of
    /// layout 2 are of. Absent in layout 1.
    pub const VERTEX_MODES: Self = Self(*b"VMOD");
    /// One [`crate::SkinRecord`]. Of skins, like the nine that follow.
    pub const SKIN: Self = Self(*b"SKIN");
    /// `u32` per vertex, and one that ends the last: its first entry in [`Self::INFLUENCES`].
    pub const INFLUENCE_STARTS: Self = Self(*b"INFS");
    /// [`crate::InfluenceRecord`]s of all vertices, in vertex order.
    pub const INFLUENCES: Self = Self(*b"INFL");
    /// [`crate::BoneRecord`] per bone.
    pub const BONES: Self = Self(*b"BONE");
    /// `f32` per bone and mode, bone-major: the largest norm of the displacements that the bone moves.
    pub const BONE_FIELDS: Self = Self(*b"BFLD");
    /// `u32` per node, and one that ends the last: its first entry in [`Self::BONE_LISTS`].
    pub const BONE_LIST_STARTS: Self = Self(*b"BLSS");
    /// [`crate::BoneEntry`]s of all nodes, in node order: the bones of the vertices below each lane.
    pub const BONE_LISTS: Self = Self(*b"BLST");
    /// [`crate::Row`]s of all nodes, in node order: what the lanes have of the node's bones.
    pub const BONE_ROWS: Self = Self(*b"BROW");
    /// [`crate::SkeletonNode`] per node of the skeleton, parents before children.
    pub const SKELETON: Self = Self(*b"SKEL");
    /// `u32` per joint: its node in [`Self::SKELETON`].
    pub const JOINTS: Self = Self(*b"JNTS");
    /// UTF-8 text that records of the skeleton and of clips point into.
    pub const SKELETON_NAMES: Self = Self(*b"SNAM");
    /// [`crate::ClipRecord`] per clip. Optional.
    pub const CLIPS: Self = Self(*b"CLIP");
    /// [`crate::ChannelRecord`] per channel of all clips. Optional.
    pub const CHANNELS: Self = Self(*b"CHAN");
    /// `f32` times and values of the channels' keys. Optional.
    pub const KEYS: Self = Self(*b"KEYS");
    /// One [`crate::MassRecord`]. Optional.
    pub const MASS_PROPERTIES: Self = Self(*b"MASS");
    /// [`crate::ModeMomentum`] per mode. Optional, and only beside [`Self::MASS_PROPERTIES`].
    pub const MODE_MOMENTA: Self = Self(*b"MMOM");
    /// [`crate::FrameRecord`] per frame of the animation. Optional.
    pub const FRAMES: Self = Self(*b"FRMS");
    /// `f32` per frame and mode, frame-major: q of the frames. Optional.
    pub const FRAME_Q: Self = Self(*b"FRMQ");
    /// [`crate::GroupRecord`] per source group. Optional.
    pub const GROUPS: Self = Self(*b"GRPS");
    /// UTF-8 text that group records point into. Optional.
    pub const GROUP_NAMES: Self = Self(*b"GNAM");
    /// Metadata in bincode's fixed-width wire format. Optional.
    pub const METADATA: Self = Self(*b"META");

    /// The kind as text, with `.` for letters that are not printable.
    pub fn as_text(&self) -> [char; 4] {
        self.0.map(|b| {
            if b.is_ascii_graphic() {
                char::from(b)
            } else {
                '.'
            }
        })
    }
}

impl core::fmt::Display for SectionKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.as_text()
            .iter()
            .try_for_each(|c| core::fmt::Write::write_char(f, *c))
    }
}

/// The order of sections in a file; the first seven are always there (SPEC 4).
pub const SECTION_ORDER: [SectionKind; 29] = [
    SectionKind::NODES,
    SectionKind::ROWS,
    SectionKind::MODE_LISTS,
    SectionKind::TRIANGLES,
    SectionKind::TRIANGLE_SLOTS,
    SectionKind::POSITIONS,
    SectionKind::DISPLACEMENTS,
    SectionKind::VERTEX_MODES,
    SectionKind::SKIN,
    SectionKind::INFLUENCE_STARTS,
    SectionKind::INFLUENCES,
    SectionKind::BONES,
    SectionKind::BONE_FIELDS,
    SectionKind::BONE_LIST_STARTS,
    SectionKind::BONE_LISTS,
    SectionKind::BONE_ROWS,
    SectionKind::SKELETON,
    SectionKind::JOINTS,
    SectionKind::SKELETON_NAMES,
    SectionKind::CLIPS,
    SectionKind::CHANNELS,
    SectionKind::KEYS,
    SectionKind::MASS_PROPERTIES,
    SectionKind::MODE_MOMENTA,
    SectionKind::FRAMES,
    SectionKind::FRAME_Q,
    SectionKind::GROUPS,
    SectionKind::GROUP_NAMES,
    SectionKind::METADATA,
];

/// The sections that every file has are so many of the first ones of [`SECTION_ORDER`].
pub const SECTIONS_ALWAYS: usize = 7;

/// The sections that every file with a skin has, and no other: places in [`SECTION_ORDER`].
pub const SECTIONS_OF_SKINS: core::ops::Range<usize> = 8..19;

/// The sections that every file with clips has, and no other: places in [`SECTION_ORDER`].
pub const SECTIONS_OF_CLIPS: core::ops::Range<usize> = 19..22;

/// Whether readers that do not know the kind at this place of [`SECTION_ORDER`] must refuse the file.
pub const fn is_required(place: usize) -> bool {
    place < SECTIONS_OF_SKINS.end
}

/// The layouts of the sections in [`SECTION_ORDER`].
pub const SECTION_LAYOUTS: [&[u32]; SECTION_ORDER.len()] = [
    &[LAYOUT_2],
    &[LAYOUT_3],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1, LAYOUT_2],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_2],
    &[LAYOUT_2],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_1],
    &[LAYOUT_2],
];

/// One entry of the section table, 32 bytes.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct SectionRecord {
    /// What the section holds.
    pub kind: SectionKind,
    /// How it holds it: one of [`SECTION_LAYOUTS`].
    pub layout: U32,
    /// First byte, from the start of the file; a multiple of 64.
    pub offset: U64,
    /// Length in bytes, without padding.
    pub length: U64,
    /// CRC-32/ISO-HDLC of the section's bytes, without padding.
    pub crc: U32,
    /// 1: a reader that does not know the kind must refuse the file. 0: it skips it.
    pub required: U32,
}

const _: () = assert!(size_of::<SectionRecord>() == 32);
