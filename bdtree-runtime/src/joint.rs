//! Affine maps as programs have them of joints.

/// Three rows of four of an affine map, in f64: `x ↦ [a b c; …] x + t`, t in the fourth column.
pub type JointMatrix = [[f64; 4]; 3];
