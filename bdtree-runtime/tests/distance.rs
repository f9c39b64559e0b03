//! The distance of two assets equals brute force over all pairs of triangles, with and without
//! caches, on every kernel: disjoint, touching, coplanar, identical, degenerate, far away.

use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::compare::near::{check_distances, two};
use bdtree_fixtures::{bake, corpus, models, poses};
use bdtree_runtime::{QueryError, Transform, Workspace};

#[test]
fn distances_equal_brute_force() {
    let sphere = bake::bumpy_sphere(12, 1);
    let smooth = bake::baked(&sphere, &bake::smooth_basis(&sphere, 10, 5));
    let other = bake::bumpy_sphere(7, 2);
    let local = bake::baked(&other, &bake::local_basis(&other, 12, 2));
    let rigid = bake::baked(&other, &bake::rigid(&other));
    let [smooth, local, rigid] = [&smooth, &local, &rigid].map(|model| *model.asset());
    for gap in [0.2, 0.6, 1.5, 30.0] {
        check_distances(&smooth, &smooth, 3, 4, gap);
        check_distances(&smooth, &local, 4, 4, gap);
        check_distances(&rigid, &smooth, 5, 4, gap);
    }
}

#[test]
fn distances_of_far_instances_equal_brute_force() {
    let sphere = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&sphere, &bake::smooth_basis(&sphere, 4, 5));
    let asset = *model.asset();
    // Around the distance at which the bound changes, then ever fewer digits.
    for gap in [300.0, 1e3, 3e3, 1e5, 1e8, 1e11] {
        check_distances(&asset, &asset, 6, 3, gap);
    }
    // Where f32 ends nothing is pruned, and nothing fails.
    let small = bake::bumpy_sphere(3, 1);
    let model = bake::baked(&small, &bake::smooth_basis(&small, 2, 5));
    let asset = *model.asset();
    check_distances(&asset, &asset, 7, 3, 1e15);
    check_distances(&asset, &asset, 7, 3, 1e23);
    // Both together far from the world's origin.
    let mut place = Transform::IDENTITY;
    place.translation = [1e7, -3e6, 1e5];
    let mut beside = place;
    beside.translation[0] += 2.5;
    two(
        (&asset, &[0.5, 1.0], place),
        (&asset, &[0.0, 1.0], beside),
        |two| {
            two.check_distance("far from the origin");
        },
    );
    // A very large and a very small one.
    for scale in [1e-6, 1e6] {
        let mut beside = Transform::IDENTITY;
        beside.translation = [1.5, 1.0, 0.5];
        beside.scale = scale;
        two(
            (&asset, &[0.5, 1.0], Transform::IDENTITY),
            (&asset, &[0.0, 1.0], beside),
            |two| two.check_distance("scales"),
        );
    }
}

#[test]
fn touching_and_identical_copies_have_distance_0_and_the_lowest_ids() {
    let sphere = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&sphere, &bake::smooth_basis(&sphere, 3, 5));
    let asset = *model.asset();
    let q = [0.3, -0.5, 0.7];
    for x in [0.0, 0.5, 1.9] {
        let mut place = Transform::IDENTITY;
        place.translation[0] = x;
        two(
            (&asset, &q, Transform::IDENTITY),
            (&asset, &q, place),
            |two| {
                two.check_distance("copies");
                if x < 1.0 {
                    let hit = two.distance(0.0).expect("they touch");
                    assert_eq!((hit.distance, hit.point1), (0.0, hit.point2));
                }
            },
        );
    }
}

