//! Mass properties of what closed surfaces enclose, against closed forms and sums of tetrahedra.

use bdtree_build::basis::Basis;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::mass::{Body, MassProperties, MassSource};
use bdtree_build::pipeline::{BakeSettings, Baked, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models;
use bdtree_runtime::Model;

use crate::elastic_support::{V3, boxed};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn baked(mesh: &RawMesh, body: Body) -> Baked {
    let basis = Basis {
        vertex_count: mesh.positions.len(),
        ..Basis::default()
    };
    let settings = BakeSettings {
        body,
        ..BakeSettings::default()
    };
    bake_fields(mesh, &basis, &settings, &Provenance::default(), &Silent).expect("a bake")
}

/// The mass of a rigid bake; the file says the same as the report, and passes its check.
fn mass(mesh: &RawMesh, body: Body) -> Option<MassProperties> {
    let made = baked(mesh, body);
    let model = Model::from_bytes(&made.bytes).expect("a sound file");
    let stored = model.asset().mass_properties();
    assert_eq!(stored.and_then(MassProperties::of_record), made.report.mass);
    assert_eq!(model.asset().mode_momenta(), None);
    let sound = model.asset().verify(&mut |error| panic!("{error}"));
    assert!(sound);
    made.report.mass
}

fn solid(mesh: &RawMesh) -> MassProperties {
    let found = mass(mesh, Body::default()).expect("a solid");
    assert_eq!(found.source, MassSource::Surface);
    found
}

fn fixture(name: &str) -> RawMesh {
    let mesh = models::mesh(name).expect("a mesh");
    RawMesh {
        positions: mesh.positions,
        triangles: mesh.triangles,
        ..RawMesh::default()
    }
}

fn moved(mesh: &RawMesh, map: impl Fn(V3) -> V3) -> RawMesh {
    RawMesh {
        positions: mesh.positions.iter().map(|p| map(*p)).collect(),
        ..mesh.clone()
    }
}

/// Largest difference of two lists over a scale.
fn apart<const N: usize>(a: [f64; N], b: [f64; N], scale: f64) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f64::max) / scale
}

/// Asserts that two bodies are the same to `within`, lengths over `size`.
fn assert_same(a: &MassProperties, b: &MassProperties, size: f64, within: f64) {
    assert!((a.mass_kg / b.mass_kg - 1.0).abs() < within, "{a:?} {b:?}");
    assert!((a.volume / b.volume - 1.0).abs() < within, "{a:?} {b:?}");
    let off = apart(a.center_of_mass, b.center_of_mass, size);
    assert!(off < within, "{off}: {a:?} {b:?}");
    let trace: f64 = b.inertia[..3].iter().sum();
    let off = apart(a.inertia, b.inertia, trace);
    assert!(off < within, "{off}: {a:?} {b:?}");
}

/// The same integrals by another way: tetrahedra to the first corner of all, each by Keast's rule of four points, which
/// is exact for what is of second degree.
fn by_quadrature(mesh: &RawMesh) -> MassProperties {
    let at = |v: u32| mesh.positions[v as usize];
    let apex = at(mesh.triangles[0][0]);
    let (near, far) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
    let mut points: Vec<(f64, V3)> = Vec::new();
    for t in &mesh.triangles {
        let p = [apex, at(t[0]), at(t[1]), at(t[2])];
        let [a, b, c]: [V3; 3] = [1, 2, 3].map(|k| std::array::from_fn(|i| p[k][i] - p[0][i]));
        let six: f64 = a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        for k in 0..4 {
            let own = std::array::from_fn(|i| {
                let weight = |n: usize| if n == k { near } else { far };
                (0..4).map(|n| weight(n) * p[n][i]).sum()
            });
            points.push((six / 24.0, own));
        }
    }
    let volume: f64 = points.iter().map(|p| p.0).sum();
    let center: V3 =
        std::array::from_fn(|i| points.iter().map(|(w, p)| w * p[i]).sum::<f64>() / volume);
    let second = |i: usize, j: usize| -> f64 {
        let terms = (points.iter()).map(|(w, p)| w * (p[i] - center[i]) * (p[j] - center[j]));
        1000.0 * terms.sum::<f64>()
    };
    let [xx, yy, zz] = [0, 1, 2].map(|i| second(i, i));
    MassProperties {
        mass_kg: 1000.0 * volume,
        center_of_mass: center,
        inertia: [
            yy + zz,
            xx + zz,
            xx + yy,
            -second(0, 1),
            -second(0, 2),
            -second(1, 2),
        ],
        density_kg_m3: 1000.0,
        scale_m: 1.0,
        volume,
        source: MassSource::Surface,
    }
}

