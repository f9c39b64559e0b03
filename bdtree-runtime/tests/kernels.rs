//! Node bounds have the same bits with every kernel: sums over modes are of whole numbers, and what
//! follows is rounded alike.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::studies::pose_within;
use bdtree_runtime::{Kernel, Pose, Transform};

/// The bits of all spheres of an asset at a pose; NaN as one of them.
fn bits(pose: &Pose<'_>) -> Vec<u32> {
    let rows = (0..pose.asset().node_count() as u32).flat_map(|node| {
        let spheres = pose.node_spheres(node).expect("node");
        let [x, y, z] = spheres.center;
        [x, y, z, spheres.radius]
    });
    rows.flatten()
        .map(|x| if x.is_nan() { f32::NAN } else { x }.to_bits())
        .collect()
}

/// Returns the poses compared.
fn check(mesh: &RawMesh, basis: &Basis) -> usize {
    let model = bake::baked(mesh, basis);
    let asset = *model.asset();
    let scalar = asset.with_kernel(Kernel::Scalar).expect("scalar");
    let mut rng = poses::rng(7);
    let mut qs = poses::hard_qs(&asset);
    qs.extend([1e-4, 0.05, 1.0, 50.0].map(|share| poses::random_q(&asset, share, &mut rng)));
    let size = poses::diagonal(&asset) * asset.unit();
    let mut compared = 0;
    for q in &qs {
        for tolerance in [0.0, 0.01 * size] {
            let mut memory = vec![0.0; asset.pose_len()];
            let here = Transform::IDENTITY;
            let pose = pose_within(&scalar, q, here, tolerance, &mut memory);
            let expected = bits(&pose.expect("pose"));
            for kernel in Kernel::ALL {
                if let Some(asset) = asset.with_kernel(kernel) {
                    let pose = pose_within(&asset, q, here, tolerance, &mut memory);
                    let found = bits(&pose.expect("pose"));
                    assert!(found == expected, "{kernel:?}, q {q:?}");
                    compared += 1;
                }
            }
        }
    }
    compared
}

#[test]
fn every_kernel_gives_the_same_bits() {
    let mesh = bake::bumpy_sphere(6, 2);
    for mode_count in [0, 1, 2, 3, 9, 64] {
        check(&mesh, &bake::smooth_basis(&mesh, mode_count, 3));
    }
    let mesh = bake::bumpy_sphere(10, 2);
    let compared = check(&mesh, &bake::local_basis(&mesh, 21, 3));
    assert!(compared > 20);
}
