//! Transforms of nodes to their parents, and mixtures of them.

use super::error::{SkeletonError, same_length};
use super::rotation::{rows, slerp};
use crate::joint::JointMatrix;

/// From a node's space to its parent's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LocalTransform {
    /// A point x goes to translation + R (scale x): what clips animate.
    Parts {
        /// In units of the parent's space.
        translation: [f64; 3],
        /// Quaternion (x, y, z, w), normalised where it is used; the identity is (0, 0, 0, 1).
        rotation: [f64; 4],
        /// Of each axis; negative numbers mirror.
        scale: [f64; 3],
    },
    /// Any affine map, which nothing animates.
    Matrix(JointMatrix),
}

impl LocalTransform {
    /// The node's space is its parent's.
    pub const IDENTITY: Self = Self::Parts {
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };

    /// The transform as a matrix.
    pub fn to_matrix(&self) -> JointMatrix {
        match *self {
            Self::Matrix(rows) => rows,
            Self::Parts {
                translation,
                rotation,
                scale,
            } => {
                let turn = rows(rotation);
                let row = |r: usize| {
                    let [x, y, z] = turn[r];
                    [x * scale[0], y * scale[1], z * scale[2], translation[r]]
                };
                [row(0), row(1), row(2)]
            }
        }
    }

    /// Between this transform, at a weight of 0, and another, at 1: translation, scale and the numbers of matrices
    /// linearly, rotations along the shorter arc. Of a matrix and parts, the nearer one.
    pub fn blended(&self, other: &Self, weight: f64) -> Self {
        match (*self, *other) {
            (
                Self::Parts {
                    translation,
                    rotation,
                    scale,
                },
                Self::Parts {
                    translation: t,
                    rotation: r,
                    scale: s,
                },
            ) => Self::Parts {
                translation: mixed(translation, t, weight),
                rotation: slerp(rotation, r, weight),
                scale: mixed(scale, s, weight),
            },
            (Self::Matrix(a), Self::Matrix(b)) => {
                Self::Matrix([0, 1, 2].map(|r| mixed(a[r], b[r], weight)))
            }
            _ if weight < 0.5 => *self,
            _ => *other,
        }
    }
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// Mixes a pose into another: each transform of `locals` goes towards that of `other` by `weight`, which leaves it at 0
/// and replaces it at 1, up to rounding; see [`LocalTransform::blended`]. For layers that move a part of the body only, blend that
/// part of the slices.
///
/// # Errors
/// Slices of different lengths, a weight that is not finite.
pub fn blend(
    locals: &mut [LocalTransform],
    other: &[LocalTransform],
    weight: f64,
) -> Result<(), SkeletonError> {
    same_length("local transforms", locals.len(), other.len())?;
    check_weight(weight)?;
    for (local, other) in locals.iter_mut().zip(other) {
        *local = local.blended(other, weight);
    }
    Ok(())
}

/// The same for q of modes, linearly.
///
/// # Errors
/// Those of [`blend`].
pub fn blend_q(q: &mut [f32], other: &[f32], weight: f64) -> Result<(), SkeletonError> {
    same_length("entries of q", q.len(), other.len())?;
    check_weight(weight)?;
    for (q, other) in q.iter_mut().zip(other) {
        *q = mix(f64::from(*q), f64::from(*other), weight) as f32;
    }
    Ok(())
}

fn check_weight(weight: f64) -> Result<(), SkeletonError> {
    if weight.is_finite() {
        return Ok(());
    }
    Err(SkeletonError::Weight)
}

/// Between two numbers; exact where they are equal.
pub(super) fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

fn mixed<const N: usize>(a: [f64; N], b: [f64; N], share: f64) -> [f64; N] {
    core::array::from_fn(|k| mix(a[k], b[k], share))
}
