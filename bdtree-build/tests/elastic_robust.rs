//! Elastic modes of meshes as they come: open, split, inside out, empty, far away.

use std::path::Path;

use crate::elastic_support::{V3, boxed};
use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, ElasticReport, Fix, FixRegion, elastic_basis};
use bdtree_build::error::BakeError;
use bdtree_build::input::{BadFaces, GroupKind, RawGroup, RawMesh, read_model};
use bdtree_build::progress::Silent;

fn join(mut a: RawMesh, b: &RawMesh) -> RawMesh {
    let n = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.triangles
        .extend(b.triangles.iter().map(|t| t.map(|v| v + n)));
    a
}

fn options(resolution: u32) -> ElasticOptions {
    ElasticOptions {
        resolution: Some(resolution),
        mode_count: 4,
        ..ElasticOptions::default()
    }
}

fn run(mesh: &RawMesh, o: &ElasticOptions) -> Result<(Basis, ElasticReport), BakeError> {
    elastic_basis(mesh, o, &Silent, &mut Vec::new())
}

fn omegas(mesh: &RawMesh, o: &ElasticOptions) -> Vec<f64> {
    let (basis, _) = run(mesh, o).expect("modes");
    assert!(basis.fields.iter().flatten().all(|x| x.is_finite()));
    assert_eq!(
        basis.fields.len(),
        mesh.positions.len() * basis.mode_count()
    );
    basis.modes.iter().map(|m| m.omega_rad_s.unwrap()).collect()
}

fn assert_close(a: &[f64], b: &[f64], tolerance: f64) {
    for (x, y) in a.iter().zip(b) {
        assert!((x / y - 1.0).abs() < tolerance, "{a:?} {b:?}");
    }
}

#[test]
fn orientation_seams_and_small_holes_do_not_matter() {
    let good = boxed([0.0; 3], [4.0, 1.0, 1.5]);
    let o = options(16);
    let want = omegas(&good, &o);
    let mut inside_out = good.clone();
    for t in &mut inside_out.triangles {
        t.swap(0, 1);
    }
    assert_close(&omegas(&inside_out, &o), &want, 1e-9);
    let mut mixed = good.clone();
    for t in mixed.triangles.iter_mut().step_by(3) {
        t.swap(0, 1);
    }
    assert_close(&omegas(&mixed, &o), &want, 1e-9);
    let mut split = RawMesh::default();
    for t in &good.triangles {
        let n = split.positions.len() as u32;
        split
            .positions
            .extend(t.map(|v| good.positions[v as usize]));
        split.triangles.push([n, n + 1, n + 2]);
    }
    assert_close(&omegas(&split, &o), &want, 1e-9);
    // Of 768 triangles one is missing: a hole, not a sheet.
    let mut fine = split;
    for _ in 0..3 {
        for t in std::mem::take(&mut fine.triangles) {
            let [a, b, c] = t;
            let n = fine.positions.len() as u32;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let (p, q) = (fine.positions[p as usize], fine.positions[q as usize]);
                fine.positions
                    .push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
            }
            fine.triangles.extend([
                [a, n, n + 2],
                [n, b, n + 1],
                [n + 2, n + 1, c],
                [n, n + 1, n + 2],
            ]);
        }
    }
    assert_close(&omegas(&fine, &o), &want, 1e-9);
    fine.triangles.remove(100);
    assert_close(&omegas(&fine, &o), &want, 0.01);
    let mass = run(&fine, &o).unwrap().1.mass_kg;
    assert!((mass / 6000.0 - 1.0).abs() < 1e-2, "{mass}");
}

