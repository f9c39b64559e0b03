//! Masses of lattices and of elements, and the momenta of modes: those of free bodies vanish, those of held ones are
//! gravity's forces.

use bdtree_build::advise::Subject;
use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, ElasticReport, Fix, FixRegion, elastic_basis};
use bdtree_build::basis::volume::{MassMatrix, VolumeOptions};
use bdtree_build::input::RawMesh;
use bdtree_build::mass::{MassProperties, MassSource};
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Elastic, Motion, Recipe, Source, Stated, Volume};
use bdtree_build::{Baked, bake, bake_fields};
use bdtree_format::Metadata;
use bdtree_runtime::Model;

use crate::elastic_support::{V3, boxed};
use crate::volume_support::{self, block, five_tetrahedra, read_veg};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn norm(x: V3) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn solve(mesh: &RawMesh, options: &ElasticOptions) -> (Basis, ElasticReport) {
    elastic_basis(mesh, options, &Silent, &mut Vec::new()).expect("modes")
}

/// The largest |P_j| over √(m m_j), and |L_j| over that and the size: at most 1 for any motion of a body.
fn momenta_of(basis: &Basis, mass_kg: f64, size: f64) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    for mode in &basis.modes {
        let own = mode.momentum.expect("a momentum");
        let whole = (mass_kg * mode.modal_mass_kg.expect("a modal mass")).sqrt();
        largest[0] = largest[0].max(norm(own.linear) / whole);
        largest[1] = largest[1].max(norm(own.angular) / (whole * size));
    }
    largest
}

/// A free body keeps still: what its modes have of momentum is the tolerance that they are found to.
#[test]
fn modes_of_free_bodies_have_no_momentum() {
    let turned = |mesh: RawMesh| RawMesh {
        positions: (mesh.positions.iter())
            .map(|[x, y, z]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, z + 0.1 * x])
            .collect(),
        ..mesh
    };
    for mesh in [
        boxed([5.0, 6.0, 7.0], [4.0, 1.0, 0.7]),
        turned(boxed([0.0; 3], [3.0, 1.0, 0.5])),
    ] {
        let options = ElasticOptions {
            resolution: Some(12),
            ..ElasticOptions::default()
        };
        let (basis, report) = solve(&mesh, &options);
        let [linear, angular] = momenta_of(&basis, report.mass_kg, 4.0);
        println!("free lattice: {linear:.1e} {angular:.1e}");
        assert!(linear < 1e-12 && angular < 1e-12, "{linear} {angular}");
    }
    for mass in [MassMatrix::Consistent, MassMatrix::Lumped] {
        for volume in [
            block([8, 2, 2], [4.0, 1.0, 1.0]),
            five_tetrahedra(block([8, 2, 2], [4.0, 1.0, 1.0]), [8, 2, 2]),
        ] {
            let options = VolumeOptions {
                mass,
                ..VolumeOptions::default()
            };
            let (found, report) = volume_support::solve(&volume, &options);
            for mode in &found.modes {
                let own = mode.momentum.expect("a momentum");
                let whole = report.mass_kg.sqrt();
                let [linear, angular] = [norm(own.linear), norm(own.angular) / 4.0];
                assert!(
                    linear < 1e-9 * whole && angular < 1e-9 * whole,
                    "{linear} {angular}"
                );
            }
        }
    }
}

