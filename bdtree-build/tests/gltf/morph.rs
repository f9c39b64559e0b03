//! Morph targets as a basis, and what is lost with those left out.

use bdtree_build::basis::dropped::{Keep, keep_fields};
use bdtree_build::basis::morph::{MorphBasis, morph_basis};
use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::input::{RawClip, RawMesh, RawModel, RawMorphs, RawTarget};
use bdtree_build::wrap;
use bdtree_fixtures::models;
use bdtree_fixtures::models::gltf::{Weights, glb};
use bdtree_fixtures::poses::rng;
use rand::RngExt;

use crate::support::read;

fn model() -> RawModel {
    read(&models::content("morph_nodes.glb")).expect("sound")
}

fn morph(model: &RawModel, keep: Keep) -> (MorphBasis, Vec<String>) {
    let mut warnings = Vec::new();
    let basis = morph_basis(&model.mesh, &model.morphs, keep, 1 << 30, &mut warnings);
    (basis.unwrap_or_else(|e| panic!("{e}")), warnings)
}

fn diagonal(mesh: &RawMesh) -> f64 {
    let mut square = 0.0;
    for k in 0..3 {
        let all = mesh.positions.iter().map(|p| p[k]);
        let (low, high) = (
            all.clone().fold(f64::INFINITY, f64::min),
            all.fold(f64::NEG_INFINITY, f64::max),
        );
        square += (high - low) * (high - low);
    }
    square.sqrt()
}

#[test]
fn weights_become_q() {
    let model = model();
    let (morph, warnings) = morph(&model, Keep::All);
    assert_eq!(warnings, [""; 0]);
    assert_eq!(morph.default_weights, [0.25, 0.0, 0.0, 0.5]);
    let ranges: Vec<_> = morph.basis.modes.iter().map(|m| m.q_range).collect();
    // The largest of 1, the default and the clip: target 1 reaches 1.5.
    assert_eq!(ranges, [Some(1.0), Some(1.5), Some(1.0), Some(1.0)]);
    let animation = morph.basis.animation.as_ref().expect("an animation");
    let clip = model.morphs.clip.as_ref().expect("a clip");
    assert_eq!(animation.frame_count, 5);
    assert_eq!(animation.times_s.as_ref(), Some(&clip.times_s));
    assert_eq!(animation.q, clip.weights);
    assert!(morph.error.max_rel < 1e-7, "{:?}", morph.error);
    // What is stored is base + weight × target, to rounding of f32.
    let stored = wrap::store(&model.mesh, &morph.basis, &mut Vec::new()).expect("stored");
    assert_eq!((stored.origin, stored.unit_exponent), ([0.0; 3], 0));
    for (j, target) in model.morphs.targets.iter().enumerate() {
        let mut q = vec![0.0; 4];
        q[j] = 1.0;
        let mut expected = model.mesh.positions.clone();
        for (i, u) in &target.displacements {
            for k in 0..3 {
                expected[*i as usize][k] += u[k];
            }
        }
        for (a, b) in stored.deform(&q).iter().zip(&expected) {
            // Coordinates below 16, two roundings to f32.
            assert!((0..3).all(|k| (a[k] - b[k]).abs() <= 2.0 * 8.0 * f64::from(f32::EPSILON)));
        }
    }
}

#[test]
fn empty_targets_are_kept_with_a_warning_or_dropped_first() {
    let mut model = model();
    model.morphs.targets[2].displacements.clear();
    let (all, warnings) = morph(&model, Keep::All);
    assert_eq!(all.basis.mode_count(), 4);
    assert_eq!(warnings, [": mode 2 \"right/taper\" is zero everywhere"]);
    let auto = Keep::Auto {
        max_error_rel: 1e-6,
    };
    let (fewer, warnings) = morph(&model, auto);
    let names: Vec<_> = fewer
        .basis
        .modes
        .iter()
        .filter_map(|m| m.name.as_deref())
        .collect();
    assert_eq!(names, ["left/taper", "left/pull", "right/pull"]);
    assert_eq!(fewer.default_weights, [0.25, 0.0, 0.5]);
    assert_eq!(warnings, [""; 0]);
    let animation = fewer.basis.animation.expect("an animation");
    let clip = model.morphs.clip.expect("a clip");
    let kept: Vec<f64> = clip
        .weights
        .chunks(4)
        .flat_map(|w| [w[0], w[1], w[3]])
        .collect();
    assert_eq!(animation.q, kept);
}

