//! What a step keeps changes no answer: every query with and without, over poses that follow each
//! other, equals brute force.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::compare::cached::check_cached;
use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::Transform;

fn check(mesh: &RawMesh, basis: &Basis, seed: u64, rounds: usize) {
    let model = bake::baked(mesh, basis);
    let asset = *model.asset();
    let mut rng = poses::rng(seed);
    let far = Transform {
        translation: [1e7, -2e6, 3.0],
        ..poses::random_transform(1.0, &mut rng)
    };
    let at = [
        (poses::random_q(&asset, 0.0, &mut rng), Transform::IDENTITY),
        (
            poses::random_q(&asset, 0.1, &mut rng),
            poses::random_transform(3.0, &mut rng),
        ),
        (poses::random_q(&asset, 0.4, &mut rng), far),
    ];
    for asset in kernels(&asset) {
        check_cached(&asset, &at, seed, rounds);
    }
}

#[test]
fn kept_nodes_and_leaves_change_no_answer() {
    let mesh = bake::bumpy_sphere(12, 1);
    check(&mesh, &bake::smooth_basis(&mesh, 10, 2), 3, 4);
    check(&mesh, &bake::local_basis(&mesh, 16, 2), 4, 3);
}

#[test]
fn triangles_without_area_are_missed_by_rays_of_every_kind() {
    let mut mesh = bake::bumpy_sphere(7, 1);
    let given = mesh.triangles.clone();
    for [a, b, c] in given {
        mesh.triangles.extend([[a, b, b], [c, c, c], [a, b, c]]);
    }
    check(&mesh, &bake::smooth_basis(&mesh, 3, 2), 5, 3);
}