#[test]
fn hollow_bodies_weigh_what_they_hold() {
    let outer = boxed([0.0; 3], [2.0; 3]);
    let mut inner = boxed([0.3; 3], [1.4; 3]);
    for t in &mut inner.triangles {
        t.swap(0, 1);
    }
    let hollow = join(outer.clone(), &inner);
    let mass = run(&hollow, &options(9)).unwrap().1.mass_kg;
    let want = 1000.0 * (8.0 - 1.4f64.powi(3));
    assert!((mass / want - 1.0).abs() < 1e-9, "{mass} {want}");
    // A body inside another that is not a cavity adds nothing: the place is taken.
    let solid = join(outer, &boxed([0.3; 3], [1.4; 3]));
    let mass = run(&solid, &options(9)).unwrap().1.mass_kg;
    assert!((mass / 8000.0 - 1.0).abs() < 1e-3, "{mass}");
}

#[test]
fn small_and_far_coordinates_give_the_same_frequencies() {
    let good = boxed([0.0; 3], [4.0, 1.0, 1.5]);
    let want = omegas(&good, &options(16));
    let far = boxed([1e6, -1e6, 1e6], [4.0, 1.0, 1.5]);
    assert_close(&omegas(&far, &options(16)), &want, 1e-6);
    let tiny = boxed([0.0; 3], [4e-6, 1e-6, 1.5e-6]);
    let o = ElasticOptions {
        scale_m: 1e6,
        ..options(16)
    };
    assert_close(&omegas(&tiny, &o), &want, 1e-6);
}

#[test]
fn pieces_apart_get_their_own_modes() {
    // Two equal bars and a stiff little cube, in cells that touch nowhere, then in neighbours.
    for gap in [1.0, 0.01] {
        let bar = boxed([0.0; 3], [8.0, 1.0, 1.0]);
        let second = boxed([0.0, 1.0 + gap, 0.0], [8.0, 1.0, 1.0]);
        let cube = boxed([0.0, -1.0 - gap, 0.0], [1.0; 3]);
        let all = join(join(bar.clone(), &second), &cube);
        let o = options(16);
        let (basis, report) = run(&all, &o).unwrap();
        let w: Vec<f64> = basis.modes.iter().map(|m| m.omega_rad_s.unwrap()).collect();
        if gap < 0.5 {
            // They share cells: one body, which bends as one.
            assert_eq!(report.components, 1, "gap {gap}");
            continue;
        }
        assert_eq!(report.components, 3);
        assert_eq!(report.pieces_without_mode.len(), 1);
        assert_eq!(report.pieces_without_mode[0].first_triangle, 24);
        assert_close(&w[1..2], &w[0..1], 1e-3);
        let still = basis.field(0)[8..].iter().flatten().all(|x| *x == 0.0);
        let other = basis.field(0)[..8].iter().flatten().all(|x| *x == 0.0);
        assert!(still || other, "a mode moves one piece only");
    }
}

/// A face of two triangles is held as a whole: the pair of a square bar stays equal.
#[test]
fn a_face_of_two_triangles_is_clamped() {
    let bar = boxed([0.0; 3], [10.0, 1.0, 1.0]);
    for resolution in [7, 10, 20] {
        let mut o = options(resolution);
        o.fixes = vec!["xyz:0,0,0,0,1,1".parse().unwrap()];
        let w = omegas(&bar, &o);
        assert_close(&w[..1], &w[1..2], 1e-3);
        // Euler and Bernoulli: β₁L = 1.875104, E = 2e9, ρ = 1000.
        let euler = 1.875_104f64.powi(2) / 100.0 * (2e6f64 / 12.0).sqrt();
        assert!(
            (w[0] / euler - 1.0).abs() < 0.02,
            "{resolution}: {w:?} {euler}"
        );
    }
}

/// A sheet weighs area times thickness at every resolution, also where it is some cells thick.
fn sheet_keeps_its_mass(thickness: f64, resolution: u32) {
    let mut sheet = boxed([0.0; 3], [1.0; 3]);
    sheet.triangles = vec![[0, 1, 3], [0, 3, 2]];
    let mut o = options(resolution);
    o.mode_count = 1; // the mass does not depend on it
    o.thickness = Some(thickness);
    let mass = run(&sheet, &o).unwrap().1.mass_kg;
    assert!((mass / (1000.0 * thickness) - 1.0).abs() < 1e-9, "{mass}");
}