/// A grid of `n` × `n` squares in z = 0 over the unit square.
fn grid(n: u32) -> RawMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let mut mesh = RawMesh {
        name: "grid".into(),
        ..RawMesh::default()
    };
    for i in 0..=n {
        for j in 0..=n {
            mesh.positions.push([
                f64::from(i) / f64::from(n),
                f64::from(j) / f64::from(n),
                0.0,
            ]);
        }
    }
    for i in 0..n {
        for j in 0..n {
            mesh.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

#[test]
fn ties_go_to_the_lowest_ids() {
    // Parallel sheets: every pair above each other is as near as the next.
    let mesh = grid(8);
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    let asset = *model.asset();
    for offset in [
        [0.0, 0.0, 0.25],
        [0.0; 3],
        [0.125, 0.25, 0.0],
        [1.0, 0.0, 0.0],
    ] {
        let mut place = Transform::IDENTITY;
        place.translation = offset;
        two(
            (&asset, &[], Transform::IDENTITY),
            (&asset, &[], place),
            |two| {
                two.check_distance("sheets");
                let hit = two.distance(1.0).expect("near");
                assert_eq!(hit.distance, offset[2]);
                if offset[0] == 0.0 {
                    assert_eq!((hit.triangle1.0, hit.triangle2.0), (0, 0));
                }
            },
        );
    }
}

#[test]
fn degenerate_triangles_act_as_what_they_are() {
    let mut mesh = grid(3);
    // Points and segments, some of them apart from the sheet.
    let n = mesh.positions.len() as u32;
    mesh.positions
        .extend([[0.5, 0.5, 0.5], [0.5, 0.25, 0.5], [0.25, 0.25, 0.75]]);
    mesh.triangles.extend([
        [n, n, n],
        [n, n + 1, n],
        [n + 1, n + 2, n + 1],
        [0, 0, 5],
        [3, 3, 3],
    ]);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 5));
    let asset = *model.asset();
    for gap in [0.1, 0.5, 2.0] {
        check_distances(&asset, &asset, 8, 6, gap);
    }
}

#[test]
fn hard_poses() {
    let mesh = bake::bumpy_sphere(6, 4);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 5, 5));
    let asset = *model.asset();
    let mut rng = poses::rng(4);
    for (i, q) in poses::hard_qs(&asset).iter().enumerate() {
        let other = poses::random_q(&asset, 0.3, &mut rng);
        let place = poses::random_transform(3.0, &mut rng);
        two(
            (&asset, q, Transform::IDENTITY),
            (&asset, &other, place),
            |two| {
                two.check_distance(&format!("hard pose {i}"));
            },
        );
    }
}

#[test]
fn what_is_wrong_is_said() {
    let mesh = bake::bumpy_sphere(6, 4);
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    let asset = *model.asset();
    let here = Transform::IDENTITY;
    two((&asset, &[], here), (&asset, &[], here), |two| {
        let mut workspace = Workspace::new();
        let mut query = two.a.against(&two.b, &mut workspace);
        for limit in [-1.0, f64::NAN] {
            let answer = query.closest_points(limit);
            assert!(matches!(answer, Err(QueryError::Argument(_))), "{limit}");
            assert_eq!(query.distance(limit).err(), answer.err());
        }
        let whole = query.closest_points(f64::INFINITY);
        assert_eq!(query.closest_points(f64::MAX), whole);
        let answer = query.closest_points(1.0).expect("an answer");
        assert_eq!(query.distance(1.0), Ok(answer.map(|hit| hit.distance)));
        let mut memory = [0; 100];
        let mut small = Workspace::in_bytes(&mut memory);
        let answer = two.a.against(&two.b, &mut small).closest_points(1.0);
        assert!(matches!(answer, Err(QueryError::Memory { needed, found })
            if needed > found && found > 90));
    });
}

#[test]
fn fixtures_and_corpus() {
    for name in ["beam", "pieces"] {
        let mesh = read_mesh(&models::path(name)).expect("fixture");
        let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5));
        let asset = *model.asset();
        check_distances(&asset, &asset, 8, 2, 0.9);
    }
    for name in ["fish.obj", "curtain.obj", "teapot.obj"] {
        let test = "fixtures_and_corpus";
        let Some(path) = corpus::path(test, &format!("meshes/{name}")) else {
            return;
        };
        let mesh = read_mesh(&path).expect("mesh");
        let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 5));
        let asset = *model.asset();
        check_distances(&asset, &asset, 8, 1, 0.9);
    }
}
