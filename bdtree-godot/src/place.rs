//! From Godot's transforms to the library's placements, matrices and boxes, in f64.

use bdtree_runtime::joint::compose;
use bdtree_runtime::{Cuboid, JointMatrix, Transform};

use crate::fault::Fault;

/// By what share axes may differ in length, and how far their cosines may be from 0: what products of many f32 matrices
/// come to.
const TOLERANCE: f64 = 1e-3;

/// A `Transform3D`, row by row: Godot's `Basis` keeps rows, too.
pub(crate) fn matrix(rows: [[f32; 3]; 3], origin: [f32; 3]) -> JointMatrix {
    [0, 1, 2].map(|r| {
        let [x, y, z] = rows[r].map(f64::from);
        [x, y, z, f64::from(origin[r])]
    })
}

/// Where a mesh stands whose node has this transform.
///
/// # Errors
/// Axes of different lengths, shear, mirroring, numbers that are not finite.
pub(crate) fn placement(of: &JointMatrix) -> Result<Transform, Fault> {
    let axes = axes(of);
    let volume = determinant(&axes);
    // Zero and NaN are not above it.
    if !(volume > 0.0 && of.iter().all(|row| row[3].is_finite())) {
        return Err(Fault::Transform);
    }
    let scale = volume.cbrt();
    let axes = axes.map(|axis| axis.map(|x| x / scale));
    let is_even = axes.iter().all(|axis| near(dot(axis, axis).sqrt(), 1.0));
    if !(is_even && are_square(&axes)) {
        return Err(Fault::Transform);
    }
    Ok(Transform {
        rotation: quaternion(&axes),
        translation: of.map(|row| row[3]),
        scale,
    })
}

/// A bone as the collider's model has it. `at`: where the collider stands; `mesh`: the global transform of the
/// MeshInstance3D, at which Godot draws a skinned mesh; `pose`: the bone's, relative to the skeleton. Whatever `at` is, the
/// mesh is then where it is drawn.
pub(crate) fn bone_in_model(at: &Transform, mesh: &JointMatrix, pose: &JointMatrix) -> JointMatrix {
    at.joint_in_model(&compose(mesh, pose))
}

/// The box of a `BoxShape3D` of this size in a node of this transform, whose axes may be of different lengths.
///
/// # Errors
/// Axes that are not at right angles, or of length 0.
pub(crate) fn cuboid(of: &JointMatrix, size: [f32; 3]) -> Result<Cuboid, Fault> {
    let axes = axes(of);
    let lengths = axes.map(|axis| dot(&axis, &axis).sqrt());
    if !lengths
        .iter()
        .all(|length| *length > 0.0 && length.is_finite())
    {
        return Err(Fault::BoxAxes);
    }
    let mut unit = [0, 1, 2].map(|k| axes[k].map(|x| x / lengths[k]));
    if !are_square(&unit) {
        return Err(Fault::BoxAxes);
    }
    // A box is the same mirrored.
    if determinant(&unit) < 0.0 {
        unit[2] = unit[2].map(|x| -x);
    }
    let half = [0, 1, 2].map(|k| 0.5 * f64::from(size[k]) * lengths[k]);
    Ok(Cuboid::new(of.map(|row| row[3]), half).rotated(quaternion(&unit)))
}

/// The columns: where the axes go.
fn axes(of: &JointMatrix) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| of.map(|row| row[c]))
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn determinant([x, y, z]: &[[f64; 3]; 3]) -> f64 {
    let across = [
        y[1] * z[2] - y[2] * z[1],
        y[2] * z[0] - y[0] * z[2],
        y[0] * z[1] - y[1] * z[0],
    ];
    dot(x, &across)
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= TOLERANCE
}

fn are_square([x, y, z]: &[[f64; 3]; 3]) -> bool {
    near(dot(x, y), 0.0) && near(dot(y, z), 0.0) && near(dot(z, x), 0.0)
}

