//! Modes of the corpus's volume meshes against the answers known for them.

use crate::volume_support::{hertz, of, read_veg, solve};
use bdtree_build::basis::elastic::{Fix, FixRegion};
use bdtree_build::basis::volume::{MassMatrix, VolumeOptions};
use bdtree_build::input::volume::RawVolume;
use nalgebra::DMatrix;

/// All eighty frequencies of the beam: the same elements and mass matrices in another code.
#[test]
fn beam_of_tetrahedra_has_its_known_frequencies() {
    let name = "beam_of_tetrahedra_has_its_known_frequencies";
    let file = |f: &str| bdtree_fixtures::corpus::path(name, &format!("modal/beam3_tet.{f}"));
    let (Some(mesh), Some(known)) = (file("veg"), file("frequencies.txt")) else {
        return;
    };
    let volume = read_veg(&mesh);
    assert_eq!((volume.nodes.len(), volume.tetrahedra.len()), (208, 450));
    let known = std::fs::read_to_string(known).unwrap();
    let mut worst = 0.0f64;
    for case in ["free", "clamped"] {
        for (mass, matrix) in [
            ("consistent", MassMatrix::Consistent),
            ("lumped", MassMatrix::Lumped),
        ] {
            let mut options = VolumeOptions {
                mode_count: 20,
                mass: matrix,
                ..VolumeOptions::default()
            };
            if case == "clamped" {
                options.fixes.push(Fix {
                    axes: [true; 3],
                    region: FixRegion::List(file("fixed.txt").unwrap()),
                });
            }
            let (modes, report) = solve(&volume, &options);
            assert!(report.inertia_checked);
            assert!((report.mass_kg / 4.8 - 1.0).abs() < 1e-9);
            let want: Vec<f64> = known
                .lines()
                .filter(|l| l.starts_with(&format!("{case} {mass} ")))
                .map(|l| l.split(' ').nth(3).unwrap().parse().unwrap())
                .collect();
            assert_eq!(want.len(), 20);
            for (f, want) in hertz(&modes).iter().zip(&want) {
                worst = worst.max((f / want - 1.0).abs());
            }
            println!("{case} {mass}: worst so far {worst:.1e}, {report:?}");
        }
    }
    // The answers have eight digits.
    assert!(worst < 1e-7, "{worst}");
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(' ').filter_map(|w| w.parse().ok()).collect()
}

/// The tetrahedra of a legacy VTK file.
fn read_vtk(text: &str) -> RawVolume {
    let table = |name: &str| {
        let mut lines = text.lines().skip_while(|l| !l.starts_with(name));
        let count = lines.next().and_then(|l| l.split(' ').nth(1)).unwrap();
        let rows = lines.take(count.parse().unwrap()).map(numbers);
        rows.collect::<Vec<_>>()
    };
    RawVolume {
        nodes: table("POINTS").iter().map(|p| [p[0], p[1], p[2]]).collect(),
        tetrahedra: table("CELLS")
            .iter()
            .map(|c| [1, 2, 3, 4].map(|k| c[k] as u32))
            .collect(),
        ..RawVolume::default()
    }
}

/// Bullet's torus as a solid. Its own spectrum is that of a network of bars along the edges (a unit
/// test of `elastic` computes that one to 1e-12), so a solid of the same shape agrees as far as
/// a foam of bars is one: Poisson's ratio 1/4, and a density that follows the edges.
#[test]
fn bullet_torus_is_nearly_a_solid() {
    let name = "bullet_torus_is_nearly_a_solid";
    let file = |f: &str| bdtree_fixtures::corpus::path(name, &format!("modal/bullet_torus.{f}"));
    let (Some(mesh), Some(values), Some(modes)) =
        (file("vtk"), file("eigenvalues.txt"), file("modes.f64"))
    else {
        return;
    };
    let volume = read_vtk(&std::fs::read_to_string(mesh).unwrap());
    assert_eq!((volume.nodes.len(), volume.tetrahedra.len()), (1036, 4436));
    let text = std::fs::read_to_string(values).unwrap();
    let known: Vec<f64> = text.lines().skip(1).flat_map(numbers).collect();
    let (known, masses) = known.split_at(40);
    let options = VolumeOptions {
        mass: MassMatrix::Lumped,
        ..of(1.0, 0.25, 1.0, 40)
    };
    let (ours, _) = solve(&volume, &options);
    // One common factor, for the units; then the largest deviation of the first modes.
    for (count, tolerance) in [(10, 0.032), (40, 0.08)] {
        let ratios: Vec<f64> = (ours.modes.iter().zip(known))
            .map(|(m, known)| (m.omega_rad_s / known.sqrt()).ln())
            .take(count)
            .collect();
        let mean = ratios.iter().sum::<f64>() / count as f64;
        let worst = ratios.iter().map(|r| (r - mean).exp() - 1.0);
        let worst = worst.fold(0.0f64, |w, r| w.max(r.abs()));
        println!("first {count}: within {:.1} %", 100.0 * worst);
        assert!(worst < tolerance);
    }
    // Largest angle between the spaces of the first modes, by the given masses.
    let bytes = std::fs::read(modes).unwrap();
    let given = |i: usize, j: usize| {
        let at = 4 + 8 * (j * 3 * masses.len() + i);
        f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) * masses[i / 3].sqrt()
    };
    for (count, tolerance) in [(2, 4.0), (5, 5.0), (10, 9.0)] {
        let given = DMatrix::from_fn(3 * masses.len(), count, given);
        let own = DMatrix::from_fn(3 * masses.len(), count, |i, j| {
            ours.modes[j].field[i / 3][i % 3] * masses[i / 3].sqrt()
        });
        let cosines = (given.transpose() * own.qr().q()).singular_values();
        let angle = cosines.min().min(1.0).acos().to_degrees();
        println!("first {count}: {angle:.1} degrees");
        assert!(angle < tolerance);
    }
}

/// The bridge's cage: its demo's modes are of another cage and material, so only what must be.
#[test]
fn bridge_of_hexahedra_has_modes() {
    let name = "bridge_of_hexahedra_has_modes";
    let Some(path) = bdtree_fixtures::corpus::path(name, "modal/bridge_hex.veg") else {
        return;
    };
    let volume = read_veg(&path);
    assert_eq!((volume.nodes.len(), volume.hexahedra.len()), (3923, 1736));
    let mut lowest = Vec::new();
    for fixes in [
        vec![],
        vec!["xyz:-11,-1,-2,-10.2,4,2", "xyz:10.2,-1,-2,11,4,2"],
    ] {
        let options = VolumeOptions {
            mode_count: 20,
            fixes: fixes.iter().map(|f| f.parse().unwrap()).collect(),
            ..VolumeOptions::default()
        };
        let (modes, report) = solve(&volume, &options);
        println!("{:.4?} {report:?}", hertz(&modes));
        assert!(report.inertia_checked && report.components == 1);
        // Every cell is a cube of 0.2511 m.
        assert!(
            (report.mass_kg / (1736.0 * 0.251_086_956_522f64.powi(3) * 1000.0) - 1.0).abs() < 1e-6
        );
        lowest.push(hertz(&modes)[0]);
    }
    // As measured; a bridge held at its ends sways more slowly than a free one wobbles.
    assert!((lowest[0] / 0.2440 - 1.0).abs() < 1e-3 && (lowest[1] / 0.1291 - 1.0).abs() < 1e-3);
}
