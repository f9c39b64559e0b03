//! From Bevy's transforms to the library's placements and matrices, in f64.

use bdtree_runtime::{JointMatrix, Transform as Placement};
use bevy_math::{Affine3A, DMat3, DQuat, Mat3A, Vec3A};
use bevy_transform::components::GlobalTransform;
use thiserror::Error;

/// A `GlobalTransform` that no deforming mesh takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "the entity's GlobalTransform scales its axes differently, shears, mirrors or is not finite: a deforming mesh takes a \
     rotation, one positive scale and a translation"
)]
pub struct PlacementError;

/// By what share the axes of a `GlobalTransform` may differ in length, and how far their cosines may be from 0: what
/// products of many f32 matrices come to.
const TOLERANCE: f64 = 1e-3;

/// Where a mesh stands whose entity has this transform.
///
/// # Errors
/// Axes of different lengths, shear, mirroring, numbers that are not finite.
pub fn placement(transform: &GlobalTransform) -> Result<Placement, PlacementError> {
    let affine = transform.affine();
    let matrix = affine.matrix3.as_dmat3();
    let determinant = matrix.determinant();
    // Zero and NaN are not above it.
    if !(determinant > 0.0 && affine.translation.is_finite()) {
        return Err(PlacementError);
    }
    let scale = determinant.cbrt();
    let turn = matrix * (1.0 / scale);
    let [x, y, z] = [turn.x_axis, turn.y_axis, turn.z_axis];
    let is_near = |product: f64, expected: f64| (product - expected).abs() <= TOLERANCE;
    let is_rigid = [x, y, z].iter().all(|axis| is_near(axis.length(), 1.0))
        && is_near(x.dot(y), 0.0)
        && is_near(y.dot(z), 0.0)
        && is_near(z.dot(x), 0.0);
    if !is_rigid {
        return Err(PlacementError);
    }
    Ok(Placement {
        rotation: DQuat::from_mat3(&turn).normalize().to_array(),
        translation: affine.translation.to_array().map(f64::from),
        scale,
    })
}

/// The rotation of a placement, as a matrix.
pub(crate) fn rotation(placement: &Placement) -> DMat3 {
    DMat3::from_quat(DQuat::from_array(placement.rotation).normalize())
}

/// Row by row, as the runtime has it.
pub(crate) fn rows(matrix: &Affine3A) -> JointMatrix {
    let rows = matrix.matrix3.transpose();
    let shift = matrix.translation;
    // Spelled out: `array::map` is left as calls, which cost as much as the pose.
    let row = |row: Vec3A, shift: f32| [row.x.into(), row.y.into(), row.z.into(), shift.into()];
    [
        row(rows.x_axis, shift.x),
        row(rows.y_axis, shift.y),
        row(rows.z_axis, shift.z),
    ]
}

/// Column by column, rounded, as Bevy has it.
pub(crate) fn affine(rows: &JointMatrix) -> Affine3A {
    let [x, y, z] = rows;
    let column = |c: usize| Vec3A::new(x[c] as f32, y[c] as f32, z[c] as f32);
    Affine3A {
        matrix3: Mat3A::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}
