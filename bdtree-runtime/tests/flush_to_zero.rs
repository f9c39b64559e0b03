//! With subnormals flushed, as audio and game code sets the processor: vertices stay in their
//! spheres and queries equal brute force in the same mode.
#![cfg(target_arch = "x86_64")]

use bdtree_build::input::RawMesh;
use bdtree_fixtures::flush::with_mode;
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_runtime::narrow::OrientedBox;
use bdtree_runtime::{
    Asset, Ball, Capsule, Contact, Cuboid, Frustum, Kernel, PairContact, Pose, Ray, Transform,
    VertexId, Workspace,
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

fn check_containment(pose: &Pose<'_>) {
    let asset = pose.asset();
    // The root's lanes hold all triangles below them; leaf lanes of all nodes hold their own.
    for (i, node) in asset.nodes().iter().enumerate() {
        let spheres = pose.node_spheres(i as u32).expect("node");
        let mut slot = node.first_slot as usize;
        for lane in 0..8 {
            let count = usize::from(node.leaf_counts[lane]);
            for triangle in &asset.triangles()[slot..slot + count] {
                for corner in triangle.corners {
                    let p = pose.deformed_stored(VertexId(corner)).expect("vertex");
                    let square: f64 = (0..3)
                        .map(|k| (f64::from(p[k]) - f64::from(spheres.center[k][lane])).powi(2))
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

fn check_queries(pose: &Pose<'_>) {
    let asset = pose.asset();
    let triangles = oracle::deformed_triangles(pose);
    let size = poses::diagonal(asset) * asset.unit();
    let mut workspace = Workspace::new();
    for k in 0..6 {
        let target = triangles[k * triangles.len() / 6][k % 3];
        let point = target.map(|c| c + 0.01 * k as f64 * size);
        let radius = 0.1 * size;
        let mut found: Vec<Contact> = Vec::new();
        let mut query = pose.query(&mut workspace);
        query
            .contacts(Ball::new(point, radius), &mut found)
            .expect("ball");
        found.sort_by_key(|c| c.triangle);
        let ids: Vec<(u32, f64)> = found.iter().map(|c| (c.triangle.0, c.distance)).collect();
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
        let capsule = Capsule::new(ends[0], ends[1], radius);
        query.contacts(capsule, &mut found).expect("capsule");
        let expected = oracle::capsule(&triangles, ends, radius);
        assert_eq!(
            sorted(&found),
            expected.iter().map(|e| e.0).collect::<Vec<_>>()
        );
        found.clear();
        let (turned, half) = ([0.0, 0.6, 0.0, 0.8], [radius, 0.3 * radius, 2.0 * radius]);
        let cuboid = Cuboid::new(point, half).rotated(turned);
        query.contacts(cuboid, &mut found).expect("box");
        let expected = oracle::cuboid(&triangles, &OrientedBox::new(point, turned, half));
        assert_eq!(
            sorted(&found),
            expected.iter().map(|e| e.0).collect::<Vec<_>>()
        );
        let height = 1.5 * target[0] - 2.0 * target[1] + 0.25 * target[2];
        let planes = [[1.5, -2.0, 0.25, -height], [0.0, 1.0, 0.0, 2.0 * size]];
        let planes = Frustum::new(&planes).expect("planes");
        let state = query.frustum_state(&planes).expect("frustum");
        assert_eq!(state, oracle::frustum(&triangles, &planes));
        let near = query.project_point(point, f64::INFINITY).expect("closest");
        let near = near.map(|h| (h.triangle.0, h.distance));
        assert_eq!(near, oracle::closest(&triangles, point, f64::INFINITY));
        let axis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]][k % 3];
        let origin = [0, 1, 2].map(|i| target[i] - 3.0 * size * axis[i]);
        let hit = query.cast_ray(&Ray::new(origin, axis)).expect("ray");
        let hit = hit.map(|h| (h.triangle.0, h.distance));
        assert_eq!(hit, oracle::ray(&triangles, origin, axis, f64::INFINITY));
    }
    let place = Transform {
        translation: [0.3 * size, 0.1 * size, 0.0],
        ..Transform::IDENTITY
    };
    let mut memory = vec![0.0; asset.pose_len()];
    let other = asset.pose(pose.q(), place, &mut memory).expect("pose");
    let mut found: Vec<PairContact> = Vec::new();
    let mut query = pose.against(&other, &mut workspace);
    query.contacts(0.0, &mut found).expect("pair");
    let mut ids: Vec<(u32, u32)> = found
        .iter()
        .map(|c| (c.triangle1.0, c.triangle2.0))
        .collect();
    ids.sort_unstable();
    let others = oracle::deformed_triangles(&other);
    assert_eq!(ids, oracle::pair(&triangles, &others, 0.0));
}

fn check_mesh(mesh: &RawMesh, mode_count: usize) {
    let model = bake::baked(mesh, &bake::smooth_basis(mesh, mode_count, 2));
    let asset = *model.asset();
    for kernel in Kernel::ALL {
        let Some(asset) = asset.with_kernel(kernel) else {
            continue;
        };
        for q in qs(&asset) {
            for flush in [false, true] {
                with_mode(flush, || {
                    let mut memory = vec![0.0; asset.pose_len()];
                    let pose = asset.pose(&q, Transform::IDENTITY, &mut memory);
                    let pose = pose.expect("pose");
                    check_containment(&pose);
                    check_queries(&pose);
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
