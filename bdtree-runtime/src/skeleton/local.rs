//! Transforms of nodes to their parents, and mixtures of them.

use super::error::{SkeletonError, same_length};
use crate::joint::JointMatrix;
use crate::math::{rotation_matrix, sqrt};

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
                let turn = rotation_matrix(unit(rotation));
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

/// A quaternion of length 1; the identity for one without a direction.
pub(super) fn unit(q: [f64; 4]) -> [f64; 4] {
    let [x, y, z, w] = q;
    let length = sqrt(x * x + y * y + z * z + w * w);
    if length > 0.0 && length.is_finite() {
        // One division: the reciprocal of a length is finite, since squares underflow long before it is not.
        let per = 1.0 / length;
        [x * per, y * per, z * per, w * per]
    } else {
        [0.0, 0.0, 0.0, 1.0]
    }
}

/// Between two rotations along the shorter arc (glTF 2.0, appendix C.4), of length 1.
pub(super) fn slerp(a: [f64; 4], b: [f64; 4], share: f64) -> [f64; 4] {
    /// Quaternions nearer than this are on a straight line: its distance from the arc is below 2⁻⁵³.
    const STRAIGHT: f64 = 1.0 - 1.0 / (1_u64 << 45) as f64;
    let (a, b) = (unit(a), unit(b));
    let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    // b and −b are the same rotation.
    let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
    let apart = {
        let [x, y, z, w] = [
            a[0] - sign * b[0],
            a[1] - sign * b[1],
            a[2] - sign * b[2],
            a[3] - sign * b[3],
        ];
        x * x + y * y + z * z + w * w
    };
    let (from, to) = if apart < NEAR && (0.0..=1.0).contains(&share) {
        near_shares(apart, share)
    } else if cosine.abs() < STRAIGHT {
        let angle = libm::acos(cosine.abs());
        let sine = libm::sin(angle);
        (
            libm::sin(angle * (1.0 - share)) / sine,
            libm::sin(angle * share) / sine,
        )
    } else {
        (1.0 - share, share)
    };
    let to = sign * to;
    unit([
        from * a[0] + to * b[0],
        from * a[1] + to * b[1],
        from * a[2] + to * b[2],
        from * a[3] + to * b[3],
    ])
}

/// Square of the chord between two unit quaternions below which [`near_shares`] holds: a rotation by 28°.
const NEAR: f64 = 1.0 / 16.0;

/// sin((1 − t) θ) / sin θ and sin(t θ) / sin θ for t from 0 to 1 and the angle θ that belongs to a short chord: what keys
/// of clips are apart. A series in 1 − cos θ to the last bits of f64 takes a tenth of what the functions take (Eberly, "A
/// fast and accurate algorithm for computing SLERP", 2011).
fn near_shares(chord_square: f64, share: f64) -> (f64, f64) {
    let less = -0.5 * chord_square;
    let series = |t: f64| {
        let square = t * t;
        let (mut sum, mut term) = (1.0, 1.0);
        for (u, v) in NEAR_TERMS {
            term *= (u * square - v) * less;
            sum += term;
        }
        t * sum
    };
    (series(1.0 - share), series(share))
}

/// 1 / (i (2 i + 1)) and i / (2 i + 1) from i = 1 on: each term is below 1/64 of the one before, the first left out below
/// 2⁻⁵⁴.
const NEAR_TERMS: [(f64, f64); 9] = [
    (1.0 / 3.0, 1.0 / 3.0),
    (1.0 / 10.0, 2.0 / 5.0),
    (1.0 / 21.0, 3.0 / 7.0),
    (1.0 / 36.0, 4.0 / 9.0),
    (1.0 / 55.0, 5.0 / 11.0),
    (1.0 / 78.0, 6.0 / 13.0),
    (1.0 / 105.0, 7.0 / 15.0),
    (1.0 / 136.0, 8.0 / 17.0),
    (1.0 / 171.0, 9.0 / 19.0),
];
