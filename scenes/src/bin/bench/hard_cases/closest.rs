//! Distances of points near a mesh, against rational arithmetic on the mesh as given in f64.

use std::error::Error;

use bdtree_build::input::RawMesh;
use bdtree_fixtures::oracle::exact;
use bdtree_fixtures::poses::rng;
use bdtree_runtime::narrow::closest_point;
use rand::RngExt;

use super::fixture;
use super::libraries::{Given, entries};

const MESHES: [(&str, &str); 9] = [
    ("ball", "icosphere"),
    ("slivers and zero area", "slivers"),
    ("duplicate triangles and vertices", "duplicates"),
    ("too many triangles per edge", "non_manifold"),
    ("touching and coplanar", "touching"),
    ("all on one line", "line"),
    ("size 1e-6", "tiny"),
    ("1e6 away", "far"),
    ("1e8 away", "far_8"),
];

fn size(mesh: &RawMesh) -> f64 {
    let extent = |k: usize| {
        let all = mesh.positions.iter().map(|p| p[k]);
        all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
    };
    extent(0).max(extent(1)).max(extent(2))
}

/// One row per mesh.
pub(super) fn table(count: usize) -> Result<(), Box<dyn Error>> {
    for (name, fixture_name) in MESHES {
        let mesh = fixture(fixture_name)?;
        let size = size(&mesh);
        let corner = |v: u32| mesh.positions[v as usize];
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        let given = Given::new(mesh.clone());
        let (mut row, mut points) = (Vec::new(), Vec::new());
        let mut rng = rng(11);
        for i in 0..count {
            // On a corner but for rounding, near, far.
            let away = size * [1e-7, 0.1, 2.0][i % 3];
            let from = triangles[i * 7 % triangles.len()][i % 3];
            points.push(from.map(|x| x + away * rng.random_range(-1.0..1.0)));
        }
        // f64 only says which triangles are worth the exact arithmetic.
        let exactly = |p: &[f64; 3]| {
            let near = triangles.iter().map(|t| closest_point(*p, t).distance);
            let near = near.fold(f64::INFINITY, f64::min);
            exact::distance(*p, &triangles, near)
        };
        let distances: Vec<f64> = points.iter().map(exactly).collect();
        for entry in entries() {
            let mut library = match (entry.build)(&given) {
                Ok(library) => library,
                Err(error) => {
                    row.push(error);
                    continue;
                }
            };
            let mut worst = Some(0.0_f64);
            for (p, expected) in points.iter().zip(&distances) {
                worst = match (worst, library.closest(*p)) {
                    (Some(worst), Some(found)) => Some(worst.max((found - expected).abs() / size)),
                    _ => None,
                };
            }
            row.push(worst.map_or("not measured: no such question".into(), |w| {
                format!("{w:.1e}")
            }));
        }
        println!("| {name} | {} |", row.join(" | "));
    }
    Ok(())
}
