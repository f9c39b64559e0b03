//! Placements as matrices of four columns, the way that engines keep them.

use crate::error::PoseError;
use crate::math::{cross, dot, norm, sqrt};
use crate::transform::Transform;
use crate::vector::{Quat, Vec3};

/// How far columns may be from orthogonal and of one length, over that length: as far as quaternions may be
/// from unit length.
const SKEW_MAX: f64 = 1e-3;

impl Transform {
    /// A rotation, then a translation, at scale 1.
    pub fn new(translation: impl Into<Vec3>, rotation: impl Into<Quat>) -> Self {
        let (Vec3(translation), Quat(rotation)) = (translation.into(), rotation.into());
        Self {
            rotation,
            translation,
            scale: 1.0,
        }
    }

    /// A translation alone.
    pub fn from_translation(translation: impl Into<Vec3>) -> Self {
        let Vec3(translation) = translation.into();
        Self {
            translation,
            ..Self::IDENTITY
        }
    }

    /// The same placement with another scale (world units per mesh unit).
    pub fn with_scale(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// The placement as a matrix of four columns; the quaternion is taken as it is.
    pub fn to_columns(&self) -> [[f64; 4]; 4] {
        let rows = crate::math::rotation_matrix(self.rotation);
        let axis = |k: usize| {
            let [x, y, z] = [rows[0][k], rows[1][k], rows[2][k]];
            [x * self.scale, y * self.scale, z * self.scale, 0.0]
        };
        let [x, y, z] = self.translation;
        [axis(0), axis(1), axis(2), [x, y, z, 1.0]]
    }

    /// The placement of a matrix of four columns that rotates, scales by one positive number and
    /// translates.
    ///
    /// # Errors
    /// [`PoseError::Projection`] for one that projects: whose last row is other than 0, 0, 0, 1, as where rows and columns
    /// are exchanged. [`PoseError::Matrix`] for one that mirrors, shears, scales axes differently by more than a
    /// thousandth, or is not finite.
    pub fn from_columns(columns: [[f64; 4]; 4]) -> Result<Self, PoseError> {
        let last = columns.map(|column| column[3]);
        if last != [0.0, 0.0, 0.0, 1.0] {
            return Err(PoseError::Projection);
        }
        let [a, b, c, translation] = columns.map(|[x, y, z, _]| [x, y, z]);
        // The cube root of the volume would mix in the shear that is about to be measured.
        let scale = (norm(a) + norm(b) + norm(c)) / 3.0;
        let [a, b, c] = [a, b, c].map(|v| v.map(|x| x / scale));
        let is_unit = |v| (norm(v) - 1.0).abs() <= SKEW_MAX;
        let is_across = |v, w| dot(v, w).abs() <= SKEW_MAX;
        let is_rotation = is_unit(a) && is_unit(b) && is_unit(c);
        let is_rotation = is_rotation && is_across(a, b) && is_across(b, c) && is_across(c, a);
        let is_finite = translation.iter().all(|x| x.is_finite());
        if !is_rotation || !is_finite || !(dot(cross(a, b), c) > 0.0) {
            return Err(PoseError::Matrix);
        }
        Ok(Self {
            rotation: quaternion([a, b, c]),
            translation,
            scale,
        })
    }
}

/// The unit quaternion of a rotation, by the largest of its four components (S. W. Shepperd, 1978), which
/// never divides by a small number.
fn quaternion([a, b, c]: [[f64; 3]; 3]) -> [f64; 4] {
    // Four times the square of each component, of a matrix that is exactly a rotation.
    let squares = [
        1.0 + a[0] - b[1] - c[2],
        1.0 - a[0] + b[1] - c[2],
        1.0 - a[0] - b[1] + c[2],
        1.0 + a[0] + b[1] + c[2],
    ];
    let largest = (1..4).fold(0, |k, i| if squares[i] > squares[k] { i } else { k });
    let (xy, yz, zx) = (a[1] + b[0], b[2] + c[1], c[0] + a[2]);
    let (wx, wy, wz) = (b[2] - c[1], c[0] - a[2], a[1] - b[0]);
    let q = match largest {
        0 => [squares[0], xy, zx, wx],
        1 => [xy, squares[1], yz, wy],
        2 => [zx, yz, squares[2], wz],
        _ => [wx, wy, wz, squares[3]],
    };
    let length = sqrt(q.iter().map(|x| x * x).sum());
    q.map(|x| x / length)
}
