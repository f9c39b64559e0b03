//! Frames of an animation: playback is what was baked, queries on it equal brute force, and every
//! rule that a file's frames break is found with its place.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::compare::{check_pose, kernels};
use bdtree_fixtures::{bake, mutate, poses};
use bdtree_format::{FrameRecord, ModeRecord, SectionKind};
use bdtree_runtime::{FormatError, Model, PoseError, SampleError, Transform, VertexId};

/// A small mesh away from 0, six modes, five frames that move it by up to a third of its size.
fn animated() -> (RawMesh, Basis) {
    let mut mesh = bake::bumpy_sphere(8, 3);
    for p in &mut mesh.positions {
        p[0] += 20.0;
    }
    let basis = bake::with_frames(bake::smooth_basis(&mesh, 6, 2), 5, 1.0, 11);
    (mesh, basis)
}

fn errors(bytes: &[u8]) -> Vec<FormatError> {
    let model = Model::from_bytes(bytes).expect("open");
    let mut errors = Vec::new();
    model.asset().verify(&mut |error| {
        errors.push(error);
        ControlFlow::Continue(())
    });
    errors
}

#[test]
fn queries_on_frames_equal_brute_force() {
    let (mesh, basis) = animated();
    check_frames(&mesh, &basis);
    // A frame that raises a mode's limit: it moves vertices by 500 diagonals.
    let mut far = basis;
    far.animation.as_mut().expect("an animation").q[2 * 6 + 3] = -1e4;
    check_frames(&mesh, &far);
}

fn check_frames(mesh: &RawMesh, basis: &Basis) {
    let model = bake::baked(mesh, basis);
    let asset = *model.asset();
    assert_eq!(errors(asset.bytes()), []);
    let mut rng = poses::rng(5);
    for k in 0..asset.frame_count() {
        let frame = asset.frame(k).expect("a frame");
        let place = poses::random_transform(3.0, &mut rng);
        let placed = place.after(frame.transform()).expect("a placement");
        check_pose(kernels(&asset), frame.q(), frame.transform(), k as u64, 12);
        check_pose(kernels(&asset), frame.q(), placed, k as u64, 12);
    }
}

