//! The animation in the file, and the metadata that states errors.

use std::ops::ControlFlow;

use crate::tree_support::*;
use bdtree_build::basis::{Animation, Basis, BasisError, RigidMotion};
use bdtree_build::error::BakeError;
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Baked, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_format::{ErrorMetadata, Metadata};
use bdtree_runtime::{Model, Transform};

/// Four frames of two modes, with times and turns.
fn animated(mesh: &RawMesh) -> Basis {
    let mut basis = waves(mesh, 2);
    let turn = |rotation, translation| RigidMotion {
        rotation,
        translation,
    };
    basis.animation = Some(Animation {
        frame_count: 4,
        times_s: Some(vec![0.0, 0.25, 0.25, 1.5]),
        // 1e-40 is subnormal in f32, 0.1 is no f32.
        q: vec![0.0, 0.5, 1e-40, -0.1, -2.0, 0.125, 0.75, -1e-60],
        motions: vec![
            RigidMotion::IDENTITY,
            turn([0.6, 0.0, 0.0, 0.8], [1.0, -2.0, 0.5]),
            turn([0.0, 0.6, 0.8, 0.0], [0.0; 3]),
            turn([0.5; 4], [1e6, 0.1, -1e-9]),
        ],
    });
    basis
}

fn sound(bytes: &[u8]) -> Model {
    let model = Model::from_bytes(bytes).expect("open");
    let report = &mut |error| -> ControlFlow<()> { panic!("{error}") };
    model.asset().verify(report);
    model
}

fn refused(mesh: &RawMesh, basis: &Basis) -> BakeError {
    bake_fields(
        mesh,
        basis,
        &BakeSettings::default(),
        &Provenance::default(),
        &Silent,
    )
    .expect_err("a refusal")
}

#[test]
fn frames_are_stored_as_they_are() {
    let mesh = grid(6);
    let basis = animated(&mesh);
    let baked = bake_with(&mesh, &basis, &BakeSettings::default());
    assert_eq!(baked.report.frames, Some(4));
    let model = sound(&baked.bytes);
    let asset = model.asset();
    let animation = basis.animation.expect("an animation");
    assert_eq!(asset.frame_count(), 4);
    assert!(asset.frame(4).is_none() && asset.frame(usize::MAX).is_none());
    for k in 0..4 {
        let frame = asset.frame(k).expect("a frame");
        let motion = animation.motions[k];
        assert_eq!(frame.time_s(), animation.times_s.as_ref().map(|t| t[k]));
        assert_eq!(
            frame.transform(),
            Transform {
                rotation: motion.rotation,
                translation: motion.translation,
                scale: 1.0
            }
        );
        for (stored, q) in frame.q().iter().zip(&animation.q[2 * k..]) {
            let nearest = *q as f32;
            let expected = if nearest.is_subnormal() { 0.0 } else { nearest };
            assert_eq!(stored.to_bits(), (expected + 0.0).to_bits());
        }
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(frame.q(), frame.transform(), &mut memory);
        pose.expect("playable");
    }
}

#[test]
fn what_the_source_does_not_say_is_unknown() {
    let mesh = grid(4);
    let mut basis = animated(&mesh);
    let animation = basis.animation.as_mut().expect("an animation");
    animation.times_s = None;
    animation.motions.clear();
    let model = sound(&bake_with(&mesh, &basis, &BakeSettings::default()).bytes);
    let asset = model.asset();
    for k in 0..4 {
        let frame = asset.frame(k).expect("a frame");
        assert_eq!(frame.time_s(), None);
        assert_eq!(frame.transform(), Transform::IDENTITY);
    }
    // No modes: only the rigid motions are left.
    let rigid = Basis {
        animation: Some(Animation {
            frame_count: 2,
            motions: vec![RigidMotion::IDENTITY; 2],
            ..Animation::default()
        }),
        ..Basis::default()
    };
    let model = sound(&bake_with(&mesh, &rigid, &BakeSettings::default()).bytes);
    let asset = model.asset();
    assert_eq!(asset.frame_count(), 2);
    assert_eq!(asset.frame(1).map(|f| f.q().len()), Some(0));
    // No animation.
    let baked = bake_with(&mesh, &Basis::default(), &BakeSettings::default());
    assert_eq!(baked.report.frames, None);
    assert_eq!(sound(&baked.bytes).asset().frame_count(), 0);
}

/// q_limit by itself is 100 to 200 diagonals; a frame beyond it raises it to the next power of two.
#[test]
fn every_frame_is_playable() {
    let mesh = grid(4);
    let own = |basis: &Basis| -> f32 {
        let baked = bake_with(&mesh, basis, &BakeSettings::default());
        Decoded::new(&baked.bytes).modes[1].q_limit.get()
    };
    let mut basis = animated(&mesh);
    let limit = own(&basis);
    for (q, expected) in [
        (limit, limit),
        (limit.next_up(), 2.0 * limit),
        (-5.0 * limit, 8.0 * limit),
        (1e12, 2_f32.powi(40)),
    ] {
        let animation = basis.animation.as_mut().expect("an animation");
        animation.q[5] = f64::from(q);
        basis.modes[1].q_range = Some(f64::from(q.abs()));
        let Baked { bytes, report } = bake_with(&mesh, &basis, &BakeSettings::default());
        let model = sound(&bytes);
        let asset = model.asset();
        assert_eq!(asset.modes()[1].q_limit.get(), expected);
        assert_eq!(asset.modes()[1].q_range.get(), q.abs());
        let frame = asset.frame(2).expect("a frame");
        assert_eq!(frame.q()[1], q);
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(frame.q(), frame.transform(), &mut memory);
        pose.expect("playable");
        let warned = report
            .warnings
            .iter()
            .any(|w| w.starts_with("mode 1: limit"));
        assert_eq!(warned, expected > limit, "{:?}", report.warnings);
    }
    // A field that is zero has no length to compare with.
    let count = mesh.positions.len();
    basis.fields[count..].fill([0.0; 3]);
    basis.animation.as_mut().expect("an animation").q[5] = 2_f64.powi(70);
    assert_eq!(own(&basis), 2_f32.powi(70));
    // A range alone raises nothing.
    let mut ranged = waves(&mesh, 2);
    ranged.modes[1].q_range = Some(1e9);
    assert_eq!(own(&ranged), limit);
}

