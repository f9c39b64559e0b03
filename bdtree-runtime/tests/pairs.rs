//! Pairs that are hard to tell apart, and trees that tell nothing: the answers of brute force, with
//! and without caches.

use bdtree_build::input::RawMesh;
use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::compare::pair_caches::PairCaches;
use bdtree_fixtures::mutate::{put, section};
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_format::{LANES, NodeRecord, ROW_RADIUS, Row, SectionKind};
use bdtree_runtime::{Model, Transform, TrianglePair, Workspace};
use std::mem::{offset_of, size_of};

/// Compares two instances that differ by `shift` and `q`, at `place`; the number of pairs found.
fn check(model: &Model, place: Transform, shift: [f64; 3], share: [f64; 2]) -> usize {
    let asset = *model.asset();
    let qs = share.map(|share| poses::random_q(&asset, share, &mut poses::rng(3)));
    let mut moved = place;
    for k in 0..3 {
        moved.translation[k] += shift[k];
    }
    let (mut memory_a, mut memory_b) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
    let a = asset.pose(&qs[0], place, &mut memory_a).expect("pose");
    let b = asset.pose(&qs[1], moved, &mut memory_b).expect("pose");
    let triangles = [&a, &b].map(oracle::deformed_triangles);
    let mut caches = PairCaches::new(&asset);
    let mut count = 0;
    for tolerance in [0.0, 1e-3 * place.scale] {
        let expected = oracle::pair(&triangles[0], &triangles[1], tolerance);
        count += expected.len();
        for asset in kernels(&asset) {
            let a = asset.pose(&qs[0], place, &mut memory_a).expect("pose");
            let b = asset.pose(&qs[1], moved, &mut memory_b).expect("pose");
            let found = caches.pairs([&a, &b], tolerance);
            assert_eq!(found, expected, "shift {shift:?}, tolerance {tolerance}");
        }
    }
    count
}

fn sphere() -> Model {
    let mesh = bake::bumpy_sphere(10, 1);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5))
}

#[test]
fn identical_copies_and_slight_shifts() {
    let model = sphere();
    let turned = poses::random_transform(1.0, &mut poses::rng(9));
    for place in [Transform::IDENTITY, turned] {
        for share in [[0.0, 0.0], [0.2, 0.2], [0.2, 0.201]] {
            for shift in [[0.0; 3], [1e-300, 0.0, 0.0], [0.0, 1e-9, 0.0], [0.01; 3]] {
                assert!(check(&model, place, shift, share) > 0);
            }
        }
    }
}

#[test]
fn far_from_the_world_s_origin() {
    let model = sphere();
    for far in [1e3, 1e6, 1e9, 1e15] {
        let mut place = poses::random_transform(1.0, &mut poses::rng(9));
        place.translation = [far, -2.0 * far, 0.5 * far];
        assert!(check(&model, place, [0.3, 0.2, 0.1], [0.2, 0.3]) > 0);
    }
}

#[test]
fn small_and_large_scales() {
    let model = sphere();
    for exponent in [-59, -30, 30, 59] {
        let place = Transform {
            scale: 2_f64.powi(exponent),
            ..Transform::IDENTITY
        };
        let shift = [0.7 * place.scale; 3];
        assert!(check(&model, place, shift, [0.2, 0.3]) > 0);
    }
}

#[test]
fn flat_sheets_that_share_a_plane() {
    let mut mesh = RawMesh::default();
    for i in 0..9_u32 {
        for j in 0..9_u32 {
            mesh.positions.push([f64::from(i), f64::from(j), 0.0]);
            if i < 8 && j < 8 {
                let at = 9 * i + j;
                mesh.triangles.push([at, at + 9, at + 10]);
                mesh.triangles.push([at, at + 10, at + 1]);
            }
        }
    }
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    for shift in [
        [0.0; 3],
        [0.5, 0.0, 0.0],
        [0.25, 0.25, 0.0],
        [0.0, 0.0, 1e-12],
    ] {
        assert!(check(&model, Transform::IDENTITY, shift, [0.0; 2]) > 0);
    }
}

