//! What advice rests on: errors against brute force, samples and questions.

use bdtree_build::advise::curve::Bench;
use bdtree_build::advise::errors::{Errors, Over};
use bdtree_build::advise::samples::{Bones, Samples, Source};
use bdtree_build::advise::works::{Contender, Works};
use bdtree_build::advise::{Goal, Subject, advise};
use bdtree_build::basis::{Basis, BasisError};
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::BakeSettings;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_fixtures::bake::{baked, baked_with, bumpy_sphere, rigid, smooth_basis, with_frames};
use bdtree_fixtures::models;
use bdtree_runtime::{Asset, BoneMatrices, JointMatrix, Model, SkeletonPose};
use rand::RngExt;

pub(crate) const MODES: usize = 7;
const FRAMES: usize = 9;

pub(crate) fn animated() -> (RawMesh, Basis) {
    let mesh = bumpy_sphere(8, 1);
    let mut basis = smooth_basis(&mesh, MODES, 2);
    // Later modes move less, as components do.
    for (j, mode) in basis.modes.iter_mut().enumerate() {
        mode.q_range = Some(0.5_f64.powi(j as i32));
    }
    let mut basis = with_frames(basis, FRAMES, 1.0, 3);
    let frames = basis.animation.as_mut().expect("frames");
    for q in frames.q.chunks_exact_mut(MODES) {
        for (j, q) in q.iter_mut().enumerate() {
            *q *= 0.5_f64.powi(j as i32);
        }
    }
    (mesh, basis)
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// How far vertex `i` is off at `q` without the modes from `first` on.
pub(crate) fn off(basis: &Basis, q: &[f64], first: usize, i: usize) -> f64 {
    let mut sum = [0.0; 3];
    for j in first..basis.mode_count() {
        let u = basis.field(j)[i];
        sum = [0, 1, 2].map(|k| sum[k] + u[k] * q[j]);
    }
    length(sum)
}

#[test]
fn errors_over_frames_are_those_of_brute_force() {
    let (mesh, basis) = animated();
    let (n, diagonal) = (mesh.positions.len(), mesh.diagonal());
    let errors = Errors::against_all(&basis, diagonal, Over::Frames, None);
    assert_eq!((errors.over, errors.mode_count()), (Over::Frames, MODES));
    let frames = &basis.animation.as_ref().expect("frames").q;
    for (k, error) in errors.of_first.iter().enumerate() {
        let (mut largest, mut sum) = (0.0_f64, 0.0);
        for q in frames.chunks_exact(MODES) {
            for i in 0..n {
                let off = off(&basis, q, k, i);
                largest = largest.max(off);
                sum += off * off;
            }
        }
        // Sums of a few products in another order.
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-13 * diagonal;
        assert!(near(error.max_rel * diagonal, largest), "{k}: {error:?}");
        let rms = (sum / (n * FRAMES) as f64).sqrt();
        assert!(near(error.rms_rel * diagonal, rms), "{k}: {error:?}");
        if k < MODES {
            let frame = error.frame.expect("a frame");
            let q = &frames[frame * MODES..(frame + 1) * MODES];
            assert!(
                near(off(&basis, q, k, error.vertex), largest),
                "{k}: {error:?}"
            );
        }
    }
    assert_eq!(errors.of_first[MODES].max_rel, 0.0);
}

#[test]
fn errors_over_ranges_hold_for_every_q_and_are_reached_vertex_by_vertex() {
    let (mesh, basis) = animated();
    let diagonal = mesh.diagonal();
    let errors = Errors::against_all(&basis, diagonal, Over::Ranges, None);
    assert_eq!(errors.over, Over::Ranges);
    let mut rng = bdtree_fixtures::poses::rng(5);
    for (k, error) in errors.of_first.iter().enumerate() {
        let reach = |i: usize| -> f64 {
            let modes = (k..MODES).map(|j| 0.5_f64.powi(j as i32) * length(basis.field(j)[i]));
            modes.sum()
        };
        let largest = (0..basis.vertex_count).map(reach).fold(0.0, f64::max);
        assert!((error.max_rel * diagonal - largest).abs() <= 1e-13 * diagonal);
        for _ in 0..20 {
            let q: Vec<f64> = (0..MODES)
                .map(|j| 0.5_f64.powi(j as i32) * rng.random_range(-1.0..=1.0))
                .collect();
            for i in 0..basis.vertex_count {
                assert!(off(&basis, &q, k, i) <= (error.max_rel + 1e-13) * diagonal);
            }
        }
    }
}

#[test]
fn what_all_modes_are_off_by_is_added() {
    let error = |max_rel| BasisError {
        max_rel,
        rms_rel: max_rel,
        frame: None,
        vertex: 0,
    };
    let mut errors = Errors::measured([0.4, 0.02, 0.03, 0.0].map(error).to_vec());
    assert_eq!(errors.fewest(0.025, 3), Some(1));
    assert_eq!(errors.fewest(0.01, 3), Some(3));
    assert_eq!(errors.fewest(0.01, 2), None);
    errors.own = Some(error(0.01));
    assert_eq!(errors.fewest(0.025, 3), Some(3));
    assert_eq!(errors.bound_rel(1), Some(0.03));
    assert_eq!(errors.bound_rel(4), None);
}

#[test]
fn samples_are_frames_mixtures_or_the_rest_pose() {
    let (mesh, basis) = animated();
    let model = baked(&mesh, &basis);
    let asset = model.asset();
    let samples = Samples::of(asset, 4).expect("samples");
    assert_eq!((samples.source, samples.count), (Source::Frames, 4));
    for (sample, frame) in [0, 2, 5, 8].into_iter().enumerate() {
        assert_eq!(samples.frame(sample), Some(frame));
        assert_eq!(samples.q(sample), asset.frame(frame).expect("frame").q());
    }
    let some = samples.select(&[1, 4]);
    assert_eq!(some.mode_count, 2);
    assert_eq!(some.q(3), [samples.q(3)[1], samples.q(3)[4]]);

    let still = Basis {
        animation: None,
        ..basis.clone()
    };
    let model = baked(&mesh, &still);
    let samples = Samples::of(model.asset(), 24).expect("samples");
    assert_eq!((samples.source, samples.count), (Source::Ranges, 24));
    for sample in 0..24 {
        let within = samples.q(sample).iter().zip(asset.modes());
        assert!(
            within
                .clone()
                .all(|(q, mode)| q.abs() <= mode.q_range.get())
        );
        assert!(within.into_iter().any(|(q, _)| *q != 0.0));
    }
    assert_eq!(samples, Samples::of(model.asset(), 24).expect("samples"));

    let samples = Samples::of(baked(&mesh, &rigid(&mesh)).asset(), 24).expect("samples");
    assert_eq!((samples.source, samples.count), (Source::Rest, 1));

    // A field that moves nothing has no use at any q.
    let mut zero = smooth_basis(&mesh, 2, 2);
    zero.fields.fill([0.0; 3]);
    let samples = Samples::of(baked(&mesh, &zero).asset(), 24).expect("samples");
    assert_eq!(
        (samples.source, samples.still.as_slice()),
        (Source::Rest, &[0, 1][..])
    );
}

/// A fixture's targets, if it has some, and skin.
pub(crate) fn skinned(name: &str) -> Recipe {
    let motion = Motion::MorphsElseSkin(Default::default(), Default::default());
    Recipe::of_surface(models::path(name), motion)
}

fn joints<'s>(asset: &Asset<'_>, samples: &'s Samples, sample: usize) -> &'s [JointMatrix] {
    match samples.joints(sample) {
        BoneMatrices::Joints(joints) if joints.len() == asset.joint_count() => joints,
        other => panic!("{other:?}"),
    }
}

#[test]
fn bones_are_posed_by_the_clips_or_turned() {
    let baked = |name| bdtree_build::bake(&skinned(name), &Silent).expect("bakes");
    let model = Model::from_bytes(&baked("skinned_tube.glb").bytes).expect("a file");
    let samples = Samples::of(model.asset(), 6).expect("samples");
    assert_eq!((samples.source, samples.count), (Source::Clips, 6));
    assert_eq!(samples.bones, Some(Bones::Clips));
    let mut pose = SkeletonPose::new(&model).expect("a skeleton");
    let skeleton = model.asset().skeleton().expect("a skeleton");
    // Two of each of three clips.
    for sample in 0..6 {
        let clip = skeleton.clip(sample / 2).expect("a clip");
        let time_s = [0.25, 0.75][sample % 2] * clip.duration_s();
        pose.play(sample / 2, time_s).expect("a time");
        assert_eq!(joints(model.asset(), &samples, sample), pose.joints());
        assert_eq!(samples.q(sample), pose.q());
    }
    // Fewer than clips: each its own.
    let few = Samples::of(model.asset(), 2).expect("samples");
    let middle = skeleton.clip(2).expect("a clip").duration_s() / 2.0;
    pose.play(2, middle).expect("a time");
    assert_eq!(joints(model.asset(), &few, 1), pose.joints());
    let without = samples.select(&[]);
    assert_eq!(
        joints(model.asset(), &without, 5),
        joints(model.asset(), &samples, 5)
    );

    let model = Model::from_bytes(&baked("skinned_12.glb").bytes).expect("a file");
    let samples = Samples::of(model.asset(), 24).expect("samples");
    assert_eq!((samples.source, samples.count), (Source::Rest, 24));
    assert_eq!(samples.bones, Some(Bones::Turns));
    assert_eq!(samples, Samples::of(model.asset(), 24).expect("samples"));
    let rest = SkeletonPose::new(&model).expect("a skeleton");
    assert_eq!(joints(model.asset(), &samples, 0), rest.joints());
    for sample in 1..24 {
        // About itself: a joint that hangs from nothing that is turned stays where it is.
        let (turned, still) = (joints(model.asset(), &samples, sample)[0], rest.joints()[0]);
        assert_eq!(turned.map(|row| row[3]), still.map(|row| row[3]));
        let cosine: f64 = (0..3)
            .map(|r| (0..3).map(|c| turned[r][c] * still[r][c]).sum::<f64>())
            .sum();
        let angle = (0.5 * (cosine - 1.0)).min(1.0).acos().to_degrees();
        assert!(angle > 0.0 && angle <= 20.0, "{angle}");
    }
}

#[test]
fn advice_on_a_character_is_of_its_clips() {
    let subject = Subject::of_recipe(&skinned("skinned_tube.glb"), None, &Silent);
    let subject = subject.expect("a subject");
    let bench = Bench::new(&subject, 6, 0.0, &Silent).expect("bench");
    let (whole, points) = bench
        .points(&[(&[], 4), (&[0], 2)], &Silent)
        .expect("points");
    assert_eq!(bench.samples.bones, Some(Bones::Clips));
    // The file is the one that a bake makes: skin, skeleton and clips.
    let baked = bdtree_build::bake(&skinned("skinned_tube.glb"), &Silent).expect("bakes");
    let provenance = baked.bytes.len() as f64;
    assert!((whole.bytes as f64 / provenance - 1.0).abs() < 0.02);
    // Without its mode clips move the skeleton alone.
    assert!(points[0].bytes < whole.bytes);
    // Leaves change no answer.
    let found = |k: usize| points[k].measured.works().map(|(_, work)| work.found);
    assert_eq!(found(1), whole.measured.works().map(|(_, work)| work.found));
    assert_ne!(found(0), found(1));
    let goal = Goal {
        samples: 6,
        seconds: 0.0,
        ..Goal::default()
    };
    let advice = advise(&subject, &goal, &Silent).expect("advice");
    let words = advice.sentences().join(" ");
    assert!(
        words.contains("These times are over 6 poses of the clips."),
        "{words}"
    );
    assert!(
        words.contains("Errors are those before bones carry the vertices."),
        "{words}"
    );
}

#[test]
fn questions_find_the_same_whatever_the_leaves() {
    let (mesh, basis) = animated();
    let settings = |leaf_size| BakeSettings {
        leaf_size: Some(leaf_size),
        ..BakeSettings::default()
    };
    let models = [1, 4, 9].map(|size| baked_with(&mesh, &basis, &settings(size)));
    let samples = Samples::of(models[0].asset(), 6).expect("samples");
    let works = Works::new(models[0].asset(), &samples).expect("questions");
    let measured = models.each_ref().map(|model| {
        let contender = Contender {
            asset: model.asset(),
            samples: &samples,
        };
        works.count(contender).expect("answers")
    });
    for work in measured[0].works() {
        assert!(work.1.found > 0 && work.1.seconds == 0.0, "{work:?}");
    }
    for other in &measured[1..] {
        for ((_, a), (_, b)) in measured[0].works().into_iter().zip(other.works()) {
            assert_eq!((a.questions, a.found), (b.questions, b.found));
        }
    }
    assert_ne!(
        measured[0], measured[2],
        "leaves of 1 and of 9 visit the same"
    );
}
