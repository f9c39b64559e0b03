//! Matrices of joints: affine maps as three rows of four, whatever scale, shear and mirroring they have.

use crate::error::PoseError;
use crate::math::{cross, dot, rotation_matrix, sub};
use crate::transform::Transform;

/// An affine map, three rows of four: `x ↦ A x + t` with row r = (A_r0, A_r1, A_r2, t_r). Of a joint it is the map from
/// the joint's space to the model's (mesh units).
pub type JointMatrix = [[f64; 4]; 3];

/// The map that changes nothing.
pub const IDENTITY: JointMatrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];

/// The map that does what `inner` does and then what `outer` does.
pub fn compose(outer: &JointMatrix, inner: &JointMatrix) -> JointMatrix {
    let [a, b, c] = inner;
    // Spelled out: compilers leave `array::map` of this size as calls.
    let row = |[x, y, z, shift]: [f64; 4]| {
        [
            x * a[0] + y * b[0] + z * c[0],
            x * a[1] + y * b[1] + z * c[1],
            x * a[2] + y * b[2] + z * c[2],
            x * a[3] + y * b[3] + z * c[3] + shift,
        ]
    };
    [row(outer[0]), row(outer[1]), row(outer[2])]
}

/// Where a map takes a point.
pub fn transform_point(map: &JointMatrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    map.map(|[a, b, c, shift]| a * x + b * y + c * z + shift)
}

/// The map that undoes `map`; `None` where none does, or numbers are not finite.
pub fn invert(map: &JointMatrix) -> Option<JointMatrix> {
    let [a, b, c] = map.map(|[x, y, z, _]| [x, y, z]);
    let shift = map.map(|row| row[3]);
    // Columns of the inverse, times the determinant.
    let [p, q, r] = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, p);
    let inverse = [0, 1, 2].map(|k| {
        let row = [p[k], q[k], r[k]].map(|x| x / determinant);
        [row[0], row[1], row[2], -dot(row, shift)]
    });
    let is_finite = inverse.as_flattened().iter().all(|x| x.is_finite());
    is_finite.then_some(inverse)
}

/// A matrix of four columns, as engines and glTF keep them: glam's `to_cols_array_2d`, mint's `ColumnMatrix4`.
///
/// # Errors
/// [`PoseError::Projection`] for one that projects: whose last row is other than 0, 0, 0, 1, without a tolerance. Set it
/// where a computation of yours has rounded it.
pub fn from_columns<T: Copy + Into<f64>>(
    columns: impl Into<[[T; 4]; 4]>,
) -> Result<JointMatrix, PoseError> {
    let columns = columns.into().map(|column| column.map(Into::into));
    if columns.map(|column| column[3]) != [0.0, 0.0, 0.0, 1.0] {
        return Err(PoseError::Projection);
    }
    Ok([0, 1, 2].map(|r| columns.map(|column| column[r])))
}

/// The matrix of four columns of a map.
pub fn to_columns(map: &JointMatrix) -> [[f64; 4]; 4] {
    let column = |c: usize, last| [map[0][c], map[1][c], map[2][c], last];
    [
        column(0, 0.0),
        column(1, 0.0),
        column(2, 0.0),
        column(3, 1.0),
    ]
}

impl Transform {
    /// Converts a joint matrix from world space (world units) to model space (mesh units), for
    /// [`Instance::set_joints`](crate::Instance::set_joints). `self` is the instance's placement.
    ///
    /// The placement is not checked, and its quaternion is normalised.
    pub fn joint_in_model(&self, world: &JointMatrix) -> JointMatrix {
        let length = crate::math::sqrt(self.rotation.iter().map(|x| x * x).sum());
        let turn = rotation_matrix(self.rotation.map(|x| x / length));
        let columns = [0, 1, 2, 3].map(|c| {
            let column = world.map(|row| row[c]);
            let column = if c == 3 {
                sub(column, self.translation)
            } else {
                column
            };
            // The transpose undoes a rotation.
            [0, 1, 2].map(|r| dot(turn.map(|row| row[r]), column) / self.scale)
        });
        [0, 1, 2].map(|r| columns.map(|column| column[r]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: JointMatrix = [
        [0.0, -2.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, -3.0],
        [0.0, 0.5, -4.0, 2.0],
    ];

    #[test]
    fn maps_compose_from_right_to_left() {
        let both = compose(&MAP, &MAP);
        let point = [0.5, -1.0, 2.0];
        let twice = transform_point(&MAP, transform_point(&MAP, point));
        assert_eq!(transform_point(&both, point), twice);
        assert_eq!(compose(&IDENTITY, &MAP), MAP);
        assert_eq!(compose(&MAP, &IDENTITY), MAP);
    }

    #[test]
    fn inverses_undo_maps() {
        let inverse = invert(&MAP).expect("an inverse");
        assert_eq!(compose(&inverse, &MAP), IDENTITY);
        assert_eq!(compose(&MAP, &inverse), IDENTITY);
        let flat = [MAP[0], MAP[1], [0.0; 4]];
        assert_eq!(invert(&flat), None);
        assert_eq!(invert(&[[f64::NAN; 4]; 3]), None);
    }

    #[test]
    fn columns_are_transposed() {
        let columns = to_columns(&MAP);
        assert_eq!(columns[3], [1.0, -3.0, 2.0, 1.0]);
        assert_eq!(from_columns(columns), Ok(MAP));
        let narrow = columns.map(|column| column.map(|x| x as f32));
        assert_eq!(from_columns(narrow), Ok(MAP));
        let mut projects = columns;
        projects[1][3] = 0.5;
        assert_eq!(from_columns(projects), Err(PoseError::Projection));
    }

    #[test]
    #[cfg(feature = "mint")]
    fn columns_come_from_mint() {
        let matrix = mint::ColumnMatrix4::from(to_columns(&MAP));
        assert_eq!(from_columns::<f64>(matrix), Ok(MAP));
    }

    #[test]
    fn joints_of_the_world_come_back() {
        // A quarter turn about z, twice as large, moved by (1, 2, 3).
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let place = Transform {
            rotation: [0.0, 0.0, half, half],
            translation: [1.0, 2.0, 3.0],
            scale: 2.0,
        };
        // Where it puts a joint that stands at (1, 0, 0) with axes along those of the model.
        let world = [
            [0.0, -2.0, 0.0, 1.0],
            [2.0, 0.0, 0.0, 4.0],
            [0.0, 0.0, 2.0, 3.0],
        ];
        let joint = place.joint_in_model(&world);
        let expected = [
            [1.0, 0.0, 0.0, 1.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ];
        for (a, b) in joint.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((a - b).abs() < 1e-15, "{joint:?}");
        }
    }
}
