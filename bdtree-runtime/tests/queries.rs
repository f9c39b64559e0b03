//! Every query equals brute force over all deformed triangles: none missing, none too many, the
//! same numbers to the last bit.

use bdtree_build::basis::Basis;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::compare::{check_pairs, check_pose, kernels};
use bdtree_fixtures::{bake, corpus, poses};
use bdtree_runtime::Transform;

fn check_mesh(mesh: &RawMesh, mode_count: usize, seed: u64, rounds: usize) {
    check_basis(
        mesh,
        &bake::smooth_basis(mesh, mode_count, seed),
        seed,
        rounds,
    );
}

fn check_basis(mesh: &RawMesh, basis: &Basis, seed: u64, rounds: usize) {
    let model = bake::baked(mesh, basis);
    let asset = *model.asset();
    let mut errors = Vec::new();
    asset.verify(&mut |e| {
        errors.push(e);
        core::ops::ControlFlow::Continue(())
    });
    assert!(errors.is_empty(), "{}", errors[0]);
    let mut rng = poses::rng(seed);
    for share in [0.0, 0.05, 0.5] {
        let q = poses::random_q(&asset, share, &mut rng);
        let transform = poses::random_transform(10.0, &mut rng);
        check_pose(kernels(&asset), &q, transform, seed, rounds);
        check_pose(kernels(&asset), &q, Transform::IDENTITY, seed + 1, rounds);
    }
}

#[test]
fn queries_equal_brute_force_on_a_sphere() {
    check_mesh(&bake::bumpy_sphere(24, 1), 10, 7, 20);
    check_mesh(&bake::bumpy_sphere(8, 2), 1, 8, 20);
    check_mesh(&bake::bumpy_sphere(8, 3), 0, 9, 20);
    check_mesh(&bake::bumpy_sphere(6, 3), 40, 9, 20);
}

#[test]
fn queries_equal_brute_force_under_local_fields() {
    let mesh = bake::bumpy_sphere(20, 1);
    check_basis(&mesh, &bake::local_basis(&mesh, 16, 2), 7, 20);
    let model = bake::baked(&mesh, &bake::local_basis(&mesh, 100, 3));
    check_pairs(model.asset(), 3, 12, 0.4);
}

#[test]
fn queries_equal_brute_force_on_a_face() {
    let (mesh, basis) = bake::face_with_shapes();
    check_basis(&mesh, &basis, 5, 4);
}

#[test]
fn queries_equal_brute_force_at_hard_poses() {
    let mesh = bake::bumpy_sphere(10, 4);
    for basis in [
        bake::smooth_basis(&mesh, 7, 5),
        bake::local_basis(&mesh, 7, 5),
    ] {
        let model = bake::baked(&mesh, &basis);
        let asset = *model.asset();
        for (i, q) in poses::hard_qs(&asset).iter().enumerate() {
            check_pose(kernels(&asset), q, Transform::IDENTITY, i as u64, 10);
        }
    }
}

#[test]
fn queries_equal_brute_force_far_from_the_world_origin() {
    let mut mesh = bake::bumpy_sphere(10, 4);
    for p in &mut mesh.positions {
        *p = [p[0] + 1e6, p[1] - 2e6, p[2] + 3.0];
    }
    check_mesh(&mesh, 4, 11, 10);
    let mut tiny = bake::bumpy_sphere(10, 4);
    for p in &mut tiny.positions {
        *p = p.map(|c| c * 1e-6);
    }
    check_mesh(&tiny, 4, 12, 10);
}

#[test]
fn pairs_equal_brute_force() {
    let mesh = bake::bumpy_sphere(16, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 5));
    check_pairs(model.asset(), 3, 12, 0.4);
}

fn check_corpus(test: &str, meshes: &[(&str, usize)]) {
    for (name, rounds) in meshes {
        let Some(path) = corpus::path(test, &format!("meshes/{name}")) else {
            return;
        };
        let mesh = read_mesh(&path).expect("mesh");
        check_mesh(&mesh, 10, 21, *rounds);
        let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 5));
        check_pairs(model.asset(), 4, 3, 0.3);
    }
}

#[test]
fn corpus_queries_equal_brute_force() {
    let meshes = [
        // Rounds: each asks every query; a soak asks thousands.
        ("fish.obj", 3),
        ("spot.obj.gz", 3),
        ("chair_office.obj", 10),
        ("curtain.obj", 10),
        ("teapot.obj", 5),
    ];
    check_corpus("corpus_queries_equal_brute_force", &meshes);
}

#[test]
fn bridge_queries_equal_brute_force() {
    let test = "bridge_queries_equal_brute_force";
    check_corpus(test, &[("bridge.obj.gz", 3)]);
}

#[test]
fn castle_queries_equal_brute_force() {
    let test = "castle_queries_equal_brute_force";
    check_corpus(test, &[("castle_scene.obj.gz", 4)]);
}