/// The first bending mode of a clamped beam: ∫ φ over its length is 0.3915 of the tip's, and its modal mass a quarter
/// of the mass; P²/(m m_1) is 0.6131 (R. D. Blevins, "Formulas for natural frequency and mode shape", 1979).
#[test]
fn gravity_bends_held_beams_as_theory_says() {
    let clamp = Fix {
        axes: [true; 3],
        region: FixRegion::Box {
            min: [-0.01, -1.0, -1.0],
            max: [0.01, 2.0, 2.0],
        },
    };
    let (length, side) = (20.0, 1.0);
    let mesh = boxed([0.0; 3], [length, side, side]);
    let options = ElasticOptions {
        mode_count: 4,
        resolution: Some(40),
        poisson: 0.0,
        fixes: vec![clamp.clone()],
        ..ElasticOptions::default()
    };
    let (basis, report) = solve(&mesh, &options);
    let first = &basis.modes[0];
    let own = first.momentum.expect("a momentum");
    let share = norm(own.linear) / report.mass_kg;
    let effective =
        norm(own.linear).powi(2) / (report.mass_kg * first.modal_mass_kg.expect("a mass"));
    println!("held lattice: {share} {effective}");
    assert!((share / 0.391_5 - 1.0).abs() < 0.02, "{share}");
    assert!((effective / 0.613_1 - 1.0).abs() < 0.01, "{effective}");
    // Across the beam; the farthest vertex moves by one.
    assert!(own.linear[0].abs() < 1e-3 * norm(own.linear));

    let volume = block([40, 2, 2], [length, side, side]);
    let held = VolumeOptions {
        mode_count: 2,
        poisson: Some(0.0),
        fixes: vec![clamp],
        ..VolumeOptions::default()
    };
    let (found, report) = volume_support::solve(&volume, &held);
    let own = found.modes[0].momentum.expect("a momentum");
    let effective = norm(own.linear).powi(2) / report.mass_kg; // modal masses are 1 kg
    println!("held volume: {effective}");
    assert!((effective / 0.613_1 - 1.0).abs() < 0.01, "{effective}");
}

/// A closed body weighs what its surface encloses; the lattice that its modes come from agrees.
#[test]
fn cells_agree_with_the_surface_that_they_fill() {
    let mesh = boxed([5.0, 6.0, 7.0], [4.0, 1.0, 0.7]);
    let mut largest = 0.0_f64;
    for resolution in [9, 16, 24] {
        let options = ElasticOptions {
            resolution: Some(resolution),
            ..ElasticOptions::default()
        };
        let (_, report) = solve(&mesh, &options);
        let cells = report.body.fallback.expect("cells");
        assert_eq!(
            (cells.source, report.body.known),
            (MassSource::Lattice, None)
        );
        assert!((cells.mass_kg / 2800.0 - 1.0).abs() < 1e-12);
        for (found, want) in cells.center_of_mass.iter().zip([7.0, 6.5, 7.35]) {
            largest = largest.max((found - want).abs() / 4.0);
        }
        let want = 2800.0 / 12.0 * (16.0 + 1.0);
        largest = largest.max((cells.inertia[2] / want - 1.0).abs());
    }
    println!("cells against the box: {largest:.1e}");
    assert!(largest < 1e-4, "{largest}");
}

fn recipe(name: &str, change: impl Fn(&mut ElasticOptions)) -> Recipe {
    let mut elastic = Elastic::default();
    elastic.options.mode_count = 4;
    elastic.options.resolution = Some(24);
    change(&mut elastic.options);
    Recipe::of_surface(format!("{ROOT}/fixtures/{name}"), Motion::Elastic(elastic))
}

/// The mass in the file, which passes its check, and whether it has momenta.
fn stored(baked: &Baked) -> (Option<MassProperties>, bool) {
    let model = Model::from_bytes(&baked.bytes).expect("a sound file");
    let asset = model.asset();
    assert!(asset.verify(&mut |error| panic!("{error}")));
    let mass = asset.mass_properties().and_then(MassProperties::of_record);
    assert_eq!(mass, baked.report.mass);
    (mass, asset.mode_momenta().is_some())
}

#[test]
fn sheets_weigh_what_their_cells_do() {
    let made = bake(&recipe("sheet.obj", |o| o.thickness = Some(0.05)), &Silent).expect("a bake");
    let (mass, has_momenta) = stored(&made);
    let mass = mass.expect("a mass");
    assert!(has_momenta);
    assert_eq!(mass.source, MassSource::Lattice);
    assert_eq!(made.report.elastic.expect("elastic").mass_kg, mass.mass_kg);
    let mesh = bdtree_fixtures::models::mesh("sheet").expect("a sheet");
    let area: f64 = (mesh.triangles.iter())
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let [u, v]: [V3; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
            0.5 * norm(std::array::from_fn(|k| {
                u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]
            }))
        })
        .sum();
    let ratio = mass.mass_kg / (1000.0 * area * 0.05);
    println!("sheet: {ratio}");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    // Rigid it has no thickness.
    let rigid = recipe("sheet.obj", |o| o.mode_count = 0);
    let made = bake(&rigid, &Silent).expect("a bake");
    assert_eq!(stored(&made), (None, false));
}

