//! Interpolation and mixtures against numbers computed by hand.

use bdtree_format::{ChannelRecord, channel_path, interpolation};

use super::local::{LocalTransform, blend, blend_q};
use super::rotation::{slerp, unit};
use super::{SkeletonError, Track};

const HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-15, "{found:?}, not {expected:?}");
    }
}

fn channel(path: u32, kind: u32, target_count: u32, key_count: u32) -> ChannelRecord {
    ChannelRecord {
        target: 0,
        target_count,
        path,
        interpolation: kind,
        key_count,
        first_number: 1, // behind a number of another channel's
        reserved: 0,
    }
}

#[test]
fn rotations_go_along_the_shorter_arc() {
    let straight = [0.0, 0.0, 0.0, 1.0];
    // A quarter turn about z, and the same rotation with the other sign.
    let quarter = [0.0, 0.0, HALF, HALF];
    let other = quarter.map(|x| -x);
    let eighth = core::f64::consts::PI / 8.0;
    let expected = [0.0, 0.0, libm::sin(eighth), libm::cos(eighth)];
    near(&slerp(straight, quarter, 0.5), &expected);
    near(&slerp(straight, other, 0.5), &expected);
    // A third of 90 degrees: half an angle of 15.
    let angle = core::f64::consts::PI / 12.0;
    let expected = [0.0, 0.0, libm::sin(angle), libm::cos(angle)];
    near(&slerp(straight, quarter, 1.0 / 3.0), &expected);
    near(&slerp(straight, quarter, 0.0), &straight);
    near(&slerp(straight, quarter, 1.0), &quarter);
    // Opposite quaternions are one rotation; half a turn away the arc is any.
    near(&slerp(straight, straight.map(|x| -x), 0.25), &straight);
    let half_turn = slerp(straight, [1.0, 0.0, 0.0, 0.0], 0.5);
    near(&half_turn, &[HALF, 0.0, 0.0, HALF]);
    // Nearly the same.
    let turned = unit([1e-9, 0.0, 0.0, 1.0]);
    near(&slerp(straight, turned, 0.5), &[5e-10, 0.0, 0.0, 1.0]);
    near(&unit([0.0; 4]), &straight);
    near(&unit([f64::NAN; 4]), &straight);
}

#[test]
fn linear_keys_hold_outside_their_times() {
    let record = channel(channel_path::TRANSLATION, interpolation::LINEAR, 1, 2);
    let keys = [9.0, 1.0, 3.0, 0.0, 1.0, 2.0, 4.0, 5.0, -2.0];
    let track = Track::new(&record, &keys).expect("a track");
    let at = |time| track.vector(track.span(time, &mut 0));
    assert_eq!(at(-1e9), [0.0, 1.0, 2.0]);
    assert_eq!(at(1.0), [0.0, 1.0, 2.0]);
    assert_eq!(at(1.5), [1.0, 2.0, 1.0]);
    assert_eq!(at(3.0), [4.0, 5.0, -2.0]);
    assert_eq!(at(1e9), [4.0, 5.0, -2.0]);
    assert!(Track::new(&record, &keys[..8]).is_none());
    assert!(Track::new(&channel(9, 0, 1, 2), &keys).is_none());
    assert!(Track::new(&channel(0, 9, 1, 2), &keys).is_none());
    assert!(Track::new(&channel(0, 0, 1, 0), &keys).is_none());
    let endless = channel(
        channel_path::MODES,
        interpolation::CUBIC,
        u32::MAX,
        u32::MAX,
    );
    assert!(Track::new(&endless, &keys).is_none());
}

#[test]
fn steps_hold_until_the_next_key() {
    let record = channel(channel_path::MODES, interpolation::STEP, 2, 3);
    let keys = [9.0, 0.0, 1.0, 2.0, 10.0, 11.0, 20.0, 21.0, 30.0, 31.0];
    let track = Track::new(&record, &keys).expect("a track");
    let at = |time| [0, 1].map(|k| track.component(track.span(time, &mut 0), k));
    assert_eq!(at(-1.0), [10.0, 11.0]);
    assert_eq!(at(0.999), [10.0, 11.0]);
    assert_eq!(at(1.0), [20.0, 21.0]);
    assert_eq!(at(1.999), [20.0, 21.0]);
    assert_eq!(at(2.0), [30.0, 31.0]);
    assert_eq!(at(3.0), [30.0, 31.0]);
}

