//! The main job: elastic modes of real and generated meshes, baked, verified, and queried beside
//! brute force, for q from 0 to displacements of half the bounding box.

use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::progress::Silent;
use bdtree_fixtures::compare::{check_pairs, check_pose};
use bdtree_fixtures::{bake, corpus, models, poses};
use bdtree_runtime::Transform;
use std::ops::ControlFlow;

/// Ten modes on a coarse lattice: what is tested here does not depend on its resolution.
fn check(name: &str, mesh: &RawMesh, rounds: usize) {
    let options = ElasticOptions {
        resolution: Some(14),
        ..ElasticOptions::default()
    };
    let (basis, _) = elastic_basis(mesh, &options, &Silent, &mut Vec::new())
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(basis.mode_count(), 10, "{name}");
    let model = bake::baked(mesh, &basis);
    let asset = model.asset();
    assert!(
        asset.verify(&mut |e| {
            println!("{name}: {e}");
            ControlFlow::Continue(())
        }),
        "{name}"
    );
    let mut rng = poses::rng(5);
    for share in [0.0, 0.1, 0.5] {
        let q = poses::random_q(asset, share, &mut rng);
        check_pose([*asset], &q, Transform::IDENTITY, 1, rounds);
        let placed = poses::random_transform(5.0, &mut rng);
        check_pose([*asset], &q, placed, 2, rounds);
    }
    check_pairs(asset, 6, 3, 0.3);
}

fn check_fixtures(names: &[&str]) {
    for name in names {
        let mesh = read_mesh(&models::path(name)).expect("fixture");
        check(name, &mesh, 3);
    }
}

fn check_corpus(test: &str, names: &[&str]) {
    for name in names {
        let Some(path) = corpus::path(test, &format!("meshes/{name}")) else {
            return;
        };
        check(name, &read_mesh(&path).expect("mesh"), 3);
    }
}

#[test]
fn fixtures_with_elastic_modes() {
    check_fixtures(&["chair", "fish", "curtain", "beam"]);
}

#[test]
fn shapes_with_elastic_modes() {
    check_fixtures(&["torus", "rod", "pieces", "far", "tiny"]);
}

#[test]
fn the_bridge_with_elastic_modes() {
    let mesh = read_mesh(&models::path("bridge")).expect("fixture");
    check("bridge", &mesh, 2);
}

#[test]
fn corpus_with_elastic_modes() {
    let names = [
        "chair_office.obj",
        "chair_sheen_welded.obj.gz",
        "chair_sheen_split.obj.gz",
        "bridge.obj.gz",
    ];
    check_corpus("corpus_with_elastic_modes", &names);
}

#[test]
fn corpus_animals_with_elastic_modes() {
    let names = ["fish.obj", "spot.obj.gz", "penguin_hr.obj.gz", "turtle.obj"];
    check_corpus("corpus_animals_with_elastic_modes", &names);
}
