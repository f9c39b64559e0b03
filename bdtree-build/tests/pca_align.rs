//! `--align`: rigid motion goes out before the modes and comes back in playback.

use crate::pca_support::*;
use bdtree_build::basis::RigidMotion;
use bdtree_build::basis::pca::{About, PcaOptions};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

fn aligned(modes: usize, about: About) -> PcaOptions {
    PcaOptions {
        align: true,
        about,
        ..count(modes)
    }
}

fn tumble(t: usize) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let s = t as f64;
    let axis = Vector3::new((0.1 * s).sin(), 1.0, (0.05 * s).cos()).normalize();
    let rotation = UnitQuaternion::from_scaled_axis(axis * (0.31 * s));
    (rotation, Vector3::new(3.0 * s, -0.1 * s * s, 5.0))
}

fn moved(frame: &[V3], t: usize) -> Vec<V3> {
    let (rotation, translation) = tumble(t);
    let apply = |p: &V3| (rotation * Vector3::from(*p) + translation).into();
    frame.iter().map(apply).collect()
}

fn quaternion(motion: &RigidMotion) -> UnitQuaternion<f64> {
    let [x, y, z, w] = motion.rotation;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

#[test]
fn a_rigid_tumble_leaves_no_modes() {
    let body = &cloth(100, 1)[0];
    let frames: Frames = (0..60).map(|t| moved(body, t)).collect();
    for about in [About::Mean, About::Input] {
        let made = make(frames.clone(), body, Precision::Double);
        let (found, warnings) = pca_with_warnings(&made, &aligned(4, about));
        assert_eq!(found.basis.mode_count(), 0, "{warnings:?}");
        let animation = found.basis.animation.as_ref().expect("an animation");
        assert_eq!(animation.motions.len(), 60);
        for (t, pair) in animation.motions.windows(2).enumerate() {
            // The tumble turns by about 0.31 rad per frame: no jump in sign.
            let dot: f64 = (0..4)
                .map(|k| pair[0].rotation[k] * pair[1].rotation[k])
                .sum();
            assert!(dot > 0.9, "{t}: {dot}");
        }
        for (t, motion) in animation.motions.iter().enumerate() {
            let angle = quaternion(motion).angle_to(&tumble(t).0);
            assert!(angle < 1e-11, "{about:?} {t}: {angle}");
        }
        // Stored positions are f32, the motions f64.
        assert!(found.error.max_rel < 1e-7, "{:?}", found.error);
        assert_error_is_true(&found, &frames, "tumble");
    }
}

/// A body that bends while it tumbles needs the modes of the bending alone.
#[test]
fn modes_are_those_of_the_body_at_rest() {
    let still = cloth(300, 50);
    let frames: Frames = still.iter().enumerate().map(|(t, f)| moved(f, t)).collect();
    let rest = mean(&still);
    let made = make(frames.clone(), &rest, Precision::Double);
    for about in [About::Mean, About::Input] {
        for modes in [0, 1, 4, 12, 50] {
            let (found, _) = pca_with_warnings(&made, &aligned(modes, about));
            assert_error_is_true(&found, &frames, &format!("{about:?} {modes}"));
            if modes == 50 {
                assert!(found.error.max_rel < 1e-6, "{about:?}: {:?}", found.error);
            }
            // Any motions leave at least what the best fields leave of the aligned frames.
            let animation = found.basis.animation.as_ref().expect("an animation");
            let undone: Frames = frames
                .iter()
                .zip(&animation.motions)
                .map(|(frame, motion)| {
                    let inverse = quaternion(motion).inverse();
                    let translation = Vector3::from(motion.translation);
                    let undo = |p: &V3| (inverse * (Vector3::from(*p) - translation)).into();
                    frame.iter().map(undo).collect()
                })
                .collect();
            let about_mean = mean(&undone);
            let rest = match about {
                About::Mean => &about_mean,
                About::Input => &rest,
            };
            let values = singular_values(&snapshots(&undone, rest));
            let optimal = optimal_rms(&values, modes, 300 * 50) / diagonal(rest);
            let rms = found.error.rms_rel;
            let close = (rms - optimal).abs() < 1e-5 * optimal + 1e-7;
            assert!(close, "{about:?} {modes}: {rms} {optimal}");
            // Turning a frame a little never brings it nearer to the rest shape.
            let total = |frame: &[V3], rest: &[V3]| -> f64 {
                let pairs = frame.iter().zip(rest);
                pairs
                    .flat_map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)))
                    .sum()
            };
            for (t, frame) in undone.iter().enumerate().step_by(7) {
                let center = Vector3::from(
                    mean(&vec![frame.clone()])
                        .iter()
                        .fold([0.0; 3], |s, p| [0, 1, 2].map(|k| s[k] + p[k] / 300.0)),
                );
                for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                    for angle in [-1e-2, 1e-2] {
                        let turn = UnitQuaternion::from_scaled_axis(axis * angle);
                        let turned: Vec<V3> = frame
                            .iter()
                            .map(|p| (turn * (Vector3::from(*p) - center) + center).into())
                            .collect();
                        assert!(total(&turned, rest) > total(frame, rest), "{about:?} {t}");
                    }
                }
            }
        }
    }
    // Without it the tumble takes modes of its own.
    let options = count(4);
    let without = refused_or_error(&made, &options);
    let with = pca_with_warnings(&made, &aligned(4, About::Mean))
        .0
        .error
        .rms_rel;
    assert!(without > 5.0 * with, "{without} {with}");
}