#[test]
fn closed_bodies_weigh_what_their_surface_encloses_with_momenta_of_their_modes() {
    let elastic = bake(&recipe("chair.obj", |o| o.density_kg_m3 = 600.0), &Silent).expect("a bake");
    let (mass, has_momenta) = stored(&elastic);
    let mass = mass.expect("a mass");
    assert_eq!((mass.source, has_momenta), (MassSource::Surface, true));
    assert_eq!(mass.density_kg_m3, 600.0);
    let of_cells = elastic.report.elastic.as_ref().expect("elastic").mass_kg;
    let off = of_cells / mass.mass_kg - 1.0;
    println!("cells of the chair against its surface: {off:.1e}");
    assert!(off.abs() < 1e-6, "{off}");
    let report = elastic.report.elastic.as_ref().expect("elastic");
    let cells = report.body.fallback.expect("cells");
    let [low, high] = elastic.report.bounds;
    let size = norm([0, 1, 2].map(|k| high[k] - low[k]));
    let largest = mass.inertia.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let apart = |a: &[f64], b: &[f64]| {
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    let center = apart(&cells.center_of_mass, &mass.center_of_mass) / size;
    let inertia = apart(&cells.inertia, &mass.inertia) / largest;
    println!("its center: {center:.1e} of the size, its inertia: {inertia:.1e} of the largest");
    assert!(center < 1e-4 && inertia < 1e-4, "{center} {inertia}");
    let rigid = bake(
        &recipe("chair.obj", |o| {
            o.density_kg_m3 = 600.0;
            o.mode_count = 0;
        }),
        &Silent,
    );
    assert_eq!(stored(&rigid.expect("a bake")), (Some(mass), false));
    // The same bytes with any number of threads.
    let again = bake(
        &recipe("chair.obj", |o| {
            o.density_kg_m3 = 600.0;
            o.threads = 3;
        }),
        &Silent,
    );
    assert!(again.expect("a bake").bytes == elastic.bytes);
    // The file's momenta are about its center: small, for the chair is free.
    let model = Model::from_bytes(&elastic.bytes).expect("a sound file");
    let asset = model.asset();
    for (mode, own) in asset
        .modes()
        .iter()
        .zip(asset.mode_momenta().expect("momenta"))
    {
        let whole = (mass.mass_kg * mode.modal_mass_kg.get()).sqrt();
        let [linear, angular] = [own.linear, own.angular].map(|v| norm(v.map(|x| x.get())));
        assert!(
            linear < 1e-9 * whole && angular < 1e-9 * whole,
            "{linear} {angular}"
        );
    }
}

/// What is advised on from a file weighs what the file says, also where nothing in it could tell anew.
#[test]
fn files_that_are_baked_again_keep_mass_and_momenta() {
    let sheet = bake(&recipe("sheet.obj", |o| o.thickness = Some(0.05)), &Silent).expect("a bake");
    let chair = bake(&recipe("chair.obj", |o| o.resolution = Some(12)), &Silent).expect("a bake");
    for made in [sheet, chair] {
        let model = Model::from_bytes(&made.bytes).expect("a sound file");
        let own = Subject::of_asset(model.asset()).expect("a subject");
        let (settings, provenance) = (&own.settings, &own.provenance);
        let again = bake_fields(&own.mesh, &own.basis, settings, provenance, &Silent);
        let again = again.expect("a bake");
        assert_eq!(stored(&again), stored(&made));
        let again = Model::from_bytes(&again.bytes).expect("a sound file");
        assert_eq!(again.asset().mode_momenta(), model.asset().mode_momenta());
    }
}

/// Options that only a mass uses are of no use without one.
#[test]
fn density_without_a_mass_causes_a_warning() {
    for (name, is_used) in [("sheet.obj", false), ("cube.obj", true)] {
        let mut rigid = Recipe::of_surface(format!("{ROOT}/fixtures/{name}"), Motion::Rigid);
        rigid.settings.body.density_kg_m3 = 7.5;
        rigid.stated = vec![Stated {
            option: "--density",
            kinds: &[Stated::MASS],
        }];
        let made = bake(&rigid, &Silent).expect("a bake");
        let density = made.report.mass.map(|mass| mass.density_kg_m3);
        assert_eq!(density, is_used.then_some(7.5));
        let told = "--density is not used: the mesh encloses no volume that could have a mass";
        let warned = made.report.warnings.iter().any(|w| w == told);
        assert_eq!(warned, !is_used, "{:?}", made.report.warnings);
        let metadata = Model::from_bytes(&made.bytes).expect("a sound file");
        let metadata = Metadata::from_bytes(metadata.asset().metadata()).expect("metadata");
        assert_eq!(
            metadata.settings.get("density").map(String::as_str),
            Some("7.5")
        );
    }
}

/// An inside-out body vibrates all the same; its mass is that of the cells.
#[test]
fn inside_out_bodies_weigh_what_their_cells_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("box.obj");
    let mesh = boxed([0.0; 3], [3.0, 1.0, 1.0]);
    let vertices = mesh
        .positions
        .iter()
        .map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| v + 1);
        format!("f {a} {c} {b}\n")
    });
    std::fs::write(&path, vertices.chain(faces).collect::<String>()).expect("written");
    let mut elastic = Elastic::default();
    elastic.options.resolution = Some(9);
    elastic.options.mode_count = 2;
    let made = bake(
        &Recipe::of_surface(&path, Motion::Elastic(elastic)),
        &Silent,
    )
    .expect("a bake");
    let (mass, has_momenta) = stored(&made);
    let mass = mass.expect("a mass");
    assert_eq!((mass.source, has_momenta), (MassSource::Lattice, true));
    assert!((mass.mass_kg / 3000.0 - 1.0).abs() < 1e-9);
    let told = made
        .report
        .warnings
        .iter()
        .any(|w| w.contains("inside out"));
    assert!(told, "{:?}", made.report.warnings);
}

