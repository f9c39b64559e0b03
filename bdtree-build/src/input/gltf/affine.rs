//! Placements of nodes: x ↦ L x + t in f64.

use bdtree_runtime::math::{cross, dot, norm, rotation_matrix, sub};

use super::document::ExactNode;
use crate::input::{Local, Rows};

/// Rotations whose length is off by more are said so.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A matrix whose last row is off by more is none of a node.
const LAST_ROW_TOLERANCE: f64 = 1e-5;

/// A map whose linear part and its inverse have a larger product of norms loses too many digits when it is undone.
const CONDITION_MAX: f64 = (1_u64 << 24) as f64;

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

    /// Puts everything at the origin.
    pub(super) const ZERO: Self = Self {
        linear: [[0.0; 3]; 3],
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

    /// The map of [`Affine::rows`].
    pub(super) fn of_rows(rows: &Rows) -> Self {
        Self {
            linear: rows.map(|[x, y, z, _]| [x, y, z]),
            translation: rows.map(|row| row[3]),
        }
    }

    /// Rows of L with t behind them.
    pub(super) fn rows(&self) -> Rows {
        std::array::from_fn(|i| {
            let [x, y, z] = self.linear[i];
            [x, y, z, self.translation[i]]
        })
    }

    /// The map from sixteen numbers, column by column. The second value says that its last row is rounded.
    ///
    /// # Errors
    /// A last row that is not 0, 0, 0, 1.
    pub(super) fn of_columns(m: &[f64; 16]) -> Result<(Self, bool), String> {
        let last = [m[3], m[7], m[11], m[15] - 1.0];
        if !last.iter().all(|x| x.abs() <= LAST_ROW_TOLERANCE) {
            return Err("its last row is not 0, 0, 0, 1".into());
        }
        let affine = Self {
            linear: std::array::from_fn(|i| [m[i], m[4 + i], m[8 + i]]),
            translation: [m[12], m[13], m[14]],
        };
        Ok((affine, last != [0.0; 4]))
    }

    /// What undoes the map; `None` where that has lost most of its digits or there is nothing.
    pub(super) fn inverse(&self) -> Option<Self> {
        self.inverse_within(CONDITION_MAX)
    }

    /// What undoes the map; `None` where ‖L‖ ‖L⁻¹‖ (Frobenius norms: 3 for a rotation) is above `condition_max`.
    pub(super) fn inverse_within(&self, condition_max: f64) -> Option<Self> {
        let [a, b, c] = self.linear;
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant = dot(a, cofactors[0]);
        // Columns of the inverse.
        let columns = cofactors.map(|column| column.map(|x| x / determinant));
        let linear: [[f64; 3]; 3] = std::array::from_fn(|i| columns.map(|column| column[i]));
        let condition = frobenius(&self.linear) * frobenius(&linear);
        let turned = Self {
            linear,
            translation: [0.0; 3],
        };
        let translation = turned.vector(self.translation).map(|x| 0.0 - x);
        let is_sound = condition <= condition_max && translation.iter().all(|x| x.is_finite());
        is_sound.then_some(Self {
            linear,
            translation,
        })
    }

    /// The root mean square of the lengths to which L brings the unit vectors.
    pub(super) fn scale(&self) -> f64 {
        frobenius(&self.linear) / 3.0_f64.sqrt()
    }

    /// How far apart this map and `other` put a point that is no farther than `reach` from the origin, at most.
    pub(super) fn apart(&self, other: &Self, reach: f64) -> f64 {
        let linear: [[f64; 3]; 3] = std::array::from_fn(|i| sub(self.linear[i], other.linear[i]));
        frobenius(&linear) * reach + norm(sub(self.translation, other.translation))
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
            let (affine, is_rounded) =
                Self::of_columns(&m).map_err(|message| format!("matrix: {message}"))?;
            let parts =
                node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
            let odd = if parts {
                Some("matrix is used; translation, rotation and scale beside it are not")
            } else if is_rounded {
                Some("matrix: its last row is taken as 0, 0, 0, 1, which it nearly is")
            } else {
                None
            };
            return Ok((affine, odd.map(str::to_string)));
        }
        let mut odd = None;
        if let Some(q) = node.rotation {
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(length > 0.0 && length.is_finite()) {
                return Err(format!("rotation {q:?} has no direction"));
            }
            if (length - 1.0).abs() > UNIT_TOLERANCE {
                odd = Some(format!("rotation of length {length} brought to length 1"));
            }
        }
        Ok((Self::of_local(&local(node)), odd))
    }

    /// The map from a node's coordinates to its parent's.
    pub(super) fn of_local(local: &Local) -> Self {
        match local {
            Local::Matrix(rows) => Self::of_rows(rows),
            Local::Parts {
                translation,
                rotation,
                scale,
            } => Self {
                linear: rotation_matrix(*rotation)
                    .map(|row| std::array::from_fn(|k| row[k] * scale[k])),
                translation: *translation,
            },
        }
    }
}

/// The Frobenius norm.
fn frobenius(rows: &[[f64; 3]; 3]) -> f64 {
    rows.iter().map(|row| dot(*row, *row)).sum::<f64>().sqrt()
}

/// A node's placement as parts, which clips may animate, or as its matrix. The node is one that [`Affine::of_node`] took.
pub(super) fn local(node: &ExactNode) -> Local {
    if let Some(m) = node.matrix {
        let affine = Affine::of_columns(&m).map_or(Affine::IDENTITY, |(affine, _)| affine);
        return Local::Matrix(affine.rows());
    }
    let rotation = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    Local::Parts {
        translation: node.translation.unwrap_or_default(),
        rotation: rotation.map(|x| x / length),
        scale: node.scale.unwrap_or([1.0; 3]),
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
