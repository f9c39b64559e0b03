//! Every deformed vertex lies in every sphere above it, as each kernel computes both, for
//! ordinary and adversarial q: the property that makes a query miss nothing.
//!
//! `BDTREE_STRESS_CASES=100000000 cargo test --release -p bdtree-tests --test all -- --nocapture containment::`
//! tries more (docs/design/guarantees.md).

use std::mem::size_of;

use bdtree_build::basis::Basis;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::{bake, models, mutate, poses};
use bdtree_format::{ROW_RADIUS, Row, SectionKind};
use bdtree_runtime::{Model, Transform};
use bdtree_tools::stress::{self, Options, Report};

fn no_progress(_: u64) {}

fn sound(report: &Report, what: &str) {
    if let Some(tight) = report.violations.first() {
        panic!("{what}: {tight:?} and {} more", report.violations.len() - 1);
    }
    assert_eq!(report.unbounded, 0, "{what}: spheres without a radius");
}

/// A field that shrinks the whole object: at q = 1 it is a point, where all terms under the root
/// cancel.
fn shrinking(mesh: &RawMesh) -> Basis {
    let mut basis = bake::smooth_basis(mesh, 1, 1);
    for (u, p) in basis.fields.iter_mut().zip(&mesh.positions) {
        *u = p.map(|c| -c);
    }
    basis
}

fn moved(mesh: &RawMesh, by: f64, scale: f64) -> RawMesh {
    let mut mesh = mesh.clone();
    for p in &mut mesh.positions {
        *p = [scale * p[0] + by, scale * p[1] - by, scale * p[2]];
    }
    mesh
}

/// No modes, one, many; all of them everywhere, or some; beside the origin, far from it, tiny.
fn assets() -> Vec<(&'static str, Model)> {
    let (small, large) = (bake::bumpy_sphere(6, 2), bake::bumpy_sphere(12, 1));
    let smooth = |mesh: &RawMesh, m, seed| bake::baked(mesh, &bake::smooth_basis(mesh, m, seed));
    let local = |mesh: &RawMesh, m| bake::baked(mesh, &bake::local_basis(mesh, m, 3));
    vec![
        ("rigid", bake::baked(&small, &bake::rigid(&small))),
        ("1 mode", smooth(&small, 1, 2)),
        ("10 modes", smooth(&large, 10, 1)),
        ("64 modes", smooth(&small, 64, 3)),
        ("20 local modes", local(&bake::bumpy_sphere(10, 2), 20)),
        ("shrinking", bake::baked(&large, &shrinking(&large))),
        // The origin is that of the mesh: positions about it are not small.
        ("aside", smooth(&moved(&small, 1.5, 1.0), 8, 6)),
        ("far", smooth(&moved(&small, 1e6, 1.0), 5, 6)),
        ("tiny", smooth(&moved(&small, 0.0, 1e-7), 5, 6)),
        ("huge", smooth(&moved(&small, 0.0, 1e9), 5, 6)),
    ]
}

#[test]
fn vertices_stay_in_every_sphere_above_them() {
    let cases: u64 = match std::env::var("BDTREE_STRESS_CASES") {
        Ok(text) => text.parse().expect("BDTREE_STRESS_CASES is a number"),
        Err(_) => 4_000_000,
    };
    let assets = assets();
    let mut tried = 0;
    for (seed, (name, model)) in (0..).zip(&assets) {
        let asset = model.asset();
        let options = Options {
            cases: cases / assets.len() as u64,
            seed,
        };
        let report = stress::run(asset, options, &no_progress).expect("a sound file");
        assert_eq!(report.cases, options.cases);
        sound(&report, name);
        let tightest = report.tightest.as_ref().expect("a vertex").margin_slacks;
        let slack = stress::rounding_slack(asset, seed).expect("a sound file");
        println!(
            "{name}: {} cases, {} q, {} vertices, {tightest:.4} slacks left, rounding slack {slack:.1e}",
            report.cases, report.poses, report.vertices
        );
        tried += report.cases;
    }
    println!("{tried} cases");
}

#[test]
fn hard_q_by_hand() {
    for (name, model) in assets() {
        let asset = model.asset();
        for q in poses::hard_qs(asset) {
            sound(&stress::at(asset, &q).expect("a sound file"), name);
        }
    }
}

