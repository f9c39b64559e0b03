//! Distances of points near a mesh, against rational arithmetic on the mesh as given in f64.

use bdtree_build::input::RawMesh;
use bdtree_fixtures::oracle::exact;
use bdtree_fixtures::poses::rng;
use bdtree_runtime::narrow::closest_point;

use super::fixture;
use super::libraries::answers;

use crate::prelude::*;

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
pub(super) fn rows(count: usize) -> Result<Vec<Row>> {
    let row = |(name, fixture_name): (&str, &str)| {
        let mesh = fixture(fixture_name)?;
        let size = size(&mesh);
        let corner = |v: u32| mesh.positions[v as usize];
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        let mut rng = rng(11);
        let point = |i: usize| {
            // On a corner but for rounding, near, far.
            let away = size * [1e-7, 0.1, 2.0][i % 3];
            let from = triangles[i * 7 % triangles.len()][i % 3];
            from.map(|x| x + away * rng.random_range(-1.0..1.0))
        };
        let points: Vec<[f64; 3]> = (0..count).map(point).collect();
        // f64 only says which triangles are worth the exact arithmetic.
        let exactly = |p: &[f64; 3]| {
            let near = triangles.iter().map(|t| closest_point(*p, t).distance);
            let near = near.fold(f64::INFINITY, f64::min);
            exact::distance(*p, &triangles, near)
        };
        let distances: Vec<f64> = points.iter().map(exactly).collect();
        Ok(answers(name, &mesh, |library| {
            let off = |(p, expected): (&[f64; 3], &f64)| {
                let found = library.closest(*p)?;
                Some((found - expected).abs() / size)
            };
            let errors: Option<Vec<f64>> = points.iter().zip(&distances).map(off).collect();
            errors.map_or("not measured: no such question".into(), |errors| {
                format!("{:.1e}", errors.into_iter().fold(0.0, f64::max))
            })
        }))
    };
    MESHES.into_iter().map(row).collect()
}