#[test]
fn sheets_of_some_cells_keep_their_mass() {
    sheet_keeps_its_mass(0.1, 35);
    sheet_keeps_its_mass(0.1, 8);
}

#[test]
fn sheets_of_a_cell_or_two_keep_their_mass() {
    sheet_keeps_its_mass(0.1, 22);
    sheet_keeps_its_mass(0.05, 24);
}

/// Two bars that touch are one body wherever the lattice's planes lie; a third piece moves them.
#[test]
fn pieces_that_touch_join_wherever_the_lattice_lies() {
    for n in 0..12 {
        let reach = 12.0 + 0.17 * f64::from(n);
        let bar = boxed([0.0; 3], [8.0, 1.0, 1.0]);
        let second = boxed([0.0, 1.0 + 1e-3, 0.0], [8.0, 1.0, 1.0]);
        let cube = boxed([0.0, reach - 1.0, 0.0], [1.0; 3]);
        let (_, report) = run(&join(join(bar, &second), &cube), &options(16)).unwrap();
        assert_eq!(report.components, 2, "box {reach} high");
    }
}

/// A fork whose prongs stand 0.6 cells apart bends as it does in cells a third of the size, but for
/// the slot's end, which lies up to 0.7 cells farther out: 15 % here. Welded it would be 2.6 times
/// as stiff.
#[test]
fn slots_of_half_a_cell_stay_open() {
    let (high, floor, gap) = (12.0, 1.5, 0.6);
    let profile = [
        [0.0, 0.0],
        [2.0 + gap, 0.0],
        [2.0 + gap, high],
        [1.0 + gap, high],
        [1.0 + gap, floor],
        [1.0, floor],
        [1.0, high],
        [0.0, high],
    ];
    let mut fork = RawMesh::default();
    for z in [0.0, 1.0] {
        fork.positions.extend(profile.map(|[x, y]| [x, y, z]));
    }
    for [a, b, c, d] in [[0, 1, 4, 5], [1, 2, 3, 4], [0, 5, 6, 7]] {
        fork.triangles.extend([[a, c, b], [a, d, c]]);
        fork.triangles
            .extend([[a, b, c], [a, c, d]].map(|t| t.map(|v| v + 8)));
    }
    for a in 0..8 {
        let b = (a + 1) % 8;
        fork.triangles.extend([[a, b, b + 8], [a, b + 8, a + 8]]);
    }
    let coarse = omegas(&fork, &options(12));
    let fine = omegas(&fork, &options(36));
    println!("{coarse:?} {fine:?}");
    assert_close(&coarse, &fine, 0.18);
}

#[test]
fn unused_vertices_follow_the_cell_they_lie_in() {
    let mut mesh = boxed([0.0; 3], [4.0, 1.0, 1.5]);
    mesh.positions.push([2.0, 0.5, 0.75]);
    mesh.positions.push([50.0, 0.5, 0.75]);
    mesh.triangles.push([0, 0, 1]);
    mesh.triangles.push([9, 9, 9]);
    let (basis, _) = run(&mesh, &options(12)).unwrap();
    assert!((0..4).any(|j| basis.field(j)[8].iter().any(|x| x.abs() > 1e-3)));
    assert!((0..4).all(|j| basis.field(j)[9] == [0.0; 3]));
}

/// What triangles in one place take to integrate is not told by the cells that they fill: alone, this
/// triangle would be given far more.
#[test]
fn many_large_triangles_in_one_place_are_given_few_cells() {
    let mesh = RawMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]; 3000],
        ..boxed([0.0; 3], [1.0; 3])
    };
    let default = ElasticOptions {
        mode_count: 4,
        ..ElasticOptions::default()
    };
    let (_, report) = run(&mesh, &default).expect("modes");
    assert!((1..=6).contains(&report.resolution), "{report:?}");
}