/// The error without alignment; infinite where q leaves its limit.
fn refused_or_error(made: &Made, options: &PcaOptions) -> f64 {
    use bdtree_build::basis::pca::pca_basis;
    use bdtree_build::progress::Silent;
    pca_basis(
        &made.mesh,
        &made.sequence,
        options,
        &Silent,
        &mut Vec::new(),
    )
    .map_or(f64::INFINITY, |found| found.error.rms_rel)
}

/// Mirrored frames: the best proper rotation is used, the rest is up to the modes.
#[test]
fn reflections_are_modes_not_motions() {
    let body = &cloth(80, 1)[0];
    let frames: Frames = (0..6)
        .map(|t| {
            let mirror = if t % 2 == 0 { 1.0 } else { -1.0 };
            body.iter().map(|p| [mirror * p[0], p[1], p[2]]).collect()
        })
        .collect();
    let made = make(frames.clone(), body, Precision::Double);
    let (found, _) = pca_with_warnings(&made, &aligned(3, About::Mean));
    assert!(found.basis.mode_count() > 0);
    assert!(found.error.max_rel < 1e-6, "{:?}", found.error);
    assert_error_is_true(&found, &frames, "mirrored");
}

/// A needle that turns, and one point that runs: the rotation about the needle stays as it is.
#[test]
fn needles_and_points_are_followed() {
    let needle: Vec<V3> = [-1.0, -0.2, 0.4, 1.3]
        .iter()
        .map(|&x| [x, 0.0, 0.0])
        .collect();
    let point: Vec<V3> = vec![[0.5, 0.25, 1.0]];
    for body in [needle, point] {
        let frames: Frames = (0..40).map(|t| moved(&body, t)).collect();
        let made = make(frames.clone(), &body, Precision::Double);
        for about in [About::Mean, About::Input] {
            let (found, _) = pca_with_warnings(&made, &aligned(3, about));
            assert_eq!(found.basis.mode_count(), 0, "{about:?}");
            assert!(found.error.max_rel < 1e-6, "{about:?}: {:?}", found.error);
            let motions = &found
                .basis
                .animation
                .as_ref()
                .expect("an animation")
                .motions;
            for pair in motions.windows(2) {
                let dot: f64 = (0..4)
                    .map(|k| pair[0].rotation[k] * pair[1].rotation[k])
                    .sum();
                assert!(dot > 0.9, "{dot}");
            }
        }
    }
}