/// Round bodies from overlapping to apart, in several directions: where a plane lies between them, it
/// is found, and nothing else says so.
#[test]
fn bodies_that_nearly_touch() {
    let model = sphere();
    let mut rng = poses::rng(21);
    let (mut touching, mut apart) = (0, 0);
    for _ in 0..6 {
        let place = poses::random_transform(1.0, &mut rng);
        let along = poses::random_transform(1.0, &mut rng).rotation;
        // Twice the vector part of a unit quaternion, scaled to length 1.
        let [x, y, z, _] = along;
        let length = (x * x + y * y + z * z).sqrt();
        for step in 0..24 {
            let far = place.scale * (1.7 + 0.03 * f64::from(step)) / length;
            let shift = [x * far, y * far, z * far];
            match check(&model, place, shift, [0.1, 0.15]) {
                0 => apart += 1,
                _ => touching += 1,
            }
        }
    }
    println!("{touching} touching, {apart} apart");
    assert!(
        touching > 30 && apart > 30,
        "{touching} touching, {apart} apart"
    );
}

/// Parallel faces at distances around 0 and around the tolerance.
#[test]
fn faces_that_nearly_touch() {
    let corner = |k: u32| [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
    let mesh = RawMesh {
        positions: (0..8).map(corner).collect(),
        triangles: [
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ]
        .to_vec(),
        ..RawMesh::default()
    };
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    let turned = poses::random_transform(1.0, &mut poses::rng(5));
    for gap in [
        -1e-6,
        -1e-12,
        0.0,
        1e-12,
        1e-9,
        1e-6,
        1e-3 - 1e-9,
        1e-3,
        1e-3 + 1e-9,
        2e-3,
    ] {
        let found = check(
            &model,
            Transform::IDENTITY,
            [1.0 + gap, 0.25, 0.0],
            [0.0; 2],
        );
        assert_eq!(found > 0, gap <= 1e-3, "gap {gap}: {found} pairs");
        let along = turned.scale * (1.0 + gap);
        check(&model, turned, [along, 0.0, 0.0], [0.0; 2]);
    }
}

/// One plane between two bodies, instead of all pairs of nodes that are near each other.
#[test]
fn a_plane_takes_few_visits() {
    let model = bake::baked(
        &bake::bumpy_sphere(60, 1),
        &bake::rigid(&bake::bumpy_sphere(60, 1)),
    );
    let asset = *model.asset();
    let mut workspace = Workspace::new();
    let mut found: Vec<TrianglePair> = Vec::new();
    // Nearer and nearer until they touch.
    let mut visits = Vec::new();
    for step in 0..100 {
        let place = Transform {
            translation: [2.6 - 0.02 * f64::from(step), 0.0, 0.0],
            ..Transform::IDENTITY
        };
        let mut memory = [vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]];
        let [memory_a, memory_b] = &mut memory;
        let a = asset
            .pose(&[], Transform::IDENTITY, memory_a)
            .expect("pose");
        let b = asset.pose(&[], place, memory_b).expect("pose");
        let mut query = a.against(&b, &mut workspace);
        query.triangle_pairs(0.0, &mut found).expect("query");
        visits.push(query.stats().nodes_visited);
        if !found.is_empty() {
            break;
        }
    }
    // Those that touch, and before them three that a plane still or hardly separates.
    println!("{visits:?}");
    let [.., apart, _, _, touching] = visits[..] else {
        panic!("they never touch");
    };
    assert!(!found.is_empty() && apart > 0, "{visits:?}");
    assert!(3 * apart < touching, "{visits:?}");
}

/// Every radius a NaN: all lanes are entered, and the triangles decide.
#[test]
fn radii_that_are_no_numbers() {
    let mut bytes = bake::baked(
        &bake::bumpy_sphere(6, 1),
        &bake::smooth_basis(&bake::bumpy_sphere(6, 1), 3, 5),
    )
    .asset()
    .bytes()
    .to_vec();
    let nodes = section(&bytes, SectionKind::NODES);
    let rows = section(&bytes, SectionKind::ROWS);
    for node in nodes.step_by(size_of::<NodeRecord>()) {
        let at = node + offset_of!(NodeRecord, row_start);
        let row = u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let radius = rows.start + (row as usize + ROW_RADIUS) * size_of::<Row>();
        for lane in 0..LANES {
            put(&mut bytes, radius + 4 * lane, &f32::NAN.to_le_bytes());
        }
    }
    let model = Model::from_bytes(&bytes).expect("open");
    assert!(check(&model, Transform::IDENTITY, [1.0, 0.5, 0.0], [0.2, 0.3]) > 0);
}
