//! Modes of the corpus's volume meshes against the answers known for them.

mod volume_support;

use bdtree_build::basis::elastic::{Fix, FixRegion};
use bdtree_build::basis::volume::{MassMatrix, VolumeOptions};
use volume_support::{hertz, read_veg, solve};

/// All eighty frequencies of the beam: the same elements and mass matrices in another code.
#[test]
fn beam_of_tetrahedra_has_its_known_frequencies() {
    let name = "beam_of_tetrahedra_has_its_known_frequencies";
    let file = |f: &str| bdtree_tests::corpus::path(name, &format!("modal/beam3_tet.{f}"));
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
