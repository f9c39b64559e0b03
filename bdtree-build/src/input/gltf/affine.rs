//! Placements of nodes: x ↦ L x + t in f64.

use bdtree_runtime::math::rotation_matrix;

use super::document::ExactNode;

/// Rotations whose length is off by more are said so.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A matrix whose last row is off by more is none of a node.
const LAST_ROW_TOLERANCE: f64 = 1e-5;

/// An affine map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affine {
    /// Rows of L.
    linear: [[f64; 3]; 3],
    /// t.
    translation: [f64; 3],
}

impl Affine {
    pub(super) const IDENTITY: Self = Self {
        linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// L x + t.
    pub(super) fn point(&self, x: [f64; 3]) -> [f64; 3] {
        let moved = self.vector(x);
        std::array::from_fn(|k| moved[k] + self.translation[k])
    }

    /// L x.
    pub(super) fn vector(&self, x: [f64; 3]) -> [f64; 3] {
        self.linear
            .map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Self) -> Self {
        let column = |k: usize| self.vector(inner.linear.map(|row| row[k]));
        let columns = [column(0), column(1), column(2)];
        Self {
            linear: std::array::from_fn(|i| columns.map(|column| column[i])),
            translation: self.point(inner.translation),
        }
    }

    /// The map from a node's coordinates to its parent's: the matrix, else scale, then rotation,
    /// then translation. The second value says what is odd about it.
    pub(super) fn of_node(node: &ExactNode) -> Result<(Self, Option<String>), String> {
        if let Some(m) = node.matrix {
            let last = [m[3], m[7], m[11], m[15] - 1.0];
            if !last.iter().all(|x| x.abs() <= LAST_ROW_TOLERANCE) {
                return Err("matrix: its last row is not 0, 0, 0, 1".into());
            }
            let affine = Self {
                linear: std::array::from_fn(|i| [m[i], m[4 + i], m[8 + i]]),
                translation: [m[12], m[13], m[14]],
            };
            let parts =
                node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
            let odd = if parts {
                Some("matrix is used; translation, rotation and scale beside it are not")
            } else if last != [0.0; 4] {
                Some("matrix: its last row is taken as 0, 0, 0, 1, which it nearly is")
            } else {
                None
            };
            return Ok((affine, odd.map(str::to_string)));
        }
        let mut odd = None;
        let mut linear = Self::IDENTITY.linear;
        if let Some(q) = node.rotation {
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(length > 0.0 && length.is_finite()) {
                return Err(format!("rotation {q:?} has no direction"));
            }
            if (length - 1.0).abs() > UNIT_TOLERANCE {
                odd = Some(format!("rotation of length {length} brought to length 1"));
            }
            linear = rotation_matrix(q.map(|x| x / length));
        }
        if let Some(scale) = node.scale {
            linear = linear.map(|row| std::array::from_fn(|k| row[k] * scale[k]));
        }
        let translation = node.translation.unwrap_or_default();
        let affine = Self {
            linear,
            translation,
        };
        Ok((affine, odd))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_scales_then_turns_then_moves() {
        let half = 0.5_f64.sqrt();
        let node = ExactNode {
            translation: Some([10.0, 0.0, 0.0]),
            // A quarter turn about z: x to y.
            rotation: Some([0.0, 0.0, half, half]),
            scale: Some([2.0, 1.0, -1.0]),
            ..ExactNode::default()
        };
        let (affine, odd) = Affine::of_node(&node).expect("sound");
        assert_eq!(odd, None);
        let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-15 * 16.0);
        assert!(near(affine.point([1.0, 0.0, 3.0]), [10.0, 2.0, -3.0]));
        assert!(near(affine.vector([1.0, 0.0, 3.0]), [0.0, 2.0, -3.0]));
        // Twice: L (L x + t) + t.
        let twice = affine.after(&affine);
        let x = [0.3, -0.2, 0.7];
        assert!(near(twice.point(x), affine.point(affine.point(x))));
    }

    #[test]
    fn a_matrix_stands_column_by_column() {
        let mut m = [0.0; 16];
        for (at, value) in [(1, 1.0), (4, -1.0), (10, 1.0), (12, 5.0), (15, 1.0)] {
            m[at] = value;
        }
        let node = ExactNode {
            matrix: Some(m),
            ..ExactNode::default()
        };
        let (affine, _) = Affine::of_node(&node).expect("sound");
        assert_eq!(affine.point([1.0, 2.0, 3.0]), [3.0, 1.0, 3.0]);
        m[3] = 0.5;
        let node = ExactNode {
            matrix: Some(m),
            ..node
        };
        assert!(Affine::of_node(&node).is_err());
    }
}