/// A torus about the z axis: circles of radius r around one of radius R.
fn torus(big: f64, small: f64, count: usize) -> RawMesh {
    let mut mesh = RawMesh::default();
    let angle = |k: usize| k as f64 / count as f64 * std::f64::consts::TAU;
    for i in 0..count {
        for j in 0..count {
            let (u, v) = (angle(i), angle(j));
            let r = big + small * v.cos();
            mesh.positions
                .push([r * u.cos(), r * u.sin(), small * v.sin()]);
            let at = |i: usize, j: usize| ((i % count) * count + j % count) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn boxes_are_exact() {
    let (low, [a, b, c]) = ([3.0, -2.0, 0.5], [1.5, 0.25, 4.0]);
    let found = solid(&boxed(low, [a, b, c]));
    let m = 1000.0 * a * b * c;
    let want = MassProperties {
        mass_kg: m,
        center_of_mass: [low[0] + 0.5 * a, low[1] + 0.5 * b, low[2] + 0.5 * c],
        inertia: [
            m * (b * b + c * c) / 12.0,
            m * (a * a + c * c) / 12.0,
            m * (a * a + b * b) / 12.0,
            0.0,
            0.0,
            0.0,
        ],
        ..found
    };
    assert_same(&found, &want, 4.0, 1e-14);
    assert_eq!((found.density_kg_m3, found.scale_m), (1000.0, 1.0));
    assert!((found.volume / (a * b * c) - 1.0).abs() < 1e-14);
}

#[test]
fn balls_and_rings_meet_sums_of_tetrahedra_and_closed_forms() {
    let ball = fixture("icosphere");
    let found = solid(&ball);
    assert_same(&found, &by_quadrature(&ball), 1.0, 1e-13);
    // The polyhedron lies inside the ball: two thousandths of its volume are missing at 642 vertices.
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    let share = found.volume / volume;
    assert!((0.95..1.0).contains(&share), "{share}");
    let ratio = found.inertia[0] / (0.4 * found.mass_kg);
    assert!((0.96..1.0).contains(&ratio), "{ratio}");

    for mesh in [fixture("torus"), fixture("chair"), fixture("beam")] {
        let quadrature = by_quadrature(&mesh);
        assert_same(&solid(&mesh), &quadrature, 1.0, 1e-11);
    }
    let (big, small) = (2.0, 0.5);
    let ring = solid(&torus(big, small, 400));
    let volume = 2.0 * std::f64::consts::PI.powi(2) * big * small * small;
    let mass = 1000.0 * volume;
    let across = mass * (big * big / 2.0 + 5.0 / 8.0 * small * small);
    let want = MassProperties {
        mass_kg: mass,
        volume,
        center_of_mass: [0.0; 3],
        inertia: [
            across,
            across,
            mass * (big * big + 0.75 * small * small),
            0.0,
            0.0,
            0.0,
        ],
        ..ring
    };
    // The error of 400 chords: of second order.
    assert_same(&ring, &want, 1.0, 2e-4);
}

#[test]
fn motions_move_the_center_and_turn_the_inertia() {
    let mesh = fixture("chair");
    let own = solid(&mesh);
    let by = [12.5, -7.25, 100.0];
    let shifted = solid(&moved(&mesh, |p| std::array::from_fn(|a| p[a] + by[a])));
    let want = MassProperties {
        center_of_mass: std::array::from_fn(|a| own.center_of_mass[a] + by[a]),
        ..own
    };
    assert_same(&shifted, &want, 1.0, 1e-12);

    // A turn about (1, 2, 3) as a matrix: J becomes R J Rᵀ.
    let (angle, n) = (0.7_f64, 14f64.sqrt());
    let k = [1.0 / n, 2.0 / n, 3.0 / n];
    let turn: [V3; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let unit = f64::from(i == j);
            let across = match (i + 3 - j) % 3 {
                0 => 0.0,
                1 => k[(i + 1) % 3],
                _ => -k[(j + 1) % 3],
            };
            unit * angle.cos() + (1.0 - angle.cos()) * k[i] * k[j] + angle.sin() * across
        })
    });
    let turned = |p: V3| std::array::from_fn(|i| (0..3).map(|j| turn[i][j] * p[j]).sum());
    let found = solid(&moved(&mesh, turned));
    let [xx, yy, zz, xy, xz, yz] = own.inertia;
    let j = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let entry = |a: usize, b: usize| -> f64 {
        let at = |n: usize| (n / 3, n % 3);
        (0..9)
            .map(|n| turn[a][at(n).0] * j[at(n).0][at(n).1] * turn[b][at(n).1])
            .sum()
    };
    let want = MassProperties {
        center_of_mass: turned(own.center_of_mass),
        inertia: [
            entry(0, 0),
            entry(1, 1),
            entry(2, 2),
            entry(0, 1),
            entry(0, 2),
            entry(1, 2),
        ],
        ..own
    };
    assert_same(&found, &want, 1.0, 1e-12);
}