#[test]
fn bad_input_is_one_clear_error() {
    let good = boxed([0.0; 3], [4.0, 1.0, 1.5]);
    let message = |mesh: &RawMesh, o: &ElasticOptions| {
        let error = run(mesh, o).expect_err("an error");
        assert!(!error.problems.is_empty());
        error.to_string()
    };
    let with = |change: &dyn Fn(&mut ElasticOptions)| {
        let mut o = options(8);
        change(&mut o);
        o
    };
    let cases: [(&str, ElasticOptions); 12] = [
        ("--poisson", with(&|o| o.poisson = 0.5)),
        ("--poisson", with(&|o| o.poisson = f64::NAN)),
        ("--young", with(&|o| o.young_pa = -1.0)),
        ("--density", with(&|o| o.density_kg_m3 = f64::INFINITY)),
        ("--scale", with(&|o| o.scale_m = 0.0)),
        ("--thickness", with(&|o| o.thickness = Some(-1.0))),
        ("--thickness", with(&|o| o.thickness = Some(1e9))),
        ("--modes", with(&|o| o.mode_count = 0)),
        ("--modes", with(&|o| o.mode_count = 100_000)),
        ("--resolution", with(&|o| o.resolution = Some(0))),
        ("--resolution", with(&|o| o.resolution = Some(u32::MAX))),
        (
            "--resolution",
            with(&|o| {
                o.resolution = Some(40);
                o.memory_limit_bytes = 80 << 20;
            }),
        ),
    ];
    for (place, o) in &cases {
        let text = message(&good, o);
        println!("{text}");
        assert!(text.contains(place), "{text}");
        assert_eq!(text.lines().count(), 1);
    }
    let fix = |text: &str| {
        let fix: Fix = text.parse().unwrap();
        with(&|o| o.fixes = vec![fix.clone()])
    };
    assert!(message(&good, &fix("xyz:90,90,90,91,91,91")).contains("holds no part"));
    assert!(message(&good, &fix("z:legs")).contains("no group"));
    let everything = ElasticOptions {
        resolution: Some(1),
        ..fix("xyz:-9,-9,-9,9,9,9")
    };
    assert!(message(&good, &everything).contains("everything is held"));
    let empty = RawMesh::default();
    assert!(message(&empty, &options(8)).contains("no mass"));
    let mut flat = good.clone();
    flat.triangles = vec![[0, 0, 1], [0, 1, 1]];
    assert!(message(&flat, &options(8)).contains("no mass"));
    let mut bad = good.clone();
    bad.positions[3][1] = f64::NAN;
    assert!(message(&bad, &options(8)).contains("vertex 3"));
    let mut bad = good.clone();
    bad.triangles[2][0] = 800;
    assert!(message(&bad, &options(8)).contains("triangle 2"));
}

/// What a refusal for memory suggests is not refused.
#[test]
fn the_resolution_that_is_suggested_fits() {
    let chair = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/chair.obj");
    let chair = read_model(&chair, None, BadFaces::Refuse).expect("a chair");
    let chair = chair.mesh;
    for (mib, resolution) in [(2, 40), (5, 40), (10, 12), (20, 200), (50, 40)] {
        let mut o = options(resolution);
        o.memory_limit_bytes = mib << 20;
        let text = run(&chair, &o).expect_err("too fine").to_string();
        println!("{text}");
        let suggested = text.rsplit_once("; --resolution ").expect(&text).1;
        let suggested = suggested.strip_suffix(" fits").expect(&text);
        let suggested = suggested.parse().expect(&text);
        assert!(suggested < resolution, "{text}");
        o.resolution = Some(suggested);
        let (_, report) = run(&chair, &o).expect(&text);
        assert_eq!(report.resolution, suggested);
        // And it is no counsel of despair.
        o.resolution = Some(2 * suggested);
        assert!(run(&chair, &o).is_err(), "{text}");
    }
    let mut o = options(40);
    o.memory_limit_bytes = 1 << 10;
    let text = run(&chair, &o).expect_err("no memory").to_string();
    assert!(text.ends_with("; raise the limit"), "{text}");
}

