//! Where a body stands: a rotation and a translation, as quaternion and as matrix.

use bdtree_runtime::Transform;
pub use bdtree_runtime::math::rotation_matrix as matrix;

/// A rigid placement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Unit quaternion (x, y, z, w).
    pub rotation: [f64; 4],
    /// Translation, each number an f32.
    pub translation: [f64; 3],
}

impl Place {
    /// Where world and body coordinates are the same.
    pub const IDENTITY: Self = Self {
        rotation: [0.0, 0.0, 0.0, 1.0],
        translation: [0.0; 3],
    };

    /// A rotation and a translation, which is rounded to f32.
    pub fn new(rotation: [f64; 4], translation: [f64; 3]) -> Self {
        Self {
            rotation,
            translation: translation.map(|x| f64::from(x as f32)),
        }
    }

    /// The product's form of it.
    pub fn transform(&self) -> Transform {
        Transform {
            rotation: self.rotation,
            translation: self.translation,
            scale: 1.0,
        }
    }

    /// Rows of three rotation numbers and one of the translation, in f32.
    pub fn rows(&self) -> [[f32; 4]; 3] {
        let turn = matrix(self.rotation);
        [0, 1, 2].map(|i| {
            let [a, b, c] = turn[i];
            [a, b, c, self.translation[i]].map(|x| x as f32)
        })
    }
}

/// The rotation that does `b` and then undoes `a`.
pub fn undo_after(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let [x, y, z, w] = [-a[0], -a[1], -a[2], a[3]];
    let [p, q, r, s] = b;
    [
        w * p + x * s + y * r - z * q,
        w * q - x * r + y * s + z * p,
        w * r + x * q - y * p + z * s,
        w * s - x * p - y * q - z * r,
    ]
}
