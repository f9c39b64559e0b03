//! Volumes to embed points in: even, bent, with every node moved.

use super::shapes::{dot, sub, trilinear};
use bdtree_build::basis::embed::{Embedding, embed};
use bdtree_build::input::volume::{RawVolume, parse_volume};
use bdtree_fixtures::models::math::Random;
use bdtree_fixtures::models::volume::{Format, Volume, hex_block, tet_block};

pub(crate) fn tetrahedra((nodes, tetrahedra): (Vec<[f64; 3]>, Vec<[u32; 4]>)) -> RawVolume {
    RawVolume {
        name: "v".into(),
        nodes,
        tetrahedra,
        ..RawVolume::default()
    }
}

pub(crate) fn hexahedra((nodes, hexahedra): (Vec<[f64; 3]>, Vec<[u32; 8]>)) -> RawVolume {
    RawVolume {
        name: "v".into(),
        nodes,
        hexahedra,
        ..RawVolume::default()
    }
}

/// A smooth map without folds that bends every cell: warped faces.
pub(crate) fn bend(p: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = p;
    [
        x + 0.1 * y * z,
        y + 0.2 * x * x - 0.1 * z,
        z + 0.15 * x * y + 0.05 * x,
    ]
}

pub(crate) fn bent(mut volume: RawVolume) -> RawVolume {
    for node in &mut volume.nodes {
        *node = bend(*node);
    }
    volume
}

/// The same with every node moved by up to `most` along each axis.
pub(crate) fn shaken(mut volume: RawVolume, most: f64) -> RawVolume {
    let mut random = Random::new(3);
    for x in volume.nodes.iter_mut().flatten() {
        *x += random.range(-most, most);
    }
    volume
}

pub(crate) fn volumes() -> Vec<RawVolume> {
    let size = [1.0, 0.8, 0.6];
    vec![
        tetrahedra(tet_block(4, 3, 3, size)),
        bent(tetrahedra(tet_block(4, 3, 3, size))),
        shaken(tetrahedra(tet_block(4, 3, 3, size)), 0.03),
        hexahedra(hex_block(4, 3, 3, size)),
        bent(hexahedra(hex_block(4, 3, 3, size))),
        shaken(hexahedra(hex_block(4, 3, 3, size)), 0.03),
    ]
}

/// Single hexahedra, as distorted as is read at all.
pub(crate) fn distorted(count: usize) -> Vec<RawVolume> {
    let mut random = Random::new(29);
    let cells = std::iter::repeat_with(|| {
        let (mut nodes, cell) = hex_block(1, 1, 1, [1.0; 3]);
        for x in nodes.iter_mut().flatten() {
            *x += random.range(-0.8, 0.8);
        }
        let file = Volume::of_hexahedra((nodes, cell)).to_file(Format::Vtk2Binary);
        parse_volume(&file, "m.vtk").ok()
    });
    cells.flatten().take(count).collect()
}

/// Points inside: weighted means of the corners of elements.
pub(crate) fn inside(volume: &RawVolume, count: usize) -> Vec<[f64; 3]> {
    let mut random = Random::new(11);
    (0..count)
        .map(|_| {
            let at = |node: u32| volume.nodes[node as usize];
            if volume.hexahedra.is_empty() {
                let element = random.bits() as usize % volume.tetrahedra.len();
                let corners = volume.tetrahedra[element].map(at);
                let parts: [f64; 4] = std::array::from_fn(|_| random.unit());
                let sum: f64 = parts.iter().sum();
                [0, 1, 2].map(|a| (0..4).map(|i| parts[i] / sum * corners[i][a]).sum())
            } else {
                let element = random.bits() as usize % volume.hexahedra.len();
                let xi = [random.unit(), random.unit(), random.unit()];
                trilinear(&volume.hexahedra[element].map(at), xi)
            }
        })
        .collect()
}

pub(crate) fn embedded(points: &[[f64; 3]], volume: &RawVolume) -> Embedding {
    embed(points, volume, &mut Vec::new()).expect("an embedding")
}

pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}

/// Weights are between 0 and 1 and add up to 1.
pub(crate) fn check_weights(embedding: &Embedding) {
    for i in 0..embedding.point_count() {
        let weights = embedding.weights(i);
        assert!(!weights.is_empty() && weights.len() <= 8);
        let sum: f64 = weights.iter().map(|(_, w)| w).sum();
        assert!((sum - 1.0).abs() < 1e-14, "{i}: {sum}");
        assert!(weights.iter().all(|&(_, w)| w > 0.0 && w <= 1.0 + 1e-14));
    }
}
