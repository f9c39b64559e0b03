//! Mass properties (SPEC 7.10).

use zerocopy::little_endian::{F64, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Where masses come from (SPEC 7.10).
pub mod mass_source {
    /// The solid inside a closed surface: exact integrals of the polyhedron.
    pub const SURFACE: u32 = 1;
    /// The filled cells of the lattice of an elastic bake.
    pub const LATTICE: u32 = 2;
    /// The elements of a volume mesh.
    pub const ELEMENTS: u32 = 3;
}

/// Relative error that checkers allow between numbers of a [`MassRecord`].
pub const MASS_TOLERANCE: f64 = 1e-9;

/// The mass of the body at rest, 128 bytes. Coordinates are the source's, in mesh units.
#[derive(
    Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned,
)]
#[repr(C)]
pub struct MassRecord {
    /// Mass in kg, positive.
    pub mass_kg: F64,
    /// Center of mass in mesh units, in the source's coordinates.
    pub center_of_mass: [F64; 3],
    /// The inertia tensor about the center of mass, xx yy zz xy xz yz, in kg · (mesh unit)²: the tensor's entries, so
    /// xx = ∫ (y² + z²) dm and xy = −∫ x y dm.
    pub inertia: [F64; 6],
    /// Mean density in kg/m³, positive: mass over volume.
    pub density_kg_m3: F64,
    /// Meters per mesh unit, positive.
    pub scale_m: F64,
    /// Volume in (mesh unit)³, positive.
    pub volume: F64,
    /// One of [`mass_source`].
    pub source: U32,
    /// Zero.
    pub reserved: [u8; 20],
}

const _: () = assert!(size_of::<MassRecord>() == 128);

/// The momentum of the body when it moves along one mode with q̇_j = 1 and is at rest otherwise, 48 bytes.
#[derive(
    Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned,
)]
#[repr(C)]
pub struct ModeMomentum {
    /// ∫ u_j dm, in kg · mesh unit per unit of q.
    pub linear: [F64; 3],
    /// ∫ (x − c) × u_j dm about the center of mass c at rest, in kg · (mesh unit)² per unit of q.
    pub angular: [F64; 3],
}

const _: () = assert!(size_of::<ModeMomentum>() == 48);
