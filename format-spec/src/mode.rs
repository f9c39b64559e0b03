//! The mode table: one record per mode, right behind the fixed header (SPEC 2.2).

use zerocopy::little_endian::{F32, F64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// What a reader needs to know of one mode, 32 bytes.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct ModeRecord {
    /// Hard limit of |q_j|, against overflow only: a power of two from 2⁻¹²⁶ to 2¹²⁶. The node's
    /// rows of the mode are those of a q that reaches it.
    pub q_limit: F32,
    /// Typical largest |q_j|, advisory; finite, positive, at most `q_limit`.
    pub q_range: F32,
    /// S_j: the scaling of the second δR row (bounds for steps δq measured as ‖S⁻¹ δq‖);
    /// finite, positive.
    pub step_scale: F32,
    /// W_j: an upper bound of the norms of all stored U_ij and lane Ū_j (stored units per
    /// unit of q).
    pub field_norm_max: F32,
    /// ω_j in rad/s, or −1 when unknown.
    pub omega_rad_s: F64,
    /// m_j in kg, or −1 when unknown.
    pub modal_mass_kg: F64,
}

const _: () = assert!(size_of::<ModeRecord>() == 32);
