//! Where an instance stands in the world.

use crate::error::PoseError;
use crate::math::{add, dot, rotation_matrix, scale, sqrt};

/// Where an instance stands: `x = rotation · (scale · x_mesh) + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Unit quaternion (x, y, z, w); the identity is (0, 0, 0, 1).
    pub rotation: [f64; 4],
    /// World units.
    pub translation: [f64; 3],
    /// World units per mesh unit.
    pub scale: f64,
}

impl Transform {
    /// World and mesh coordinates are the same.
    pub const IDENTITY: Self = Self {
        rotation: [0.0, 0.0, 0.0, 1.0],
        translation: [0.0; 3],
        scale: 1.0,
    };

    /// The placement that does what `first` does and then what `self` does: an instance of a frame
    /// that has its own rigid motion stands at `place.after(frame.transform())`.
    ///
    /// # Errors
    /// What [`Asset::pose`](crate::Asset::pose) refuses of a placement: of either one, or of both together.
    pub fn after(self, first: Self) -> Result<Self, PoseError> {
        let (outer, inner) = (self.checked()?, first.checked()?);
        let turned = rotation_matrix(outer.rotation).map(|row| dot(row, inner.translation));
        let ([x, y, z, w], [a, b, c, d]) = (outer.rotation, inner.rotation);
        Self {
            rotation: [
                w * a + x * d + y * c - z * b,
                w * b - x * c + y * d + z * a,
                w * c + x * b - y * a + z * d,
                w * d - x * a - y * b - z * c,
            ],
            translation: add(outer.translation, scale(turned, outer.scale)),
            scale: outer.scale * inner.scale,
        }
        .checked()
    }

    /// The transform with its quaternion normalised in f64.
    ///
    /// # Errors
    /// A quaternion whose norm is off by more than 1e-3, a translation that is not finite or
    /// beyond 2^80, a scale outside 2^-60 … 2^60.
    pub(crate) fn checked(self) -> Result<Self, PoseError> {
        const TRANSLATION_MAX: f64 = (1_u128 << 80) as f64;
        const SCALE_MAX: f64 = (1_u64 << 60) as f64;
        let [x, y, z, w] = self.rotation;
        let norm = sqrt(x * x + y * y + z * z + w * w);
        if !((norm - 1.0).abs() <= 1e-3) {
            return Err(PoseError::Rotation);
        }
        if !self.translation.iter().all(|t| t.abs() <= TRANSLATION_MAX) {
            return Err(PoseError::Translation);
        }
        if !(1.0 / SCALE_MAX..=SCALE_MAX).contains(&self.scale) {
            return Err(PoseError::Scale);
        }
        Ok(Self {
            rotation: self.rotation.map(|c| c / norm),
            ..self
        })
    }
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}
