//! What advice rests on: errors against brute force, samples, questions, and what a file gives back.

use bdtree_build::advise::curve::Bench;
use bdtree_build::advise::errors::{Errors, Over};
use bdtree_build::advise::samples::{Bones, Samples, Source};
use bdtree_build::advise::works::{Contender, Works};
use bdtree_build::advise::{Goal, Subject, advise};
use bdtree_build::basis::{Basis, BasisError};
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields, bake_skinned};
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_build::skin::Weights;
use bdtree_fixtures::bake::{
    baked, baked_with, bumpy_sphere, local_basis, rigid, smooth_basis, with_frames,
};
use bdtree_fixtures::models;
use bdtree_format::SectionKind;
use bdtree_runtime::{Asset, BoneMatrices, JointMatrix, Model, SkeletonPose};
use rand::RngExt;

const MODES: usize = 7;
const FRAMES: usize = 9;

fn animated() -> (RawMesh, Basis) {
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
fn off(basis: &Basis, q: &[f64], first: usize, i: usize) -> f64 {
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
fn skinned(name: &str) -> Recipe {
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
        words.contains("Times are those of 6 poses of the clips."),
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

#[test]
fn a_file_gives_back_what_it_was_baked_from() {
    let mesh = bumpy_sphere(8, 1);
    for basis in [animated().1, local_basis(&mesh, 5, 4), rigid(&mesh)] {
        let settings = BakeSettings {
            leaf_size: Some(3),
            ..BakeSettings::default()
        };
        let provenance = Provenance {
            settings: [("leaf-size".to_string(), "3".to_string())].into(),
            ..Provenance::default()
        };
        let baked = bake_fields(&mesh, &basis, &settings, &provenance, &Silent).expect("bake");
        let model = Model::from_bytes(&baked.bytes).expect("a model");
        let subject = Subject::of_asset(model.asset()).expect("records");
        assert_eq!(subject.settings.leaf_size, Some(3));
        let Subject {
            mesh,
            basis,
            settings,
            provenance,
            ..
        } = subject;
        let again = bake_fields(&mesh, &basis, &settings, &provenance, &Silent).expect("bake");
        assert!(baked.bytes == again.bytes, "{} modes", basis.mode_count());
    }
}

/// The sections of a file but for what it says of its source.
fn sections(asset: &Asset<'_>) -> Vec<(SectionKind, Vec<u8>)> {
    let sections = asset.sections().iter();
    let sections = sections.filter(|section| section.kind != SectionKind::METADATA);
    sections
        .map(|section| {
            let start = section.offset.get() as usize;
            let bytes = &asset.bytes()[start..start + section.length.get() as usize];
            (section.kind, bytes.to_vec())
        })
        .collect()
}

/// Weights, bones, skeleton and clips with every kind of key; weights whose sum is not 1 stay as they are.
#[test]
fn a_file_with_a_skin_gives_back_what_it_was_baked_from() {
    for (name, weights) in [
        ("skinned_tube.glb", Weights::Normalise),
        ("skinned_12.glb", Weights::Normalise),
        ("skinned_12.glb", Weights::AsStored),
    ] {
        let mut recipe = skinned(name);
        recipe.settings.weights = weights;
        let first = bdtree_build::bake(&recipe, &Silent).expect("a file");
        let model = Model::from_bytes(&first.bytes).expect("a model");
        let subject = Subject::of_asset(model.asset()).expect("records");
        let skin = subject.skin.as_ref().expect("a skin");
        let again = bake_skinned(
            &subject.mesh,
            &subject.basis,
            skin,
            &subject.settings,
            &subject.provenance,
            &Silent,
        );
        let again = Model::from_bytes(&again.expect("a file").bytes).expect("a model");
        let (first, again) = (sections(model.asset()), sections(again.asset()));
        assert_eq!(first.len(), again.len(), "{name}");
        for (one, two) in first.iter().zip(&again) {
            assert!(one == two, "{name}, {weights}: {:?}", one.0);
        }
    }
}

#[test]
fn advice_on_a_file_is_for_the_fewest_modes_that_are_good_enough() {
    let (mesh, basis) = animated();
    let subject = Subject::of_asset(baked(&mesh, &basis).asset()).expect("records");
    assert_eq!(subject.errors.over, Over::Frames);
    let goal = Goal {
        max_error_rel: 0.01,
        leaf_sizes: Vec::new(),
        samples: 3,
        seconds: 0.0,
        curve_points: 4,
        ..Goal::default()
    };
    let advice = advise(&subject, &goal, &Silent).expect("advice");
    let kept = advice.chosen.modes.len();
    assert!(advice.is_met && kept > 0 && kept < MODES, "{kept}");
    let bounds = [kept - 1, kept].map(|k| subject.errors.of_first[k].max_rel);
    assert!(bounds[0] > 0.01 && bounds[1] <= 0.01);
    assert_eq!(advice.error_rel, bounds[1]);
    assert_eq!(advice.error_of_fewer_rel, Some(bounds[0]));
    assert!(advice.chosen.bytes < advice.all.bytes);
    let curve: Vec<usize> = advice.curve.iter().map(|point| point.modes.len()).collect();
    assert!(curve.len() <= 4 && curve.contains(&kept) && curve.contains(&MODES));
    let words = advice.sentences().join(" ");
    let start = format!("The first {kept} of {MODES} modes keep");
    assert!(words.starts_with(&start), "{words}");
    assert!(words.contains("of the bytes"), "{words}");
}

#[test]
fn a_line_and_a_triangle_are_judged_like_any_asset() {
    for positions in [
        [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    ] {
        let mesh = RawMesh {
            positions: positions.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..RawMesh::default()
        };
        for basis in [rigid(&mesh), smooth_basis(&mesh, 2, 1)] {
            let subject = Subject::of_asset(baked(&mesh, &basis).asset()).expect("records");
            let bench = Bench::new(&subject, 24, 0.0, &Silent).expect("bench");
            let modes: Vec<usize> = (0..basis.mode_count()).collect();
            let (whole, points) = bench.points(&[(&modes, 1)], &Silent).expect("points");
            assert_eq!((points.len(), whole.nodes), (1, 1));
            let advice = advise(&subject, &Goal::default(), &Silent).expect("advice");
            assert!(!advice.sentences().is_empty());
        }
    }
}

/// Shares in a text, as they are rounded there.
fn shares(text: &str) -> Vec<f64> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let pairs = words.windows(2).filter(|pair| pair[1].starts_with('%'));
    pairs
        .map(|pair| 0.01 * pair[0].parse::<f64>().expect("a number"))
        .collect()
}

/// Every figure of the sentence about modes, beside brute force: over the frames of a file that is its own source, and
/// of one that was made of frames which are no longer there.
#[test]
fn advice_about_modes_is_what_brute_force_finds() {
    let (mesh, basis) = animated();
    let diagonal = mesh.diagonal();
    let frames = basis.animation.clone().expect("frames").q;
    // The largest error of the first `kept` modes against all seven: the source.
    let against_source = |kept: usize| {
        let at = |q: &[f64]| {
            (0..basis.vertex_count)
                .map(|i| off(&basis, q, kept, i))
                .fold(0.0, f64::max)
        };
        frames.chunks_exact(MODES).map(at).fold(0.0, f64::max) / diagonal
    };
    let few = Goal {
        samples: 2,
        seconds: 0.0,
        leaf_sizes: Vec::new(),
        ..Goal::default()
    };
    let sentence =
        |basis: &Basis, own: Option<BasisError>, max_error_rel: f64| -> (usize, Vec<String>) {
            let provenance = Provenance {
                kind: "pca".to_string(),
                error: own,
                ..Provenance::default()
            };
            let settings = BakeSettings::default();
            let made = bake_fields(&mesh, basis, &settings, &provenance, &Silent).expect("a file");
            let model = Model::from_bytes(&made.bytes).expect("a file");
            let subject = Subject::of_asset(model.asset()).expect("a subject");
            let goal = Goal {
                max_error_rel,
                ..few.clone()
            };
            let advice = advise(&subject, &goal, &Silent).expect("advice");
            (advice.chosen.modes.len(), advice.sentences())
        };
    // Numbers of the file are f32: figures may differ in the seventh digit.
    let near =
        |share: f64, truth: f64| share >= truth * (1.0 - 1e-6) && share <= truth * 1.11 + 1e-9;

    // Its own source: what is said to be left is left, and what is needed is needed.
    let goal = 0.5 * (against_source(4) + against_source(5));
    let (kept, said) = sentence(&basis, None, goal);
    assert_eq!(kept, 5);
    assert!(
        said[0].contains("; one mode fewer would leave "),
        "{}",
        said[0]
    );
    let [kept, asked, fewer] = shares(&said[0])[..] else {
        panic!("{}", said[0]);
    };
    assert!(near(kept, against_source(5)) && near(asked, goal) && near(fewer, against_source(4)));

    // Five of the seven modes are in the file: their error against the source is known, that of four is not.
    let mut short = basis.clone();
    short.fields.truncate(5 * basis.vertex_count);
    short.modes.truncate(5);
    let animation = short.animation.as_mut().expect("frames");
    animation.q = frames
        .chunks_exact(MODES)
        .flat_map(|q| q[..5].to_vec())
        .collect();
    let own = BasisError {
        max_rel: against_source(5),
        rms_rel: against_source(5),
        frame: Some(0),
        vertex: 0,
    };
    let left_out = Errors::against_all(&short, diagonal, Over::Frames, None).of_first[4].max_rel;
    let bound = left_out + own.max_rel;
    assert!(bound > 1.01 * against_source(4), "the bound is one");
    let goal = 0.5 * (bound + against_source(4));
    let (kept, said) = sentence(&short, Some(own), goal);
    assert_eq!(kept, 5, "four cannot be promised");
    for word in ["needed", "would leave"] {
        assert!(!said[0].contains(word), "four are enough: {}", said[0]);
    }
    let [kept, asked, fewer] = shares(&said[0])[..] else {
        panic!("{}", said[0]);
    };
    assert!(
        near(kept, own.max_rel) && near(asked, goal) && near(fewer, bound),
        "{}",
        said[0]
    );
    assert!(
        said[1].contains("may find that fewer modes are enough"),
        "{}",
        said[1]
    );
}
