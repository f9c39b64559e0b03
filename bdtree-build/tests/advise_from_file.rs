//! What a file gives back of what it was baked from, and advice on it.

use bdtree_build::advise::curve::Bench;
use bdtree_build::advise::errors::{Errors, Over};
use bdtree_build::advise::{Goal, Subject, advise};
use bdtree_build::basis::{Basis, BasisError};
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields, bake_skinned};
use bdtree_build::progress::Silent;
use bdtree_build::skin::Weights;
use bdtree_fixtures::bake::{baked, bumpy_sphere, local_basis, rigid, smooth_basis};
use bdtree_format::SectionKind;
use bdtree_runtime::{Asset, Model};

use crate::advise_library::{MODES, animated, off, skinned};

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
