//! The frames of an animation (SPEC 7.5).

use zerocopy::little_endian::F64;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The time of frames whose source does not say.
pub const TIME_UNKNOWN: f64 = -1.0;

/// Squared lengths of quaternions may differ from 1 by this: 2⁻²⁰.
pub const ROTATION_TOLERANCE: f64 = 1.0 / (1_u64 << 20) as f64;

/// Largest component of a translation: 2⁸⁰.
pub const TRANSLATION_MAX: f64 = (1_u128 << 80) as f64;

/// When a frame is shown, and the rigid motion that playback puts back, 64 bytes. Its q stand in
/// [`crate::SectionKind::FRAME_Q`].
#[derive(
    Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned,
)]
#[repr(C)]
pub struct FrameRecord {
    /// Seconds, not negative and not descending, or −1 in every frame: unknown.
    pub time_s: F64,
    /// R as a unit quaternion x, y, z, w: its squared length is within 2⁻²⁰ of 1.
    pub rotation: [F64; 4],
    /// t in mesh units, each component finite and at most 2⁸⁰.
    pub translation: [F64; 3],
}

const _: () = assert!(size_of::<FrameRecord>() == 64);