#[test]
fn volumes_weigh_what_their_elements_do() {
    let path = format!("{ROOT}/fixtures/beam_tets.veg");
    let volume = |modes: usize, density: Option<f64>| {
        let mut options = VolumeOptions {
            mode_count: modes,
            density_kg_m3: density,
            ..VolumeOptions::default()
        };
        options.scale_m = 0.5;
        bake(
            &Recipe::new(Source::Volume(Volume {
                path: path.clone().into(),
                surface: None,
                options,
                range_rel: None,
            })),
            &Silent,
        )
        .expect("a bake")
    };
    let raw = read_veg(path.as_ref());
    let elements: Vec<[V3; 4]> = (raw.tetrahedra.iter())
        .map(|own| own.map(|n| raw.nodes[n as usize]))
        .collect();
    assert_eq!(elements.len(), 192);
    let (mut whole, mut first, mut second) = (0.0, [0.0; 3], 0.0);
    for p in &elements {
        let [a, b, c]: [V3; 3] = [1, 2, 3].map(|k| std::array::from_fn(|i| p[k][i] - p[0][i]));
        let six = a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        let v = six / 6.0;
        whole += v;
        for i in 0..3 {
            first[i] += v / 4.0 * p.iter().map(|x| x[i]).sum::<f64>();
        }
        let sum: f64 = p.iter().map(|x| x[0]).sum();
        second += v / 20.0 * (sum * sum + p.iter().map(|x| x[0] * x[0]).sum::<f64>());
    }
    let made = volume(2, Some(1250.0));
    let (mass, has_momenta) = stored(&made);
    let mass = mass.expect("a mass");
    assert_eq!((mass.source, has_momenta), (MassSource::Elements, true));
    assert!((mass.mass_kg / (1250.0 * whole * 0.125) - 1.0).abs() < 1e-12);
    assert!((mass.volume / whole - 1.0).abs() < 1e-12);
    for i in 0..3 {
        assert!((mass.center_of_mass[i] - first[i] / whole).abs() < 1e-13);
    }
    // ∫ x² about the center from yy + zz − xx.
    let along = 0.5 * (mass.inertia[1] + mass.inertia[2] - mass.inertia[0]);
    let want = 1250.0 * 0.125 * (second - first[0] * first[0] / whole);
    assert!((along / want - 1.0).abs() < 1e-12);
    assert!((mass.density_kg_m3 / 1250.0 - 1.0).abs() < 1e-12);
    // Without modes the elements are the same.
    assert_eq!(stored(&volume(0, Some(1250.0))), (Some(mass), false));
    // The file's own materials.
    let own = volume(0, None).report.mass.expect("a mass");
    assert!(own.density_kg_m3 > 0.0 && own.density_kg_m3 != 1250.0);
}