/// The unit quaternion (x, y, z, w) of a rotation whose axes are these columns.
fn quaternion([x, y, z]: &[[f64; 3]; 3]) -> [f64; 4] {
    // Four times the squares of the parts: the largest one is divided by.
    let squares = [
        1.0 + x[0] - y[1] - z[2],
        1.0 - x[0] + y[1] - z[2],
        1.0 - x[0] - y[1] + z[2],
        1.0 + x[0] + y[1] + z[2],
    ];
    let largest = (0..4).fold(
        0,
        |best, k| {
            if squares[k] > squares[best] { k } else { best }
        },
    );
    let parts = match largest {
        0 => [squares[0], x[1] + y[0], z[0] + x[2], y[2] - z[1]],
        1 => [x[1] + y[0], squares[1], y[2] + z[1], z[0] - x[2]],
        2 => [z[0] + x[2], y[2] + z[1], squares[2], x[1] - y[0]],
        _ => [y[2] - z[1], z[0] - x[2], x[1] - y[0], squares[3]],
    };
    let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    parts.map(|part| part / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bdtree_runtime::joint::transform_point;

    /// Where a placement takes a point, by the definition: the vector part of q p q*.
    fn placed(at: &Transform, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = at.rotation;
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let p = p.map(|c| c * at.scale);
        let v = [x, y, z];
        let once = cross(v, p);
        let twice = cross(v, once);
        [0, 1, 2].map(|k| p[k] + 2.0 * (w * once[k] + twice[k]) + at.translation[k])
    }

    /// Rotations about skew axes, half turns among them, where the real part is 0.
    fn rotations() -> Vec<[f64; 4]> {
        let mut all = Vec::new();
        for axis in [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.36, 0.48, 0.8],
            [-0.6, 0.0, 0.8],
        ] {
            for eighths in 0..8 {
                let (sin, cos) = (f64::from(eighths) * std::f64::consts::FRAC_PI_8).sin_cos();
                all.push([axis[0] * sin, axis[1] * sin, axis[2] * sin, cos]);
            }
        }
        all
    }

    fn matrix_of(at: &Transform) -> JointMatrix {
        let origin = placed(at, [0.0; 3]);
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|p| placed(at, p));
        let rows = [0, 1, 2].map(|r| columns.map(|column| (column[r] - origin[r]) as f32));
        matrix(rows, origin.map(|x| x as f32))
    }

    #[test]
    fn placements_move_points_as_matrices_do() {
        for rotation in rotations() {
            let given = Transform {
                rotation,
                translation: [1.5, -2.0, 0.25],
                scale: 0.01,
            };
            let of = matrix_of(&given);
            let at = placement(&of).expect("rigid but for one scale");
            for p in [[1.0, 2.0, 3.0], [-40.0, 0.5, 7.0]] {
                let (a, b) = (placed(&at, p), transform_point(&of, p));
                let apart = [0, 1, 2].map(|k| (a[k] - b[k]).abs());
                assert!(apart.iter().all(|x| *x < 1e-6), "{rotation:?}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn other_transforms_are_refused() {
        let one: JointMatrix = bdtree_runtime::joint::IDENTITY;
        assert!(placement(&one).is_ok());
        let with = |r: usize, c: usize, x: f64| {
            let mut other = one;
            other[r][c] = x;
            placement(&other)
        };
        for (r, c, x) in [
            (0, 0, 1.01),
            (0, 0, -1.0),
            (0, 0, 0.0),
            (0, 1, 0.01),
            (2, 3, f64::INFINITY),
            (1, 1, f64::NAN),
        ] {
            let refused = with(r, c, x);
            assert!(matches!(refused, Err(Fault::Transform)), "{r} {c} {x}");
        }
        // Rounding of f32 is not a fault.
        assert!(with(0, 0, 1.0001).is_ok());
    }

    #[test]
    fn boxes_have_the_corners_that_the_transform_gives_them() {
        for rotation in rotations() {
            let at = Transform {
                rotation,
                translation: [3.0, 2.0, 1.0],
                scale: 2.0,
            };
            let mut of = matrix_of(&at);
            // Mirrored, and of three lengths.
            let factors = [0.5, -1.0, 3.0];
            for row in &mut of {
                for c in 0..3 {
                    row[c] *= factors[c];
                }
            }
            let size = [1.0, 2.0, 0.5];
            let cuboid = cuboid(&of, size).expect("square");
            let frame = Transform {
                rotation: cuboid.rotation,
                translation: cuboid.center,
                scale: 1.0,
            };
            // Every corner of the one is a corner of the other.
            let signs = (0..8).map(|n| [0, 1, 2].map(|k| if n >> k & 1 == 1 { 1.0 } else { -1.0 }));
            for s in signs.clone() {
                let p = [0, 1, 2].map(|k| 0.5 * f64::from(size[k]) * s[k]);
                let corner = transform_point(&of, p);
                let nearest = signs.clone().map(|s| {
                    let own = placed(&frame, [0, 1, 2].map(|k| cuboid.half_extents[k] * s[k]));
                    (0..3).map(|k| (own[k] - corner[k]).abs()).sum::<f64>()
                });
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-5, "{rotation:?} {s:?}: {nearest}");
            }
        }
        let mut flat = bdtree_runtime::joint::IDENTITY;
        flat[0][0] = 0.0;
        assert!(matches!(cuboid(&flat, [1.0; 3]), Err(Fault::BoxAxes)));
        let mut shear = bdtree_runtime::joint::IDENTITY;
        shear[0][1] = 0.1;
        assert!(matches!(cuboid(&shear, [1.0; 3]), Err(Fault::BoxAxes)));
    }
}