#[test]
fn a_wrong_guess_finds_the_same_keys() {
    let record = channel(channel_path::MODES, interpolation::LINEAR, 1, 3);
    let keys = [9.0, 0.0, 1.0, 2.0, 10.0, 20.0, 40.0];
    let track = Track::new(&record, &keys).expect("a track");
    let times = [-1.0, 0.0, 0.25, 1.0, 1.5, 2.0, 3.0];
    let expected = [10.0, 10.0, 12.5, 20.0, 30.0, 40.0, 40.0];
    for (time, expected) in times.into_iter().zip(expected) {
        for mut guess in 0..6 {
            let span = track.span(time, &mut guess);
            assert_eq!(track.component(span, 0), expected);
            let again = track.span(time, &mut guess);
            assert_eq!(track.component(again, 0), expected);
        }
    }
}

#[test]
fn splines_are_cubic() {
    let record = channel(channel_path::MODES, interpolation::CUBIC, 1, 2);
    // Times 1 and 3; in-tangent, value and out-tangent of each.
    let keys = [9.0, 1.0, 3.0, 7.0, 1.0, 0.5, -1.0, 2.0, 8.0];
    let track = Track::new(&record, &keys).expect("a track");
    let at = |time| track.component(track.span(time, &mut 0), 0);
    assert_eq!(at(0.0), 1.0);
    assert_eq!(at(1.0), 1.0);
    assert_eq!(at(3.0), 2.0);
    assert_eq!(at(4.0), 2.0);
    // t = 1/2, t_d = 2: (1 + 2) / 2 + 2 (0.5 + 1) / 8.
    assert_eq!(at(2.0), 1.875);
    // t = 1/4: 27/32 · 1 + 2 · 9/64 · 0.5 + 5/32 · 2 − 2 · 3/64 · (−1).
    assert_eq!(at(1.5), 0.84375 + 0.140625 + 0.3125 + 0.09375);

    let record = channel(channel_path::ROTATION, interpolation::CUBIC, 1, 2);
    let still = [0.0_f32; 4];
    let quarter = [0.0, 0.0, HALF as f32, HALF as f32];
    let mut keys = [0.0_f32; 27];
    keys[1..3].copy_from_slice(&[0.0, 1.0]);
    let values = [still, [0.0, 0.0, 0.0, 1.0], still, still, quarter, still];
    keys[3..].copy_from_slice(values.as_flattened());
    let track = Track::new(&record, &keys).expect("a track");
    let middle = track.rotation(track.span(0.5, &mut 0));
    let q = f64::from(HALF as f32);
    near(&middle, &unit([0.0, 0.0, q, 1.0 + q]));
}

#[test]
fn local_transforms_are_matrices() {
    // Scale, then a quarter turn about z, then the translation; the quaternion need not be of length 1.
    let local = LocalTransform::Parts {
        translation: [1.0, 2.0, 3.0],
        rotation: [0.0, 0.0, 1.001, 1.001],
        scale: [2.0, 3.0, -1.0],
    };
    let rows = local.to_matrix();
    near(&rows[0], &[0.0, -3.0, 0.0, 1.0]);
    near(&rows[1], &[2.0, 0.0, 0.0, 2.0]);
    near(&rows[2], &[0.0, 0.0, -1.0, 3.0]);
    assert_eq!(LocalTransform::Matrix(rows).to_matrix(), rows);
    assert_eq!(
        LocalTransform::default().to_matrix(),
        crate::joint::IDENTITY
    );
}

#[test]
fn poses_are_mixed() {
    let turned = LocalTransform::Parts {
        translation: [4.0, 0.0, -2.0],
        rotation: [0.0, 0.0, -HALF, -HALF],
        scale: [3.0, 1.0, -1.0],
    };
    let mut locals = [LocalTransform::IDENTITY; 2];
    blend(&mut locals, &[turned; 2], 0.5).expect("a mixture");
    let LocalTransform::Parts {
        translation,
        rotation,
        scale,
    } = locals[1]
    else {
        panic!("parts stay parts");
    };
    assert_eq!(translation, [2.0, 0.0, -1.0]);
    assert_eq!(scale, [2.0, 1.0, 0.0]);
    let eighth = core::f64::consts::PI / 8.0;
    near(&rotation, &[0.0, 0.0, libm::sin(eighth), libm::cos(eighth)]);
    let matrix = LocalTransform::Matrix(crate::joint::IDENTITY);
    assert_eq!(turned.blended(&matrix, 0.25), turned);
    assert_eq!(turned.blended(&matrix, 0.75), matrix);
    assert_eq!(matrix.blended(&matrix, 0.3), matrix);

    let mut q = [0.0, 1.0];
    blend_q(&mut q, &[1.0, 3.0], 0.25).expect("a mixture");
    assert_eq!(q, [0.25, 1.5]);
    assert_eq!(
        blend(&mut locals, &[turned], 0.5),
        Err(SkeletonError::Length {
            what: "local transforms",
            expected: 2,
            found: 1
        })
    );
    assert_eq!(
        blend_q(&mut q, &[1.0, 3.0], f64::NAN),
        Err(SkeletonError::Weight)
    );
}