/// The distance between all targets and those kept, at many weights within the ranges: never above
/// the stated error, and reached where all dropped targets push the same way.
#[test]
fn the_stated_error_is_what_dropped_targets_can_move() {
    let mesh = models::mesh("sheet").expect("a mesh");
    let shapes = models::fields::local_fields(&mesh, 12, 3);
    let raw = RawMesh {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
        ..RawMesh::default()
    };
    let targets = shapes.iter().enumerate().map(|(j, field)| RawTarget {
        default_weight: if j == 7 { 2.0 } else { 0.0 },
        displacements: (0..)
            .zip(field.iter().copied())
            .filter(|(_, u)| *u != [0.0; 3])
            .collect(),
        ..RawTarget::default()
    });
    let model = RawModel {
        mesh: raw,
        morphs: RawMorphs {
            targets: targets.collect(),
            clip: Some(RawClip {
                name: String::new(),
                times_s: vec![0.0, 1.0],
                weights: (0..24).map(|i| if i == 15 { -3.0 } else { 0.5 }).collect(),
            }),
        },
        skin: None,
    };
    let diagonal = diagonal(&model.mesh);
    let mut rng = rng(1);
    let mut last = f64::INFINITY;
    for count in 0..=12 {
        let (few, _) = morph(&model, Keep::First(count));
        assert_eq!(few.basis.mode_count(), count);
        assert!(few.error.max_rel <= last, "more targets, less error");
        last = few.error.max_rel;
        let stored = wrap::store(&model.mesh, &few.basis, &mut Vec::new()).expect("stored");
        let range = |j: usize| match j {
            7 => 2.0,
            3 => 3.0,
            _ => 1.0,
        };
        let (mut worst, mut reached) = (0.0_f64, 0.0_f64);
        for _ in 0..20 {
            let w: Vec<f64> = (0..12)
                .map(|j| range(j) * rng.random_range(-1.0..1.0))
                .collect();
            let near = stored.deform(&w[..count]);
            for i in 0..near.len() {
                let truth = [0, 1, 2].map(|k| {
                    mesh.positions[i][k] + (0..12).map(|j| w[j] * shapes[j][i][k]).sum::<f64>()
                });
                let off = (0..3)
                    .map(|k| (near[i][k] - truth[k]).powi(2))
                    .sum::<f64>()
                    .sqrt();
                worst = worst.max(off / diagonal);
            }
        }
        for i in 0..mesh.positions.len() {
            let norm = |u: [f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
            let sum: f64 = (count..12).map(|j| range(j) * norm(shapes[j][i])).sum();
            reached = reached.max(sum / diagonal);
        }
        // Rounding of f32, and of the sums here.
        assert!(
            worst <= few.error.max_rel + 1e-12,
            "{count}: {worst} {:?}",
            few.error
        );
        assert!(
            (few.error.max_rel - reached).abs() <= 1e-6,
            "{count}: {reached} {:?}",
            few.error
        );
        assert!(few.error.rms_rel <= few.error.max_rel);
    }
    let mut kept = 13;
    let auto = |limit| Keep::Auto {
        max_error_rel: limit,
    };
    for limit in [0.0, 1e-9] {
        let basis = morph_basis(
            &model.mesh,
            &model.morphs,
            auto(limit),
            1 << 30,
            &mut Vec::new(),
        );
        let text = basis.expect_err("below rounding").to_string();
        assert!(text.contains("by rounding to f32"), "{text}");
    }
    for limit in [1e-6, 0.01, 0.05, 0.1, 0.2, 0.5, 10.0] {
        let (few, warnings) = morph(&model, auto(limit));
        let count = few.basis.mode_count();
        assert!(count <= kept, "a looser limit, fewer targets");
        kept = count;
        assert!(warnings.is_empty(), "{limit}: {warnings:?}");
        assert!(few.error.max_rel <= limit, "{limit}: {:?}", few.error);
    }
    assert_eq!(kept, 0);
}

#[test]
fn given_fields_are_dropped_by_the_same_rule() {
    let mesh = RawMesh {
        positions: vec![[0.0; 3], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        name: "given".into(),
        ..RawMesh::default()
    };
    let field = |i: usize, x: f64| {
        let mut field = [[0.0; 3]; 3];
        field[i] = [0.0, 0.0, x];
        field
    };
    let basis = Basis {
        vertex_count: 3,
        fields: [field(0, 1.0), field(1, 8.0), field(2, 0.5)].concat(),
        modes: vec![
            BasisMode {
                q_range: Some(2.0),
                ..BasisMode::default()
            },
            BasisMode::default(),
            BasisMode {
                q_range: Some(0.25),
                ..BasisMode::default()
            },
        ],
        animation: None,
    };
    let keep = |keep| keep_fields(&mesh, basis.clone(), keep);
    // The diagonal is 5: reaches are 2, 0.25 (5 % of it) and 0.125.
    let one = keep(Keep::First(1)).expect("sound");
    assert_eq!((one.error.max_rel, one.error.vertex), (0.05, 1));
    let square: f64 = 0.25 * 0.25 + 0.125 * 0.125;
    assert!((one.error.rms_rel - (square / 3.0).sqrt() / 5.0).abs() < 1e-15);
    for (limit, fields) in [
        (0.024, vec![0, 1, 2]),
        (0.025, vec![0, 1]),
        (0.05, vec![0]),
        (0.4, vec![]),
    ] {
        let kept = keep(Keep::Auto {
            max_error_rel: limit,
        })
        .expect("sound");
        assert_eq!(kept.fields, fields, "{limit}");
    }
    assert_eq!(
        keep(Keep::First(4)),
        keep(Keep::All),
        "no more than there are"
    );
    let text = |k| keep(k).expect_err("refused").to_string();
    for limit in [-1.0, f64::NAN, f64::INFINITY] {
        let text = text(Keep::Auto {
            max_error_rel: limit,
        });
        assert!(text.ends_with("is not a number of at least 0"), "{text}");
    }
}

#[test]
fn the_writer_of_faces_is_read_back() {
    let mesh = models::mesh("icosphere").expect("a mesh");
    let fields = models::fields::local_fields(&mesh, 3, 8);
    let everywhere = models::fields::smooth_fields(&mesh, 1, 8).remove(0);
    let targets = [
        ("one", fields[0].as_slice()),
        ("two", &fields[1]),
        ("three", &fields[2]),
        ("all", &everywhere),
    ];
    let clip = Weights {
        name: "nod".into(),
        times_s: vec![0.0, 0.25],
        weights: vec![0.0, 0.5, 1.0, 0.0, 1.0, 0.5, 0.0, 0.75],
    };
    let file = glb(&mesh, &targets, &[0.0, 0.5, 0.0, 0.25], Some(&clip));
    let model = read(&file).expect("sound");
    let round = |p: &[f64; 3]| p.map(|x| f64::from(x as f32));
    let positions: Vec<_> = mesh.positions.iter().map(round).collect();
    assert_eq!(model.mesh.positions, positions);
    assert_eq!(model.mesh.triangles, mesh.triangles);
    for (target, (name, field)) in model.morphs.targets.iter().zip(targets) {
        assert_eq!(target.name.as_deref(), Some(name));
        let moves: Vec<_> = (0..)
            .zip(field.iter().map(round))
            .filter(|(_, u)| *u != [0.0; 3])
            .collect();
        assert_eq!(target.displacements, moves);
    }
    let read = model.morphs.clip.expect("a clip");
    assert_eq!(
        (read.name, read.times_s, read.weights),
        (clip.name, clip.times_s, clip.weights)
    );
}
