//! From the world to what is drawn.

use bdtree_runtime::Transform;

/// The world less a point near the object, in units of the object's size: f32 has the digits for it
/// wherever it stands and however large it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its middle (world).
    pub middle: [f64; 3],
    /// World units per drawn unit: half the diagonal of the object's box.
    pub size: f64,
}

impl Place {
    /// About some points (world).
    pub fn around(points: impl IntoIterator<Item = [f64; 3]>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let middle = [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]);
        let half = (0..3).map(|k| (0.5 * high[k] - 0.5 * low[k]).powi(2));
        let size = half.sum::<f64>().sqrt();
        let is_placed = middle.iter().all(|x| x.is_finite());
        let has_size = size > 0.0 && size.is_finite();
        Self {
            middle: if is_placed { middle } else { [0.0; 3] },
            // A single point has no size: any will do.
            size: if has_size { size } else { 1.0 },
        }
    }

    /// A point as it is drawn.
    pub fn shown(&self, x: [f64; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| ((x[k] - self.middle[k]) / self.size) as f32)
    }

    /// A length as it is drawn.
    pub fn shown_length(&self, length: f64) -> f32 {
        (length / self.size) as f32
    }

    /// A placement as it is drawn.
    pub fn shown_transform(&self, transform: Transform) -> Transform {
        Transform {
            translation: [0, 1, 2].map(|k| (transform.translation[k] - self.middle[k]) / self.size),
            scale: transform.scale / self.size,
            ..transform
        }
    }
}