#[test]
fn density_and_scale_say_what_it_weighs() {
    let mesh = boxed([0.0; 3], [100.0, 200.0, 300.0]);
    let body = Body {
        density_kg_m3: 7800.0,
        scale_m: 1e-3,
        ..Body::default()
    };
    let found = mass(&mesh, body).expect("a solid");
    assert!((found.mass_kg / (7800.0 * 0.006) - 1.0).abs() < 1e-14);
    assert!((found.inertia[2] / (found.mass_kg * 50_000.0 / 12.0) - 1.0).abs() < 1e-13);
    assert_eq!((found.density_kg_m3, found.scale_m), (7800.0, 1e-3));
    let basis = Basis {
        vertex_count: 8,
        ..Basis::default()
    };
    for (option, wrong) in [
        (
            "--density",
            Body {
                density_kg_m3: 0.0,
                ..body
            },
        ),
        (
            "--scale",
            Body {
                scale_m: f64::NAN,
                ..body
            },
        ),
    ] {
        let settings = BakeSettings {
            body: wrong,
            ..BakeSettings::default()
        };
        let error = bake_fields(&mesh, &basis, &settings, &Provenance::default(), &Silent);
        let error = error.expect_err("no number").to_string();
        assert!(
            error.contains(option) && error.contains("positive number"),
            "{error}"
        );
    }
}

/// Far away only the rounding of the coordinates themselves is lost: at 10⁶ units a unit ball's are 10⁻¹⁰ apart.
#[test]
fn meshes_far_away_lose_only_what_their_coordinates_lost() {
    for (name, within) in [("far", 1e-9), ("far_8", 1e-7)] {
        let mesh = fixture(name);
        let found = solid(&mesh);
        let middle = found.center_of_mass.map(f64::round);
        assert!(middle.iter().any(|x| x.abs() > 1e5));
        // Exact: the coordinates are near to what is subtracted.
        let near = solid(&moved(&mesh, |p| std::array::from_fn(|a| p[a] - middle[a])));
        let want = MassProperties {
            center_of_mass: std::array::from_fn(|a| near.center_of_mass[a] + middle[a]),
            ..near
        };
        assert_same(&found, &want, 1.0, if name == "far" { 1e-10 } else { 1e-8 });
        assert!(
            (found.inertia[0] / found.inertia[1] - 1.0).abs() < 0.02,
            "{within}"
        );
    }
}

