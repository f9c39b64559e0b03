//! Skins: which bones move a vertex, what the lanes of a node have of them, and the skeleton with its clips (SPEC 5.9,
//! 6.10, 7.7 to 7.9).

use crate::LANES;
use zerocopy::little_endian::{F32, F64, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Most bones (and most joints) of a file.
pub const BONE_COUNT_MAX: usize = 4096;

/// Most nodes of a skeleton.
pub const SKELETON_NODES_MAX: usize = 16_384;

/// Most influences of a vertex.
pub const INFLUENCES_MAX: usize = 255;

/// Least weight that is not left out: 2⁻³².
pub const WEIGHT_MIN: f32 = 1.0 / (1_u64 << 32) as f32;

/// Largest weight, and the largest sum of a vertex's weights.
pub const WEIGHT_MAX: f32 = 2.0;

/// An entry in the bone list of a node: the bone of each lane.
pub type BoneEntry = [u16; LANES];

/// Rows of a node before the first entry's: S and ε.
pub const BONE_ROWS_FIXED: usize = 2;
/// Row of S, the largest sum of distances of a vertex's weights from the middles.
pub const BONE_ROW_SPREAD: usize = 0;
/// Row of ε, the largest distance of a vertex's sum of weights from 1.
pub const BONE_ROW_DEFECT: usize = 1;
/// Rows of each entry: β, the middle of the weights of each lane's bone, and g, how far they are from it.
pub const BONE_ROWS_PER_ENTRY: usize = 2;

/// Number of bone rows of a node with `entry_count` entries.
pub const fn bone_row_count(entry_count: usize) -> usize {
    BONE_ROWS_FIXED + BONE_ROWS_PER_ENTRY * entry_count
}

/// What holds for the whole skin, 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct SkinRecord {
    /// Largest number of influences of a vertex.
    pub influences_max: u32,
    /// Largest number of entries in a node's list.
    pub node_bones_max: u32,
    /// ε_max: at least every |Σ_b w_ib − 1|, at most 1.
    pub weight_defect: f32,
    /// μ: of every vertex, the weights of bones whose core box does not hold it sum to at most this; at most 1.
    pub minor_share: f32,
    /// Zero.
    pub reserved: [u32; 4],
}

const _: () = assert!(size_of::<SkinRecord>() == 32);

/// One bone's share in a vertex, 8 bytes.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct InfluenceRecord {
    /// w, at least [`WEIGHT_MIN`] and at most [`WEIGHT_MAX`].
    pub weight: f32,
    /// Index of the bone.
    pub bone: u16,
    /// Zero.
    pub reserved: u16,
}

const _: () = assert!(size_of::<InfluenceRecord>() == 8);

/// A bone: a joint and the map from the mesh to the joint's space, 200 bytes. Meshes that share a joint with different
/// inverse bind matrices have a bone each.
#[derive(
    Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned,
)]
#[repr(C)]
pub struct BoneRecord {
    /// Index of the joint.
    pub joint: U32,
    /// Zero.
    pub reserved: U32,
    /// Inverse bind matrix: three rows of four, from the mesh (mesh units) to the joint's space.
    pub inverse_bind: [[F64; 4]; 3],
    /// T_b of the rest pose: three rows of four, in stored units.
    pub rest: [[F32; 4]; 3],
    /// Least coordinates of the rest positions that the bone moves (stored units).
    pub low: [F32; 3],
    /// Largest coordinates of them.
    pub high: [F32; 3],
    /// Least coordinates of those rest positions in which the bone has a large share ([`SkinRecord::minor_share`]).
    pub core_low: [F32; 3],
    /// Largest coordinates of them.
    pub core_high: [F32; 3],
}

const _: () = assert!(size_of::<BoneRecord>() == 200);

/// No parent.
pub const NO_PARENT: u32 = u32::MAX;

/// A node of the skeleton, 64 bytes.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct SkeletonNode {
    /// Index of the parent, below the node's own; [`NO_PARENT`] for none.
    pub parent: u32,
    /// First byte of the name in the names of the skeleton.
    pub name_start: u32,
    /// Length of the name in bytes.
    pub name_bytes: u32,
    /// See [`local_kind`].
    pub kind: u32,
    /// The transform to the parent at rest: translation, rotation (a unit quaternion x, y, z, w), scale and two zeros;
    /// or three rows of four.
    pub local: [f32; 12],
}

const _: () = assert!(size_of::<SkeletonNode>() == 64);

/// Values of [`SkeletonNode::kind`].
pub mod local_kind {
    /// Translation, rotation and scale, which clips may animate.
    pub const PARTS: u32 = 0;
    /// An affine matrix, which nothing animates.
    pub const MATRIX: u32 = 1;
}

/// A clip, 24 bytes.
#[derive(
    Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned,
)]
#[repr(C)]
pub struct ClipRecord {
    /// Seconds from time 0 to the last key.
    pub duration_s: F64,
    /// First byte of the name in the names of the skeleton.
    pub name_start: U32,
    /// Length of the name in bytes.
    pub name_bytes: U32,
    /// The first of its channels.
    pub first_channel: U32,
    /// Number of its channels.
    pub channel_count: U32,
}

const _: () = assert!(size_of::<ClipRecord>() == 24);

/// What one channel of a clip animates, and its keys, 28 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct ChannelRecord {
    /// Index of the node of the skeleton, or of the first mode.
    pub target: u32,
    /// 1, or the number of modes, at least 1.
    pub target_count: u32,
    /// See [`channel_path`].
    pub path: u32,
    /// See [`interpolation`].
    pub interpolation: u32,
    /// Number of keys, at least 1.
    pub key_count: u32,
    /// Index among the numbers of the clips of the first key's time; the times are followed by the values.
    pub first_number: u32,
    /// Zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<ChannelRecord>() == 28);

impl ChannelRecord {
    /// Numbers of one value: 3 or 4, or one per mode; `None` for an unknown path.
    pub const fn components(&self) -> Option<usize> {
        match self.path {
            channel_path::TRANSLATION | channel_path::SCALE => Some(3),
            channel_path::ROTATION => Some(4),
            channel_path::MODES => Some(self.target_count as usize),
            _ => None,
        }
    }

    /// Values of one key: one, or three where it has tangents; `None` for an unknown interpolation.
    pub const fn values_per_key(&self) -> Option<usize> {
        match self.interpolation {
            interpolation::LINEAR | interpolation::STEP => Some(1),
            interpolation::CUBIC => Some(3),
            _ => None,
        }
    }
}

/// Values of [`ChannelRecord::path`].
pub mod channel_path {
    /// The translation of a node.
    pub const TRANSLATION: u32 = 0;
    /// The rotation of a node.
    pub const ROTATION: u32 = 1;
    /// The scale of a node.
    pub const SCALE: u32 = 2;
    /// q of modes.
    pub const MODES: u32 = 3;
}

/// Values of [`ChannelRecord::interpolation`].
pub mod interpolation {
    /// Between the two keys in proportion; rotations along the shorter arc.
    pub const LINEAR: u32 = 0;
    /// The key before.
    pub const STEP: u32 = 1;
    /// A cubic spline: each key has an in-tangent, a value and an out-tangent.
    pub const CUBIC: u32 = 2;
}
