//! With subnormals flushed, as audio and game code sets the processor: vertices stay in their
//! spheres and queries equal brute force in the same mode.
#![cfg(target_arch = "x86_64")]

use bdtree_build::input::RawMesh;
use bdtree_fixtures::flush::with_mode;
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_runtime::narrow::{Frustum, OrientedBox};
use bdtree_runtime::{
    Asset, Contact, Kernel, PairContact, PairStackEntry, Pose, StackEntry, Transform, VertexId,
    query,
};

/// q that make products and sums subnormal, and ordinary ones.
fn qs(asset: &Asset<'_>) -> Vec<Vec<f32>> {
    let mut all = poses::hard_qs(asset);
    let m = asset.mode_count();
    for scale in [1e-38_f32, 3e-38, 1e-36, 1e-33, 1e-30] {
        all.push(
            (0..m)
                .map(|j| if j % 2 == 0 { scale } else { -scale })
                .collect(),
        );
    }
    all
}

fn check_containment(asset: &Asset<'_>, pose: &Pose<'_>) {
    // The root's lanes hold all triangles below them; leaf lanes of all nodes hold their own.
    for (i, node) in asset.nodes().iter().enumerate() {
        let spheres = asset.node_spheres(pose, i as u32).expect("node");
        let mut slot = node.first_slot as usize;
        for lane in 0..8 {
            let count = usize::from(node.leaf_counts[lane]);
            for triangle in &asset.triangles()[slot..slot + count] {
                for corner in triangle.corners {
                    let p = asset
                        .deformed_stored(pose, VertexId(corner))
                        .expect("vertex");
                    let square: f64 = (0..3)
                        .map(|k| (f64::from(p[k]) - f64::from(spheres.centre[k][lane])).powi(2))
                        .sum();
                    let r = f64::from(spheres.radius[lane]);
                    assert!(
                        r.is_nan() || square <= r * r * (1.0 + 1e-12),
                        "node {i}, lane {lane}"
                    );
                }
            }
            slot += count;
        }
    }
}

fn sorted(found: &[Contact]) -> Vec<u32> {
    let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
    ids.sort_unstable();
    ids
}

fn check_queries(asset: &Asset<'_>, pose: &Pose<'_>) {
    let triangles = oracle::deformed_triangles(asset, pose);
    let size = poses::diagonal(asset) * asset.unit();
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    for k in 0..6 {
        let target = triangles[k * triangles.len() / 6][k % 3];
        let point = target.map(|c| c + 0.01 * k as f64 * size);
        let radius = 0.1 * size;
        let mut found: Vec<Contact> = Vec::new();
        query::ball(asset, pose, point, radius, &mut stack, &mut found).expect("ball");
        found.sort_by_key(|c| c.triangle);
        let ids: Vec<(u32, f64)> = found.iter().map(|c| (c.triangle.0, c.dist)).collect();
        let expected = oracle::ball(&triangles, point, radius);
        assert_eq!(
            ids,
            expected
                .iter()
                .map(|e| (e.0, e.1 - radius))
                .collect::<Vec<_>>()
        );
        let ends = [
            point,
            [0, 1, 2].map(|i| target[i] + radius * (i as f64 - 0.7)),
        ];
        found.clear();
        query::capsule(
            asset, pose, ends[0], ends[1], radius, &mut stack, &mut found,
        )
        .expect("capsule");
        let expected = oracle::capsule(&triangles, ends, radius);
        assert_eq!(
            sorted(&found),
            expected.iter().map(|e| e.0).collect::<Vec<_>>()
        );
        found.clear();
        let (turned, half) = ([0.0, 0.6, 0.0, 0.8], [radius, 0.3 * radius, 2.0 * radius]);
        query::cuboid(asset, pose, point, turned, half, &mut stack, &mut found).expect("box");
        let expected = oracle::cuboid(&triangles, &OrientedBox::new(point, turned, half));
        assert_eq!(
            sorted(&found),
            expected.iter().map(|e| e.0).collect::<Vec<_>>()
        );
        let height = 1.5 * target[0] - 2.0 * target[1] + 0.25 * target[2];
        let planes = [[1.5, -2.0, 0.25, -height], [0.0, 1.0, 0.0, 2.0 * size]];
        let planes = Frustum::new(&planes).expect("planes");
        let state = query::frustum(asset, pose, &planes, &mut stack).expect("frustum");
        assert_eq!(state.state, oracle::frustum(&triangles, &planes));
        let near = query::closest(asset, pose, point, f64::INFINITY, &mut stack).expect("closest");
        let near = near.hit.map(|h| (h.triangle.0, h.distance));
        assert_eq!(near, oracle::closest(&triangles, point, f64::INFINITY));
        let axis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]][k % 3];
        let origin = [0, 1, 2].map(|i| target[i] - 3.0 * size * axis[i]);
        let hit = query::ray(asset, pose, origin, axis, f64::INFINITY, &mut stack).expect("ray");
        let hit = hit.hit.map(|h| (h.triangle.0, h.distance));
        assert_eq!(hit, oracle::ray(&triangles, origin, axis, f64::INFINITY));
    }
    let place = Transform {
        translation: [0.3 * size, 0.1 * size, 0.0],
        ..Transform::IDENTITY
    };
    let mut memory = vec![0.0; asset.pose_len()];
    let other = Pose::new(asset, pose.q(), place, &mut memory).expect("pose");
    let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(asset)];
    let mut found: Vec<PairContact> = Vec::new();
    query::pair((asset, pose), (asset, &other), 0.0, &mut stack, &mut found).expect("pair");
    let mut ids: Vec<(u32, u32)> = found
        .iter()
        .map(|c| (c.triangle1.0, c.triangle2.0))
        .collect();
    ids.sort_unstable();
    let others = oracle::deformed_triangles(asset, &other);
    assert_eq!(ids, oracle::pair(&triangles, &others, 0.0));
}

fn check_mesh(mesh: &RawMesh, mode_count: usize) {
    let bytes = bake::baked(mesh, &bake::smooth_basis(mesh, mode_count, 2));
    let asset = Asset::open(&bytes).expect("open");
    for kernel in Kernel::ALL {
        let Some(asset) = asset.with_kernel(kernel) else {
            continue;
        };
        for q in qs(&asset) {
            for flush in [false, true] {
                with_mode(flush, || {
                    let mut memory = vec![0.0; asset.pose_len()];
                    let pose = Pose::new(&asset, &q, Transform::IDENTITY, &mut memory);
                    let pose = pose.expect("pose");
                    check_containment(&asset, &pose);
                    check_queries(&asset, &pose);
                });
            }
        }
    }
}

#[test]
fn flushed_subnormals_change_no_answer() {
    let mesh = bake::bumpy_sphere(6, 4);
    check_mesh(&mesh, 3);
    for scale in [1e-18, 1e-28] {
        let mut tiny = mesh.clone();
        for p in &mut tiny.positions {
            *p = p.map(|c| c * scale);
        }
        check_mesh(&tiny, 3);
    }
    // Most coordinates far below the largest one: differences and products vanish.
    let mut flat = mesh;
    for p in &mut flat.positions {
        *p = [p[0], 1e-37 * p[1], 1e-30 * p[2]];
    }
    check_mesh(&flat, 2);
}