/// The rounding slack where people use it: below a thousandth of the mean radius. Also with few and
/// with many modes, of sheets and of bodies: with one part of q̃, just before there are two, and with two.
#[test]
fn the_rounding_slack_is_small() {
    let mut checked = assets();
    for file in ["chair", "curtain", "torus"] {
        let mesh = read_mesh(&models::path(file)).expect("a fixture");
        for m in [6, 10, 12, 14, 16, 20, 40] {
            let mut basis = bake::smooth_basis(&mesh, m, 1);
            basis.set_ranges(0.05 * mesh.diagonal()); // the builder's default
            checked.push((file, bake::baked(&mesh, &basis)));
        }
    }
    for (name, model) in checked {
        let asset = model.asset();
        let cost = stress::rounding_slack(asset, 1).expect("a sound file");
        println!("{name}, {} modes: {cost:.1e}", asset.mode_count());
        assert!(cost > 0.0 && cost < 1e-3, "{name}: {cost}");
    }
}

#[test]
fn a_body_that_shrinks_to_a_point_stays_inside() {
    let mesh = bake::bumpy_sphere(10, 3);
    let model = bake::baked(&mesh, &shrinking(&mesh));
    let asset = model.asset();
    for q in [0.5, 0.9, 0.999, 0.999_999, 1.0, 1.000_001, 1.1, 2.0] {
        sound(&stress::at(asset, &[q]).expect("a sound file"), "shrinking");
    }
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&[1.0], Transform::IDENTITY, &mut memory);
    let spheres = pose.expect("pose").node_spheres(0).expect("node");
    let largest = spheres.radius.iter().copied().fold(0.0, f32::max);
    // The paper's bound is 2 R ≈ 2 here; ours is exact up to the root of the rounding terms, of which
    // Ū's is the largest: half a unit, 2⁻¹⁶ of the largest Ū.
    assert!(largest < 0.03, "{largest}");
}

/// The run finds a single radius that is too small by a hundred-thousandth.
#[test]
fn a_radius_that_is_too_small_is_found() {
    let mesh = bake::bumpy_sphere(6, 2);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 2));
    let options = Options {
        cases: 20_000,
        seed: 0,
    };
    let asset = model.asset();
    let bytes = asset.bytes();
    sound(
        &stress::run(asset, options, &no_progress).expect("run"),
        "whole",
    );
    let rows = mutate::section(bytes, SectionKind::ROWS).start;
    let node = asset.node_count() - 1;
    let record = asset.nodes()[node];
    let lane = record.leaf_mask.trailing_zeros() as usize;
    let at = rows
        + size_of::<Row>() * (record.row_start as usize + ROW_RADIUS)
        + size_of::<f32>() * lane;
    let radius = mutate::get_f32(bytes, at);
    let mut damaged = bytes.to_vec();
    mutate::put(&mut damaged, at, &(radius * 0.99999).to_le_bytes());
    let damaged = Model::from_bytes(&damaged).expect("open");
    let asset = damaged.asset();
    let report = stress::run(asset, options, &no_progress).expect("run");
    let tight = report.violations.first().expect("a vertex outside");
    assert_eq!((tight.node as usize, tight.lane), (node, lane));
    assert!(tight.margin_slacks < 0.0 && report.tightest.expect("one").margin_slacks < 0.0);
}

/// Numbers that are none, where files should have some: a vertex lies in nothing, a sphere holds nothing.
#[test]
fn what_is_not_a_number_is_found() {
    let mesh = bake::bumpy_sphere(6, 2);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 2));
    let bytes = model.asset().bytes();
    let nan = f32::NAN.to_le_bytes();
    let positions = mutate::section(bytes, SectionKind::POSITIONS).start;
    let rows = mutate::section(bytes, SectionKind::ROWS).start;
    for (at, in_positions) in [
        (positions, true),
        (rows + size_of::<Row>() * ROW_RADIUS, false),
    ] {
        let mut damaged = bytes.to_vec();
        mutate::put(&mut damaged, at, &nan);
        let damaged = Model::from_bytes(&damaged).expect("open");
        let asset = damaged.asset();
        let report = stress::at(asset, &[0.01, -0.02, 0.0]).expect("a sound tree");
        assert_eq!(!report.violations.is_empty(), in_positions);
        assert_eq!(report.unbounded > 0, !in_positions);
        let tightest = report.tightest.expect("a vertex").margin_slacks;
        assert_eq!(tightest == f64::NEG_INFINITY, in_positions);
    }
}

/// The same seed gives the same report, whoever did which part.
#[test]
fn a_run_can_be_repeated() {
    let mesh = bake::bumpy_sphere(6, 2);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 2));
    let asset = model.asset();
    let run = |seed| {
        let options = Options {
            cases: 12_345,
            seed,
        };
        stress::run(asset, options, &no_progress).expect("run")
    };
    let first = run(1);
    assert_eq!(first.cases, 12_345);
    assert_eq!(first, run(1));
    assert_ne!(first.tightest, run(2).tightest);
}