/// R x by the quaternion product, not by a matrix.
fn turned([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let u = [x, y, z];
    let t = cross(u, v).map(|c| 2.0 * c);
    let s = cross(u, t);
    [0, 1, 2].map(|k| v[k] + w * t[k] + s[k])
}

#[test]
fn playback_is_what_was_baked() {
    let (mesh, basis) = animated();
    let model = bake::baked(&mesh, &basis);
    let asset = *model.asset();
    let animation = basis.animation.as_ref().expect("an animation");
    let place = poses::random_transform(3.0, &mut poses::rng(8));
    let m = basis.mode_count();
    for k in 0..animation.frame_count {
        let frame = asset.frame(k).expect("a frame");
        let motion = animation.motions[k];
        let placed = place.after(frame.transform()).expect("a placement");
        let mut memory = [0.0; 16];
        let mut memory2 = [0.0; 16];
        let pose = asset
            .pose(frame.q(), frame.transform(), &mut memory)
            .expect("pose");
        let pose2 = asset.pose(frame.q(), placed, &mut memory2).expect("pose");
        for i in 0..mesh.positions.len() {
            let p: [f64; 3] = [0, 1, 2].map(|c| {
                let moved = (0..m).map(|j| basis.field(j)[i][c] * animation.q[k * m + j]);
                mesh.positions[i][c] + moved.sum::<f64>()
            });
            let r = turned(motion.rotation, p);
            let expected = [0, 1, 2].map(|c| r[c] + motion.translation[c]);
            let vertex = VertexId(i as u32);
            let found = pose.deformed(vertex).expect("vertex");
            // f32 of position, six displacements and their q, all below 2; and f64 at 20.
            let tolerance = 20.0 * 2_f64.powi(-24) + 1e-13;
            let apart = (0..3)
                .map(|c| (found[c] - expected[c]).abs())
                .fold(0.0, f64::max);
            assert!(apart < tolerance, "frame {k}, vertex {i}: {apart}");
            // Composed placements: the same but for f64 rounding at 30 to 70 units.
            let r = turned(place.rotation, found);
            let expected = [0, 1, 2].map(|c| place.scale * r[c] + place.translation[c]);
            let found = pose2.deformed(vertex).expect("vertex");
            let apart = (0..3)
                .map(|c| (found[c] - expected[c]).abs())
                .fold(0.0, f64::max);
            assert!(apart < 1e-12, "frame {k}, vertex {i}: {apart}");
        }
    }
}

#[test]
fn placements_that_do_not_compose_are_refused() {
    let sound = Transform::IDENTITY;
    let scaled = |scale| Transform { scale, ..sound };
    let moved = |x| Transform {
        translation: [0.0, x, 0.0],
        ..sound
    };
    let turned = |w| Transform {
        rotation: [0.0, 0.0, 0.0, w],
        ..sound
    };
    for (outer, inner, error) in [
        (turned(1.01), sound, PoseError::Rotation),
        (sound, turned(f64::NAN), PoseError::Rotation),
        (moved(1e25), sound, PoseError::Translation),
        (sound, moved(f64::INFINITY), PoseError::Translation),
        (scaled(1e18), moved(1e18), PoseError::Translation),
        (scaled(1e18), scaled(1e18), PoseError::Scale),
        (scaled(0.0), sound, PoseError::Scale),
    ] {
        assert_eq!(outer.after(inner), Err(error), "{outer:?} {inner:?}");
    }
    assert_eq!(sound.after(sound), Ok(sound));
    // What is nearly unit is normalised.
    assert_eq!(turned(1.0005).after(turned(0.9995)), Ok(sound));
}

/// Each rule of SPEC 7.5, broken under a checksum that fits.
#[test]
fn broken_rules_are_found_with_their_place() {
    let (mesh, basis) = animated();
    let sound = bake::baked(&mesh, &basis).asset().bytes().to_vec();
    let limit_at = size_of::<bdtree_format::Header>() + 3 * size_of::<ModeRecord>();
    let limit = mutate::get_f32(&sound, limit_at);
    let place = |kind, offset: usize| mutate::section(&sound, kind).start + offset;
    let record = |k: usize, field: usize| place(SectionKind::FRAMES, k * 64 + field);
    let number = |k: usize, j: usize| place(SectionKind::FRAME_Q, (k * 6 + j) * 4);
    let (time, rotation, translation) = (
        offset_of!(FrameRecord, time_s),
        offset_of!(FrameRecord, rotation),
        offset_of!(FrameRecord, translation),
    );
    let wide = |at: usize, x: f64| (at, x.to_le_bytes().to_vec());
    let narrow = |at: usize, x: f32| (at, x.to_le_bytes().to_vec());
    let mut cases = Vec::new();
    for x in [0.01, -1.0, -0.5, f64::NAN, f64::INFINITY] {
        cases.push((wide(record(3, time), x), record(3, time), "SPEC 7.5: times"));
    }
    for x in [f64::NAN, 1.5, f64::NEG_INFINITY] {
        let at = record(2, rotation);
        cases.push((wide(at + 8, x), at, "SPEC 7.5: a rotation"));
    }
    for x in [f64::NAN, 1.3e24, f64::NEG_INFINITY] {
        let at = record(4, translation) + 16;
        cases.push((wide(at, x), at, "SPEC 7.5: a translation"));
    }
    for x in [f32::NAN, f32::INFINITY, f32::from_bits(1), -1e-40] {
        cases.push((narrow(number(1, 3), x), number(1, 3), "SPEC 5.1"));
    }
    for x in [limit.next_up(), -2.0 * limit, f32::MAX] {
        cases.push((narrow(number(4, 3), x), number(4, 3), "SPEC 7.5: q"));
    }
    for ((at, value), byte, rule) in cases {
        let mut bytes = sound.clone();
        mutate::put(&mut bytes, at, &value);
        mutate::repair(&mut bytes);
        let errors = errors(&bytes);
        assert_eq!(errors.len(), 1, "{errors:?}");
        let [error] = errors[..] else { return };
        let kind = match rule {
            "SPEC 5.1" | "SPEC 7.5: q" => SectionKind::FRAME_Q,
            _ => SectionKind::FRAMES,
        };
        assert_eq!((error.section, error.byte), (kind, byte as u64), "{error}");
        assert!(error.rule.starts_with(rule), "{error}");
    }
    // At the limit, and zeros of either sign, are fine.
    for x in [limit, -limit, -0.0] {
        let mut bytes = sound.clone();
        mutate::put(&mut bytes, number(4, 3), &x.to_le_bytes());
        mutate::repair(&mut bytes);
        assert_eq!(errors(&bytes), []);
    }
    // All times unknown; and only one known.
    let mut bytes = sound.clone();
    for k in 0..5 {
        mutate::put(&mut bytes, record(k, time), &(-1.0_f64).to_le_bytes());
    }
    mutate::repair(&mut bytes);
    assert_eq!(errors(&bytes), []);
    mutate::put(&mut bytes, record(2, time), &1.0_f64.to_le_bytes());
    mutate::repair(&mut bytes);
    let found = errors(&bytes);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].byte, record(2, time) as u64);
}