#[test]
fn bad_frames_are_refused_with_their_place() {
    let mesh = grid(3);
    type Change = fn(&mut Animation);
    let cases: [(Change, &str); 16] = [
        (|a| a.frame_count = 0, "animation: it has no frames"),
        (
            |a| a.q.truncate(7),
            "animation: 7 numbers q for 4 frames of 2 modes",
        ),
        (|a| a.frame_count = 3, "animation: 8 numbers q for 3 frames"),
        (
            |a| a.frame_count = usize::MAX,
            "animation: 8 numbers q for ",
        ),
        (
            |a| a.times_s = Some(vec![0.0]),
            "animation: 1 times for 4 frames",
        ),
        (
            |a| a.motions.truncate(1),
            "animation: 1 rigid motions for 4 frames",
        ),
        (
            |a| a.times_s = Some(vec![0.0, 2.0, 1.0, 3.0]),
            "frame 2: time 1 s lies before 2 s",
        ),
        (
            |a| a.times_s = Some(vec![-1.0; 4]),
            "frame 0: time -1 s is not a number from 0 on",
        ),
        (
            |a| a.times_s = Some(vec![0.0, f64::NAN, 1.0, f64::INFINITY]),
            "frame 1: time NaN s",
        ),
        (
            |a| a.motions[3].rotation = [0.0, 0.0, 0.0, 1.000_001],
            "frame 3: rotation ",
        ),
        (
            |a| a.motions[0].rotation = [f64::NAN, 0.0, 0.0, 1.0],
            "frame 0: rotation ",
        ),
        (
            |a| a.motions[1].translation[2] = 1.3e24,
            "frame 1: translation ",
        ),
        (
            |a| a.q[5] = f64::NAN,
            "frame 2, mode 1: q NaN is not finite",
        ),
        (
            |a| a.q[6] = -1e40,
            "frame 3, mode 0: q -1e40 is too large for f32",
        ),
        (
            |a| a.q[6] = 1e38,
            "frame 3, mode 0: q 1e38 is beyond the largest limit",
        ),
        (
            |a| a.q[2] = 1e25,
            "frame 1, mode 0: q 1e25 moves a vertex by ",
        ),
    ];
    for (change, text) in cases {
        let mut basis = animated(&mesh);
        change(basis.animation.as_mut().expect("an animation"));
        let error = refused(&mesh, &basis);
        assert!(error.to_string().starts_with(text), "{text}: {error}");
        assert!(error.problems.iter().all(|p| p.stage == "encode"));
    }
    // All of them, not the first.
    let mut basis = animated(&mesh);
    let animation = basis.animation.as_mut().expect("an animation");
    animation.q.fill(f64::INFINITY);
    animation.times_s = Some(vec![3.0, 2.0, 1.0, 4.0]);
    assert_eq!(refused(&mesh, &basis).problems.len(), 10);
    let mut basis = animated(&mesh);
    basis.modes[1].default_q = Some(f64::INFINITY);
    let error = refused(&mesh, &basis).to_string();
    assert!(error.starts_with("mode 1: default weight inf"), "{error}");
}

#[test]
fn the_metadata_states_errors_and_weights() {
    let mesh = grid(3);
    let mut basis = animated(&mesh);
    basis.modes[1].default_q = Some(0.25);
    let error = BasisError {
        max_rel: 0.125,
        rms_rel: 0.01,
        frame: Some(3),
        vertex: 7,
    };
    let with_error = |error| {
        let provenance = Provenance {
            error: Some(error),
            ..Provenance::default()
        };
        bake_fields(
            &mesh,
            &basis,
            &BakeSettings::default(),
            &provenance,
            &Silent,
        )
    };
    for frame in [Some(3), None] {
        let baked = with_error(BasisError { frame, ..error }).expect("a sound error");
        let model = sound(&baked.bytes);
        let metadata = Metadata::from_bytes(model.asset().metadata()).expect("metadata");
        assert_eq!(
            metadata.basis_error_rel,
            Some(ErrorMetadata {
                max: 0.125,
                rms: 0.01,
                frame: frame.map(|f| f as u64),
                vertex: Some(7),
            })
        );
        let weights: Vec<Option<f64>> = metadata.modes.iter().map(|m| m.default_q).collect();
        assert_eq!(weights, [None, Some(0.25)]);
        let json = serde_json::to_value(&baked.report).expect("JSON");
        assert_eq!(json["frames"], 4);
        assert_eq!(json["basis_error_rel"]["max"], 0.125);
    }
    for bad in [
        BasisError {
            vertex: 16,
            ..error
        },
        BasisError {
            max_rel: f64::NAN,
            ..error
        },
        BasisError {
            rms_rel: -0.5,
            ..error
        },
    ] {
        let text = with_error(bad).expect_err("a refusal").to_string();
        assert!(text.starts_with("error of the basis: "), "{text}");
    }
}
