//! Arguments: points, vectors and quaternions, from arrays or another library's types.
//!
//! Queries answer with plain arrays of `f64`. They take [`Vec3`] and [`Quat`].

/// Three coordinates of a point or a vector, in world units unless a function says otherwise.
///
/// Functions take `impl Into<Vec3>`: `[f32; 3]` and `[f64; 3]`, and with the feature `mint` also `mint::Vector3` and
/// `mint::Point3` of `f32` or `f64`, in both directions. Types of glam, nalgebra, cgmath or ultraviolet go through mint:
/// `mint::Vector3::from(v)`. Queries answer with `[f64; 3]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vec3(pub [f64; 3]);

/// A quaternion (x, y, z, w); the identity is (0, 0, 0, 1).
///
/// Functions take `impl Into<Quat>`: `[f32; 4]` and `[f64; 4]` in this order, and with the feature `mint` also
/// `mint::Quaternion` of `f32` or `f64`, in both directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quat(pub [f64; 4]);

impl From<[f64; 3]> for Vec3 {
    fn from(v: [f64; 3]) -> Self {
        Self(v)
    }
}

impl From<[f32; 3]> for Vec3 {
    fn from(v: [f32; 3]) -> Self {
        Self(v.map(f64::from))
    }
}

impl From<Vec3> for [f64; 3] {
    fn from(v: Vec3) -> Self {
        v.0
    }
}

impl From<[f64; 4]> for Quat {
    fn from(q: [f64; 4]) -> Self {
        Self(q)
    }
}

impl From<[f32; 4]> for Quat {
    fn from(q: [f32; 4]) -> Self {
        Self(q.map(f64::from))
    }
}

impl From<Quat> for [f64; 4] {
    fn from(q: Quat) -> Self {
        q.0
    }
}

/// mint's types, of both precisions, in both directions. Rounding to `f32` is to nearest.
#[cfg(feature = "mint")]
mod interop {
    use super::{Quat, Vec3};
    use crate::error::PoseError;
    use crate::transform::Transform;

    macro_rules! vectors {
        ($($kind:ident<$number:ty>),*) => {$(
            impl From<mint::$kind<$number>> for Vec3 {
                fn from(v: mint::$kind<$number>) -> Self {
                    Self([v.x, v.y, v.z].map(f64::from))
                }
            }

            impl From<Vec3> for mint::$kind<$number> {
                fn from(v: Vec3) -> Self {
                    let [x, y, z] = v.0.map(|x| x as $number);
                    Self { x, y, z }
                }
            }
        )*};
    }
    vectors!(Vector3<f32>, Vector3<f64>, Point3<f32>, Point3<f64>);

    macro_rules! rotations_and_matrices {
        ($($number:ty),*) => {$(
            impl From<mint::Quaternion<$number>> for Quat {
                fn from(q: mint::Quaternion<$number>) -> Self {
                    Self([q.v.x, q.v.y, q.v.z, q.s].map(f64::from))
                }
            }

            impl From<Quat> for mint::Quaternion<$number> {
                fn from(q: Quat) -> Self {
                    let [x, y, z, s] = q.0.map(|x| x as $number);
                    Self { v: mint::Vector3 { x, y, z }, s }
                }
            }

            impl From<Transform> for mint::ColumnMatrix4<$number> {
                fn from(transform: Transform) -> Self {
                    transform.to_columns().map(|column| column.map(|x| x as $number)).into()
                }
            }

            /// Rotation, one positive scale and translation; see [`Transform::from_columns`].
            impl TryFrom<mint::ColumnMatrix4<$number>> for Transform {
                type Error = PoseError;

                fn try_from(matrix: mint::ColumnMatrix4<$number>) -> Result<Self, PoseError> {
                    let columns: [[$number; 4]; 4] = matrix.into();
                    Self::from_columns(columns.map(|column| column.map(f64::from)))
                }
            }
        )*};
    }
    rotations_and_matrices!(f32, f64);
}