#[test]
fn samples_lie_on_and_between_frames() {
    let (mesh, basis) = animated();
    let model = bake::baked(&mesh, &basis);
    let asset = *model.asset();
    let count = asset.frame_count();
    let time = |k: usize| asset.frame(k).expect("a frame").time_s().expect("a time");
    assert_eq!(asset.duration_s(), Some(time(count - 1)));
    let mut q = vec![f32::NAN; asset.mode_count()];
    // At a frame exactly its numbers; before the first and after the last theirs.
    let mut cases: Vec<(f64, usize)> = (0..count).map(|k| (time(k), k)).collect();
    let ends = [-1.0, -f64::MIN_POSITIVE, f64::MIN].map(|t| (t, 0));
    cases.extend(ends);
    cases.extend([time(count - 1).next_up(), 1e9, f64::MAX].map(|t| (t, count - 1)));
    for (time_s, k) in cases {
        let frame = asset.frame(k).expect("a frame");
        let motion = asset.sample(time_s, &mut q).expect("a pose");
        assert_eq!(q, frame.q(), "{time_s}");
        let given = frame.transform();
        assert_eq!((motion.translation, motion.scale), (given.translation, 1.0));
        // Normalised anew, and −q is the same rotation.
        let same: f64 = (motion.rotation.iter().zip(&given.rotation))
            .map(|(a, b)| a * b)
            .sum();
        assert!((same - 1.0).abs() < 1e-12, "{same}");
    }
    for k in 0..count - 1 {
        let (a, b) = (asset.frame(k).expect("a"), asset.frame(k + 1).expect("b"));
        for share in [0.25, 0.5, 0.875] {
            let time_s = time(k) + share * (time(k + 1) - time(k));
            let motion = asset.sample(time_s, &mut q).expect("a pose");
            let mix = |a: f64, b: f64| a + share * (b - a);
            for (found, (a, b)) in q.iter().zip(a.q().iter().zip(b.q())) {
                let expected = mix(f64::from(*a), f64::from(*b));
                let size = f64::from(a.abs().max(b.abs()));
                assert!((f64::from(*found) - expected).abs() <= 1e-6 * size);
            }
            let (from, to) = (a.transform(), b.transform());
            for axis in 0..3 {
                let expected = mix(from.translation[axis], to.translation[axis]);
                assert!((motion.translation[axis] - expected).abs() < 1e-12);
            }
            let dot =
                |x: [f64; 4], y: [f64; 4]| -> f64 { x.iter().zip(&y).map(|(x, y)| x * y).sum() };
            assert!((dot(motion.rotation, motion.rotation) - 1.0).abs() < 1e-12);
            // On the shorter way, in the plane of both: nearer to each than they are to each other.
            let apart = dot(from.rotation, to.rotation).abs();
            let [near, far] = [from, to].map(|end| dot(motion.rotation, end.rotation).abs());
            assert!(near >= apart - 1e-12 && far >= apart - 1e-12);
            let between = near.min(1.0).acos() + far.min(1.0).acos();
            assert!((between - apart.min(1.0).acos()).abs() < 1e-6);
            // It is a pose of the asset.
            let mut memory = vec![0.0; asset.pose_len()];
            asset.pose(&q, motion, &mut memory).expect("a pose");
        }
    }
}

#[test]
fn what_cannot_be_sampled_is_refused() {
    let (mesh, basis) = animated();
    let model = bake::baked(&mesh, &basis);
    let mut q = [7.0; 6];
    for time_s in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let refused = model.asset().sample(time_s, &mut q);
        assert_eq!(refused, Err(SampleError::Time));
    }
    let refused = model.asset().sample_between([0, 1], f64::NAN, &mut q);
    assert_eq!(refused, Err(SampleError::Share));
    let count = model.asset().frame_count();
    let refused = model.asset().sample_between([0, count], 0.5, &mut q);
    assert_eq!(
        refused,
        Err(SampleError::NoFrame {
            index: count,
            count
        })
    );
    let (expected, found) = (6, 5);
    let refused = model.asset().sample(0.0, &mut q[..5]);
    assert_eq!(refused, Err(SampleError::ModeCount { expected, found }));
    let still = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 2));
    assert_eq!(still.asset().duration_s(), None);
    let refused = still.asset().sample(0.0, &mut q);
    assert_eq!(refused, Err(SampleError::NoFrames));
    let mut timeless = basis;
    timeless.animation.as_mut().expect("an animation").times_s = None;
    let timeless = bake::baked(&mesh, &timeless);
    assert_eq!(timeless.asset().duration_s(), None);
    let refused = timeless.asset().sample(0.0, &mut q);
    assert_eq!(refused, Err(SampleError::NoTimes));
    assert_eq!(q, [7.0; 6], "nothing is written");
}
