//! Rigid motions as matrices, and the motion that takes one shape nearest to another.

use nalgebra::{Matrix3, Matrix4, Quaternion, SymmetricEigen, UnitQuaternion, Vector3};

use crate::basis::RigidMotion;

/// Weight of the rotation to stay near, relative to the shape's moments: far above rounding, far
/// below anything that shows. It decides where the shapes leave the rotation open (a line, a point).
const NEARNESS: f64 = 1e-12;

/// Most sweeps of the eigenvalue iteration; four by four matrices take about ten.
const SWEEPS_MAX: usize = 1000;

/// x ↦ R x + t.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Motion {
    /// R x + t.
    pub(super) fn apply(&self, x: [f64; 3]) -> [f64; 3] {
        (self.rotation * Vector3::from(x) + self.translation).into()
    }

    /// Rᵀ (x − t).
    pub(super) fn undo(&self, x: [f64; 3]) -> [f64; 3] {
        self.rotation
            .tr_mul(&(Vector3::from(x) - self.translation))
            .into()
    }
}

impl From<&RigidMotion> for Motion {
    fn from(motion: &RigidMotion) -> Self {
        Self {
            rotation: rotation(motion).to_rotation_matrix().into_inner(),
            translation: motion.translation.into(),
        }
    }
}

fn rotation(motion: &RigidMotion) -> UnitQuaternion<f64> {
    let [x, y, z, w] = motion.rotation;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// The rotation R and the translation for which Σ |R y_i + t − x_i|² is least (Horn, "Closed-form
/// solution of absolute orientation using unit quaternions", 1987): a proper rotation also where a
/// reflection would fit better. Its quaternion has the sign of that of `near`, which also decides
/// where the shapes leave the rotation open.
///
/// `moments[a][b]` is Σ (y_i − ȳ)_a (x_i − x̄)_b; `from` is ȳ, `to` is x̄.
pub(super) fn nearest_motion(
    moments: [[f64; 3]; 3],
    from: [f64; 3],
    to: [f64; 3],
    near: &RigidMotion,
) -> RigidMotion {
    let near = rotation(near);
    let best = nearest_rotation(moments, near).unwrap_or(near);
    let translation = Vector3::from(to) - best * Vector3::from(from);
    RigidMotion {
        rotation: [best.i, best.j, best.k, best.w],
        translation: translation.into(),
    }
}

fn nearest_rotation(
    moments: [[f64; 3]; 3],
    near: UnitQuaternion<f64>,
) -> Option<UnitQuaternion<f64>> {
    let moments = Matrix3::from_fn(|a, b| moments[a][b]);
    let size = moments.amax();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let towards_near = near.to_rotation_matrix().into_inner().transpose();
    let s = moments / size + towards_near * NEARNESS;
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] =
        std::array::from_fn(|a| std::array::from_fn(|b| s[(a, b)]));
    #[rustfmt::skip]
    let n = Matrix4::new(
        xx + yy + zz, yz - zy,      zx - xz,       xy - yx,
        yz - zy,      xx - yy - zz, xy + yx,       zx + xz,
        zx - xz,      xy + yx,      -xx + yy - zz, yz + zy,
        xy - yx,      zx + xz,      yz + zy,       -xx - yy + zz,
    );
    let eigen = SymmetricEigen::try_new(n, f64::EPSILON, SWEEPS_MAX)?;
    let best = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let best = Quaternion::new(best[0], best[1], best[2], best[3]);
    let sign = if best.dot(&near) < 0.0 { -1.0 } else { 1.0 };
    Some(UnitQuaternion::from_quaternion(best * sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: [[f64; 3]; 5] = [
        [1.0, 0.2, 0.0],
        [-0.3, 1.0, 0.1],
        [0.4, -0.2, 2.0],
        [-1.1, -1.0, -2.1],
        [0.7, 0.3, -0.5],
    ];

    fn mean(points: &[[f64; 3]]) -> [f64; 3] {
        [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64)
    }

    fn fit(from: &[[f64; 3]], to: &[[f64; 3]], near: &RigidMotion) -> RigidMotion {
        let (a, b) = (mean(from), mean(to));
        let mut moments = [[0.0; 3]; 3];
        for (y, x) in from.iter().zip(to) {
            for (j, row) in moments.iter_mut().enumerate() {
                for (k, entry) in row.iter_mut().enumerate() {
                    *entry += (y[j] - a[j]) * (x[k] - b[k]);
                }
            }
        }
        nearest_motion(moments, a, b, near)
    }

    fn sum_of_squares(motion: &RigidMotion, from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
        let motion = Motion::from(motion);
        let pairs = from.iter().zip(to);
        pairs
            .map(|(y, x)| {
                let moved = motion.apply(*y);
                (0..3).map(|k| (moved[k] - x[k]).powi(2)).sum::<f64>()
            })
            .sum()
    }

    fn turn(axis: [f64; 3], angle: f64, translation: [f64; 3]) -> RigidMotion {
        let q = UnitQuaternion::from_scaled_axis(Vector3::from(axis).normalize() * angle);
        RigidMotion {
            rotation: [q.i, q.j, q.k, q.w],
            translation,
        }
    }

    #[test]
    fn a_known_motion_is_found_and_undone() {
        for angle in [0.0, 0.3, 1.5, 3.0, std::f64::consts::PI] {
            let known = turn([1.0, 2.0, -0.5], angle, [10.0, -3.0, 0.5]);
            let moved = BODY.map(|p| Motion::from(&known).apply(p));
            let found = fit(&BODY, &moved, &RigidMotion::IDENTITY);
            // Five points two units away; nearness turns them by itself over the smaller moments,
            // which are about a tenth of the largest.
            let tolerance = 5.0 * (2.0 * 10.0 * NEARNESS).powi(2);
            assert!(sum_of_squares(&found, &BODY, &moved) < tolerance, "{angle}");
            let back = moved.map(|p| Motion::from(&found).undo(p));
            let still = sum_of_squares(&RigidMotion::IDENTITY, &BODY, &back);
            assert!(still < tolerance, "{angle}");
        }
    }

    #[test]
    fn no_other_motion_is_nearer() {
        // Bent and reflected: the best proper rotation, not an improper one.
        for mirror in [1.0, -1.0] {
            let to = BODY.map(|p| [mirror * p[0] + 0.2 * p[1] * p[1], p[1], p[2] * 1.2 + 4.0]);
            let found = fit(&BODY, &to, &RigidMotion::IDENTITY);
            let best = sum_of_squares(&found, &BODY, &to);
            for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                for angle in [-1.0, -1e-3, 1e-3, 1.0] {
                    let more = rotation(&turn(axis, angle, [0.0; 3])) * rotation(&found);
                    let center = Vector3::from(mean(&to));
                    let shift = center - more * Vector3::from(mean(&BODY));
                    let other = RigidMotion {
                        rotation: [more.i, more.j, more.k, more.w],
                        translation: shift.into(),
                    };
                    assert!(
                        sum_of_squares(&other, &BODY, &to) > best,
                        "{mirror} {angle}"
                    );
                }
            }
        }
    }

    #[test]
    fn lines_and_points_stay_near() {
        let near = turn([0.0, 0.0, 1.0], 0.5, [0.0; 3]);
        let line = [-1.0, 0.5, 2.0].map(|x| [x, 0.0, 0.0]);
        let moved = line.map(|p| Motion::from(&near).apply(p));
        let found = fit(&line, &moved, &near);
        assert!(rotation(&found).angle_to(&rotation(&near)) < 1e-3);
        let point = [[1.0, 2.0, 3.0]];
        let found = fit(&point, &[[4.0, 4.0, 4.0]], &near);
        assert!(rotation(&found).angle_to(&rotation(&near)) < 1e-15);
        let at = Motion::from(&found).apply(point[0]);
        assert!(at.iter().all(|x| (x - 4.0).abs() < 1e-15));
    }

    #[test]
    fn quaternions_keep_their_sign() {
        let mut near = RigidMotion::IDENTITY;
        for step in 0..100 {
            let known = turn([0.3, 1.0, 0.2], 0.1 * f64::from(step), [0.0; 3]);
            let moved = BODY.map(|p| Motion::from(&known).apply(p));
            let found = fit(&BODY, &moved, &near);
            let dot: f64 = (0..4).map(|k| found.rotation[k] * near.rotation[k]).sum();
            assert!(dot > 0.99, "{step}: {dot}");
            near = found;
        }
    }
}
