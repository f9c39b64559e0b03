//! Equal eigenvalues, and lattices that are nearly rigid or nearly fall apart. Of equal frequencies the
//! space of the modes is compared, not the modes: it is kept by every symmetry of the body.

use crate::volume_support::{V3, bar, block, hertz, run, solve, steel};
use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::basis::volume::VolumeOptions;
use bdtree_build::input::RawMesh;
use bdtree_build::input::volume::{RawMaterial, RawVolume};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models;

type Field = Vec<V3>;

/// The 48 symmetries of a cube: axes in another order, with signs.
fn symmetries() -> Vec<([usize; 3], V3)> {
    let orders = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    let sign = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { -1.0 } else { 1.0 });
    let of = |order| (0..8).map(move |bits| (order, sign(bits)));
    orders.into_iter().flat_map(of).collect()
}

fn turned((order, sign): ([usize; 3], V3), p: V3) -> V3 {
    [0, 1, 2].map(|k| sign[k] * p[order[k]])
}

/// Where each vertex goes under a symmetry about the middle, if the body is one of those it keeps.
fn images(points: &[V3], symmetry: ([usize; 3], V3)) -> Option<Vec<usize>> {
    let count = points.len() as f64;
    let middle = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count);
    let from = |p: &V3| [0, 1, 2].map(|k| p[k] - middle[k]);
    let key = |p: V3| p.map(|x| (x * 1e6).round() as i64);
    let places: std::collections::HashMap<_, _> = points
        .iter()
        .enumerate()
        .map(|(i, p)| (key(from(p)), i))
        .collect();
    points
        .iter()
        .map(|p| places.get(&key(turned(symmetry, from(p)))).copied())
        .collect()
}

fn dot(a: &Field, b: &Field) -> f64 {
    a.iter()
        .zip(b)
        .map(|(u, v)| u[0] * v[0] + u[1] * v[1] + u[2] * v[2])
        .sum()
}

fn less(a: &mut Field, s: f64, b: &Field) {
    for (u, v) in a.iter_mut().zip(b) {
        for k in 0..3 {
            u[k] -= s * v[k];
        }
    }
}

/// Ends of runs of equal frequencies; the last one, which the request may cut, is left out.
fn multiplets(frequencies: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut all = Vec::new();
    let mut start = 0;
    for i in 1..frequencies.len() {
        if frequencies[i] / frequencies[i - 1] - 1.0 > 1e-6 {
            all.push(start..i);
            start = i;
        }
    }
    all
}

/// How far, relatively, a symmetry takes any mode out of the space of its frequency; and how many
/// symmetries there are.
fn worst_escape(points: &[V3], modes: &[Field], frequencies: &[f64]) -> (f64, usize) {
    let (mut worst, mut count) = (0.0_f64, 0);
    for symmetry in symmetries() {
        let Some(images) = images(points, symmetry) else {
            continue;
        };
        count += 1;
        for multiplet in multiplets(frequencies) {
            let mut basis: Vec<Field> = Vec::new();
            for mode in &modes[multiplet.clone()] {
                let mut own = mode.clone();
                for _ in 0..2 {
                    for b in &basis {
                        let share = dot(&own, b);
                        less(&mut own, share, b);
                    }
                }
                let length = dot(&own, &own).sqrt();
                basis.push(own.iter().map(|u| u.map(|x| x / length)).collect());
            }
            for mode in &modes[multiplet] {
                let mut image = vec![[0.0; 3]; points.len()];
                for (i, u) in mode.iter().enumerate() {
                    image[images[i]] = turned(symmetry, *u);
                }
                let whole = dot(&image, &image).sqrt();
                for b in &basis {
                    let share = dot(&image, b);
                    less(&mut image, share, b);
                }
                worst = worst.max(dot(&image, &image).sqrt() / whole);
            }
        }
    }
    (worst, count)
}

