//! What several tests measure: volumes of elements, and of what a surface encloses.

use bdtree_build::input::RawMesh;
use bdtree_build::input::volume::{RawVolume, parse_volume};

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Reads a text under the name `name`.
pub(crate) fn parse(name: &str, text: &str) -> Result<RawVolume, String> {
    parse_volume(text.as_bytes(), name).map_err(|e| e.to_string())
}

/// x(ξ) of a hexahedron.
pub(crate) fn trilinear(corners: &[[f64; 3]; 8], [s, t, u]: [f64; 3]) -> [f64; 3] {
    let weights = [
        (1.0 - s) * (1.0 - t) * (1.0 - u),
        s * (1.0 - t) * (1.0 - u),
        s * t * (1.0 - u),
        (1.0 - s) * t * (1.0 - u),
        (1.0 - s) * (1.0 - t) * u,
        s * (1.0 - t) * u,
        s * t * u,
        (1.0 - s) * t * u,
    ];
    [0, 1, 2].map(|a| (0..8).map(|i| weights[i] * corners[i][a]).sum())
}

/// Volumes of all elements, tetrahedra first: determinants, and for hexahedra the sum over the 2 × 2 × 2
/// Gauss points, exact for trilinear maps.
pub(crate) fn volumes(volume: &RawVolume) -> Vec<f64> {
    let place = |node: u32| volume.nodes[node as usize];
    let tetrahedra = volume.tetrahedra.iter().map(|corners| {
        let [a, b, c, d] = corners.map(place);
        dot(cross(sub(b, a), sub(c, a)), sub(d, a)) / 6.0
    });
    let gauss = [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()];
    let hexahedra = volume.hexahedra.iter().map(|corners| {
        let corners = corners.map(place);
        let points = (0..8).map(|i| [gauss[i % 2], gauss[i / 2 % 2], gauss[i / 4]]);
        let jacobians = points.map(|xi| {
            let column = |a: usize| {
                let end = |value| {
                    let mut end = xi;
                    end[a] = value;
                    trilinear(&corners, end)
                };
                sub(end(1.0), end(0.0))
            };
            dot(cross(column(0), column(1)), column(2))
        });
        jacobians.sum::<f64>() / 8.0
    });
    tetrahedra.chain(hexahedra).collect()
}

/// What the triangles enclose, by the divergence theorem, as seen from the mesh's first vertex.
pub(crate) fn enclosed(mesh: &RawMesh) -> f64 {
    let origin = mesh.positions[0];
    let place = |node: u32| sub(mesh.positions[node as usize], origin);
    let triangles = mesh.triangles.iter().map(|corners| corners.map(place));
    triangles.map(|[a, b, c]| dot(cross(a, b), c) / 6.0).sum()
}

/// Every edge of the surface is run through as often one way as the other.
pub(crate) fn is_closed(mesh: &RawMesh) -> bool {
    let mut edges = std::collections::HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let way = if from < to { 1 } else { -1 };
            *edges.entry((from.min(to), from.max(to))).or_insert(0) += way;
        }
    }
    edges.values().all(|&sum| sum == 0)
}