#[test]
fn what_is_open_or_inside_out_has_no_mass() {
    for name in ["sheet", "triangle", "curtain"] {
        let made = baked(&fixture(name), Body::default());
        assert_eq!(made.report.mass, None, "{name}");
        assert!(!made.report.warnings.iter().any(|w| w.contains("mass")));
    }
    let mut cube = boxed([0.0; 3], [1.0; 3]);
    cube.triangles.pop();
    assert_eq!(mass(&cube, Body::default()), None);
    let mut reversed = boxed([0.0; 3], [1.0; 3]);
    reversed.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let made = baked(&reversed, Body::default());
    assert_eq!(made.report.mass, None);
    let told = made
        .report
        .warnings
        .iter()
        .any(|w| w.contains("the mesh is inside out"));
    assert!(told, "{:?}", made.report.warnings);
    let json = serde_json::to_value(&made.report).expect("a report");
    assert!(json["mass"].is_null());
    // A triangle from both sides is closed, and encloses nothing.
    let folded = RawMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.3], [0.0, 1.0, 0.7]],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
        ..RawMesh::default()
    };
    assert_eq!(mass(&folded, Body::default()), None);
    // Two cubes with a common edge: four triangles meet there.
    let mut both = boxed([0.0; 3], [1.0; 3]);
    let other = boxed([1.0, 1.0, 0.0], [1.0; 3]);
    both.positions.extend(&other.positions);
    both.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + 8)));
    assert_eq!(mass(&both, Body::default()), None);
}

fn joined(parts: &[(RawMesh, bool)]) -> RawMesh {
    let mut all = RawMesh::default();
    for (mesh, reversed) in parts {
        let first = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| v + first);
            if *reversed { [a, c, b] } else { [a, b, c] }
        }));
    }
    all
}

#[test]
fn parts_add_up_and_cavities_are_left_out() {
    let (one, two) = (boxed([0.0; 3], [1.0; 3]), boxed([2.0, 0.0, 0.0], [1.0; 3]));
    let found = solid(&joined(&[(one.clone(), false), (two.clone(), false)]));
    assert!((found.mass_kg - 2000.0).abs() < 1e-9);
    assert!(apart(found.center_of_mass, [1.5, 0.5, 0.5], 1.0) < 1e-14);
    // Steiner: each cube by itself, and both a unit from the middle.
    assert!((found.inertia[1] - (2.0 * 1000.0 / 6.0 + 2000.0)).abs() < 1e-9);

    let cavity = boxed([0.25; 3], [0.5; 3]);
    let hollow = solid(&joined(&[(one.clone(), false), (cavity, true)]));
    assert!((hollow.mass_kg - 875.0).abs() < 1e-10);
    let inertia = 1000.0 / 6.0 - 125.0 * 0.25 / 6.0;
    assert!((hollow.inertia[0] - inertia).abs() < 1e-10);

    // What overlaps counts twice.
    let twice = boxed([0.5, 0.0, 0.0], [1.0; 3]);
    let found = solid(&joined(&[(one.clone(), false), (twice, false)]));
    assert!((found.mass_kg - 2000.0).abs() < 1e-9);

    // A solid less a far one has moments that no body has.
    let far = boxed([50.0, 0.0, 0.0], [0.5; 3]);
    let made = baked(&joined(&[(one, false), (far, true)]), Body::default());
    assert_eq!(made.report.mass, None);
    assert!(
        made.report
            .warnings
            .iter()
            .any(|w| w.contains("no inertia"))
    );
}

/// Texture coordinates double the vertices of the chair along a seam.
#[test]
fn seams_do_not_open_a_mesh() {
    let mesh = read_mesh(format!("{ROOT}/fixtures/chair.obj").as_ref()).expect("a chair");
    let found = solid(&mesh);
    assert!((2.2..2.4).contains(&found.mass_kg), "{found:?}");
    // Vertices of each triangle of its own, as STL files have them.
    let mut apart = RawMesh::default();
    for t in &mesh.triangles {
        let first = apart.positions.len() as u32;
        apart
            .positions
            .extend(t.map(|v| mesh.positions[v as usize]));
        apart.triangles.push([first, first + 1, first + 2]);
    }
    assert_same(&solid(&apart), &found, 1.0, 1e-15);
}