#[test]
fn symmetries_keep_the_spaces_of_equal_frequencies() {
    for (name, volume, expected) in [("cube", block([4; 3], [1.0; 3]), 48), ("bar", bar(), 16)] {
        let (found, _) = solve(&volume, &steel(24));
        let fields: Vec<Field> = found.modes.iter().map(|m| m.field.clone()).collect();
        let frequencies = hertz(&found);
        let sizes: Vec<usize> = multiplets(&frequencies).iter().map(|m| m.len()).collect();
        let (worst, count) = worst_escape(&volume.nodes, &fields, &frequencies);
        println!(
            "{name}: multiplets {sizes:?}, {count} symmetries, out of the space by {worst:.1e}"
        );
        assert_eq!(count, expected);
        assert!(
            sizes.iter().any(|n| *n > 1) && worst < 1e-6,
            "{name}: {worst:e}"
        );
        // A request that cuts a multiplet gets the first of it, up to sign.
        let (few, _) = solve(&volume, &steel(4));
        for (a, b) in few.modes.iter().zip(&found.modes) {
            let mut difference = a.field.clone();
            let sign = dot(&a.field, &b.field).signum();
            less(&mut difference, sign, &b.field);
            let off = (dot(&difference, &difference) / dot(&b.field, &b.field)).sqrt();
            assert!(off < 1e-6, "{name}: {off:e}");
        }
    }
}

#[test]
fn surfaces_of_symmetric_bodies_do_too() {
    let cube = models::mesh("cube").expect("a fixture");
    let mesh = RawMesh {
        positions: cube.positions,
        triangles: cube.triangles,
        ..RawMesh::default()
    };
    for resolution in [1, 4, 9] {
        let options = ElasticOptions {
            mode_count: 15,
            resolution: Some(resolution),
            ..ElasticOptions::default()
        };
        let (basis, _) = elastic_basis(&mesh, &options, &Silent, &mut Vec::new()).expect("modes");
        let fields: Vec<Field> = (0..15).map(|j| basis.field(j).to_vec()).collect();
        let omegas: Vec<f64> = basis
            .modes
            .iter()
            .map(|m| m.omega_rad_s.expect("ω"))
            .collect();
        let sizes: Vec<usize> = multiplets(&omegas).iter().map(|m| m.len()).collect();
        let (worst, count) = worst_escape(&mesh.positions, &fields, &omegas);
        println!("cells {resolution}: multiplets {sizes:?}, out of the space by {worst:.1e}");
        assert_eq!(count, 48);
        assert!(worst < 1e-6, "{worst:e}");
    }
}

/// Three cubes in a row, the middle one of a material of `ratio` times the stiffness.
fn row(ratio: f64) -> RawVolume {
    let mut volume = block([6, 2, 2], [3.0, 1.0, 1.0]);
    let material = |young_pa| RawMaterial {
        name: None,
        young_pa,
        poisson: 0.3,
        density_kg_m3: 1000.0,
    };
    volume.materials = vec![material(1e9), material(1e9 * ratio)];
    volume.material_of = (0..24)
        .map(|i| u32::from((2..4).contains(&(i % 6))))
        .collect();
    volume
}

fn modes(count: usize) -> VolumeOptions {
    VolumeOptions {
        mode_count: count,
        ..VolumeOptions::default()
    }
}

/// The softer the middle, the more the ends move like rigid bodies: frequencies fall with the root of
/// its stiffness, until rounding hides them and the solver says so.
#[test]
fn bodies_that_nearly_fall_apart() {
    let reference = run(&row(1e-4), &modes(6)).expect("modes");
    for ratio in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14] {
        match run(&row(ratio), &modes(6)) {
            Ok(found) => {
                let off = found
                    .iter()
                    .zip(&reference)
                    .map(|(f, r)| f / r / (ratio / 1e-4_f64).sqrt() - 1.0);
                let off = off.fold(0.0, |m: f64, x| m.max(x.abs()));
                println!("{ratio:e}: off the root law by {off:.1e}");
                assert!(off < 1e-2, "{ratio:e}: {off}");
            }
            Err(error) => {
                println!("{ratio:e}: {error}");
                assert!(ratio < 1e-8, "{ratio:e}: {error}");
                assert_eq!(error.problems.len(), 1);
            }
        }
    }
}

/// The stiffer the middle, the less it matters how stiff.
#[test]
fn bodies_with_a_nearly_rigid_part() {
    let reference = run(&row(1e5), &modes(6)).expect("modes");
    for ratio in [1e6, 1e7, 1e8, 1e9, 1e10, 1e12, 1e14] {
        match run(&row(ratio), &modes(6)) {
            Ok(found) => {
                let off = found.iter().zip(&reference).map(|(f, r)| f / r - 1.0);
                let off = off.fold(0.0, |m: f64, x| m.max(x.abs()));
                println!("{ratio:e}: off those of 1e5 by {off:.1e}");
                assert!(off < 1e-3, "{ratio:e}: {off}");
            }
            Err(error) => {
                println!("{ratio:e}: {error}");
                assert!(ratio > 1e9, "{ratio:e}: {error}");
                assert_eq!(error.problems.len(), 1);
            }
        }
    }
}