#[test]
fn fix_is_read_from_text() {
    let fix: Fix = "zx:0,-1,2,3,4,5e1".parse().unwrap();
    assert_eq!(fix.axes, [true, false, true]);
    let (min, max) = ([0.0, -1.0, 2.0], [3.0, 4.0, 50.0]);
    assert_eq!(fix.region, FixRegion::Box { min, max });
    let fix: Fix = "y:left leg".parse().unwrap();
    assert_eq!(fix.region, FixRegion::Group("left leg".into()));
    for bad in [
        "",
        "x",
        ":a",
        "x:",
        "xx:a",
        "w:a",
        "x:1,2,3",
        "x:1,0,0,0,1,1",
        "x:nan,0,0,1,1,1",
    ] {
        assert!(bad.parse::<Fix>().is_err(), "{bad}");
    }
}

#[test]
fn groups_can_be_held() {
    let mut mesh = boxed([0.0; 3], [8.0, 1.0, 1.0]);
    mesh.groups.push(RawGroup {
        kind: GroupKind::Group,
        name: "end".into(),
        first_triangle: 8,
        triangle_count: 2,
    });
    let mut o = options(32);
    o.fixes = vec!["xyz:end".parse().unwrap()];
    let by_group = omegas(&mesh, &o);
    o.fixes = vec!["xyz:0,0,0,0,1,1".parse().unwrap()];
    // The box also meets the edges of the neighbouring faces, so its points differ a little.
    assert_close(&omegas(&mesh, &o), &by_group, 1e-3);
}

/// A list holds the triangles that have only its vertices, and the vertices.
#[test]
fn lists_of_vertices_can_be_held() {
    let mut mesh = boxed([0.0; 3], [8.0, 1.0, 1.0]);
    mesh.positions.push([99.0; 3]); // no triangle uses it
    let mut o = options(32);
    o.fixes = vec!["xyz:0,0,0,0,1,1".parse().unwrap()];
    let by_box = omegas(&mesh, &o);
    let list = tempfile::NamedTempFile::new().unwrap();
    // The corners with x = 0, from 1.
    std::fs::write(list.path(), "1,3,\n5 7 9").unwrap();
    o.fixes = vec![format!("xyz:@{}", list.path().display()).parse().unwrap()];
    assert_close(&omegas(&mesh, &o), &by_box, 1e-3);
    for (text, want) in [("1,3,10", ":1: `10`"), ("9", "holds no part")] {
        std::fs::write(list.path(), text).unwrap();
        let error = run(&mesh, &o).expect_err("an error").to_string();
        assert!(error.contains(want), "{error}");
    }
}

/// Whatever the triangles, the answer is modes or an error.
#[test]
fn random_soups_never_panic() {
    let mut state = 7u64;
    let mut next = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    for case in 0..40 {
        let mut mesh = RawMesh::default();
        let vertices = 3 + (next() * 12.0) as usize;
        // Coarse coordinates make coincident points, flat meshes and faces in lattice planes.
        let steps = [2.0, 4.0, 1e6][case % 3];
        for _ in 0..vertices {
            let mut p: V3 = std::array::from_fn(|_| (next() * steps).floor() / steps);
            if case % 5 == 0 {
                p[case % 3] = 0.5;
            }
            mesh.positions.push(p);
        }
        for _ in 0..(1.0 + next() * 20.0) as usize {
            mesh.triangles
                .push(std::array::from_fn(|_| (next() * vertices as f64) as u32));
        }
        let mut o = options(1 + (case as u32 % 11));
        o.thickness = [None, Some(0.3), Some(1e-4)][case % 3];
        match run(&mesh, &o) {
            Ok((basis, report)) => {
                assert!(basis.fields.iter().flatten().all(|x| x.is_finite()));
                assert!(report.mass_kg > 0.0);
            }
            Err(e) => println!("{case}: {e}"),
        }
    }
}
