//! Free rotation of a rigid body: angular momentum stays as it is, to the bit.

use libm::{cos, sin, sqrt};
#[cfg(feature = "alloc")]
use nalgebra::Matrix3;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The rotation about `axis` (of any length) by its length in radians.
pub fn rotation(axis: Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = sqrt(axis.dot(&axis));
    let (half, share) = (0.5 * angle, half_sine_over(angle));
    let v = axis * share;
    UnitQuaternion::new_normalize(Quaternion::new(cos(half), v.x, v.y, v.z))
}

/// sin(x/2) / x.
fn half_sine_over(x: f64) -> f64 {
    if x < 1e-4 {
        0.5 - x * x / 48.0
    } else {
        sin(0.5 * x) / x
    }
}

/// About a coordinate axis.
fn about(k: usize, angle: f64) -> UnitQuaternion<f64> {
    let mut axis = Vector3::zeros();
    axis[k] = angle;
    rotation(axis)
}

/// Orientation after `step_s` seconds without torque. `orientation` turns the frame of the principal axes of inertia into
/// the world, `inertia` are the principal moments, `momentum` the angular momentum in the world.
///
/// The kinetic energy is split into the parts of the three axes, whose flows are rotations (Reich 1996; Dullweber,
/// Leimkuhler and McLachlan 1997): second order in the step, symplectic, so that the energy error stays bounded, and
/// `momentum` does not change at all. Exact for rotation about a principal axis.
pub fn turn_freely(
    orientation: UnitQuaternion<f64>,
    inertia: Vector3<f64>,
    momentum: Vector3<f64>,
    step_s: f64,
) -> UnitQuaternion<f64> {
    let half = 0.5 * step_s;
    let mut turned = orientation;
    for (axis, step) in [(0, half), (1, half), (2, step_s), (1, half), (0, half)] {
        let own = turned.inverse_transform_vector(&momentum);
        turned *= about(axis, step * own[axis] / inertia[axis]);
    }
    // Five products of unit quaternions leave the unit sphere by some units in the last place, which add up.
    UnitQuaternion::new_normalize(turned.into_inner())
}

/// Principal moments of inertia, ascending, and the rotation from their axes to those of `tensor`; `None` for a tensor that
/// is not symmetric, finite and positive definite.
#[cfg(feature = "alloc")]
pub fn principal_axes(tensor: &Matrix3<f64>) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let size = tensor.abs().max();
    if !(size.is_finite() && size > 0.0) || (tensor - tensor.transpose()).abs().max() > 1e-9 * size
    {
        return None;
    }
    let found = tensor.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| found.eigenvalues[a].total_cmp(&found.eigenvalues[b]));
    let moments = Vector3::from_fn(|k, _| found.eigenvalues[order[k]]);
    if !(moments[0] > 1e-12 * moments[2]) {
        return None;
    }
    let mut axes = Matrix3::from_fn(|r, k| found.eigenvectors[(r, order[k])]);
    if axes.determinant() < 0.0 {
        axes.column_mut(0).neg_mut();
    }
    let axes = nalgebra::Rotation3::from_matrix_unchecked(axes);
    Some((moments, UnitQuaternion::from_rotation_matrix(&axes)))
}
