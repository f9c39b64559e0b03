//! Points embedded in volumes: linear fields, flat elements, what is refused.

use super::bodies::{
    bent, check_weights, distance, distorted, embedded, hexahedra, inside, tetrahedra, volumes,
};
use bdtree_build::basis::embed::embed;
use bdtree_build::input::volume::RawVolume;
use bdtree_fixtures::models::math::Random;
use bdtree_fixtures::models::volume::{hex_block, tet_block};

#[test]
fn linear_fields_are_reproduced_inside() {
    for volume in volumes() {
        let points = inside(&volume, 4000);
        let embedding = embedded(&points, &volume);
        assert_eq!(embedding.outside, 0);
        check_weights(&embedding);
        let linear = |p: [f64; 3]| {
            let [x, y, z] = p;
            [1.0 + 2.0 * x - y, 3.0 * z - 0.5 * x, 7.0 - y + z]
        };
        let field: Vec<[f64; 3]> = volume.nodes.iter().map(|&p| linear(p)).collect();
        let both = [volume.nodes.as_slice(), &field].concat();
        let applied = embedding.apply(&both);
        assert_eq!(applied.len(), 2 * points.len());
        for (i, &p) in points.iter().enumerate() {
            assert!(distance(applied[i], p) < 1e-14);
            assert!(distance(applied[points.len() + i], linear(p)) < 1e-13);
        }
    }
}

#[test]
fn nodes_follow_themselves() {
    for volume in volumes() {
        let embedding = embedded(&volume.nodes, &volume);
        for i in 0..volume.nodes.len() {
            let weights = embedding.weights(i);
            let own = weights.iter().find(|&&(node, _)| node as usize == i);
            assert!(
                own.is_some_and(|&(_, w)| w > 1.0 - 1e-13),
                "{i}: {weights:?}"
            );
        }
        assert!(distance(embedding.apply(&volume.nodes)[7], volume.nodes[7]) < 1e-15);
    }
}

/// Flat elements far from the origin: nothing falls between them, and means stay exact.
#[test]
fn flat_elements_leave_no_gaps() {
    for (height, offset) in [
        (1e-3, 0.0),
        (1e-6, 0.0),
        (1e-9, 0.0),
        (1e-3, 100.0),
        (1e-6, 100.0),
    ] {
        let place = |nodes: Vec<[f64; 3]>| -> Vec<[f64; 3]> {
            // A slanted plane, so that no coordinate is exact.
            let shear =
                |[x, y, z]: [f64; 3]| [x + offset, 0.7 * y + 0.3 * x, z + 0.37 * x - 0.11 * y];
            nodes.into_iter().map(shear).collect()
        };
        let size = [1.0, 1.0, height];
        let (nodes, tets) = tet_block(6, 5, 3, size);
        let flat = [tetrahedra((place(nodes), tets)), {
            let (nodes, hexes) = hex_block(6, 5, 3, size);
            hexahedra((place(nodes), hexes))
        }];
        for volume in flat {
            let points = inside(&volume, 3000);
            let embedding = embedded(&points, &volume);
            assert_eq!(embedding.outside, 0);
            check_weights(&embedding);
            let moved = embedding.apply(&volume.nodes);
            let worst = points
                .iter()
                .zip(&moved)
                .map(|(&p, &q)| distance(p, q))
                .fold(0.0, f64::max);
            // A few hundred ulps of the coordinates, whatever the height.
            assert!(
                worst < 1e-13 * (1.0 + offset),
                "{height} {offset}: {worst:e}"
            );
        }
    }
}

/// Where Newton's method alone loses its way.
#[test]
fn distorted_hexahedra_are_inverted() {
    for volume in distorted(300) {
        let points = inside(&volume, 40);
        let embedding = embedded(&points, &volume);
        check_weights(&embedding);
        let moved = embedding.apply(&volume.nodes);
        for (p, q) in points.iter().zip(moved) {
            assert!(distance(*p, q) < 1e-13, "{p:?}");
        }
    }
}

#[test]
fn rounding_is_not_called_outside() {
    let mut volume = tetrahedra(tet_block(3, 3, 3, [1.0; 3]));
    // A node of no element does not count.
    volume.nodes.push([1e6; 3]);
    let mut warnings = Vec::new();
    let points = [[1.0 + 1e-7, 0.5, 0.5], [0.5, -1e-7, 0.5]];
    let embedding = embed(&points, &volume, &mut warnings).unwrap();
    assert_eq!((embedding.outside, embedding.farthest), (0, None));
    assert!(warnings.is_empty());
    let embedding = embed(&[[1.1, 0.5, 0.5]], &volume, &mut warnings).unwrap();
    assert_eq!(embedding.outside, 1);
    let text = "v: 1 of 1 vertices lie outside the volume and follow the nearest point of its \
                boundary; the farthest is vertex 0, 5.77e-2 box diagonals away";
    assert_eq!(warnings, [text]);
}

#[test]
fn what_cannot_be_embedded_is_refused() {
    let volume = tetrahedra(tet_block(1, 1, 1, [1.0; 3]));
    let refused = |points: &[[f64; 3]], volume: &RawVolume| {
        embed(points, volume, &mut Vec::new())
            .unwrap_err()
            .to_string()
    };
    let points = [[0.0; 3], [f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]];
    let expected = "vertex 1: position [NaN, 0.0, 0.0] is not finite or beyond 1e60\n\
                    vertex 2: position [0.0, inf, 0.0] is not finite or beyond 1e60";
    assert_eq!(refused(&points, &volume), expected);
    assert_eq!(
        refused(&[], &RawVolume::default()),
        "a volume without elements"
    );
    let mut odd = volume.clone();
    odd.tetrahedra[2][1] = 8;
    assert_eq!(
        refused(&[], &odd),
        "v: elements refer to nodes that are not there"
    );
    let mut odd = volume.clone();
    odd.nodes[3][0] = f64::NAN;
    assert_eq!(refused(&[], &odd), "v: nodes are not finite or beyond 1e60");
    // An element and its mirror image: no face is left.
    let mut odd = volume.clone();
    let [a, b, c, d] = odd.tetrahedra[0];
    odd.tetrahedra = vec![[a, b, c, d], [a, c, b, d]];
    assert_eq!(refused(&[], &odd), "v: a volume without a boundary");
    assert_eq!(embedded(&[], &volume).point_count(), 0);
}

/// Ten thousand points in as many elements, straight and bent: all that lie inside are found, none of those outside.
#[test]
fn ten_thousand_points_in_ten_thousand_elements() {
    let size = [1.0, 1.0, 1.0];
    for volume in [
        tetrahedra(tet_block(12, 12, 12, size)),
        hexahedra(hex_block(22, 22, 21, size)),
        bent(hexahedra(hex_block(22, 22, 21, size))),
    ] {
        let points = inside(&volume, 10_000);
        assert_eq!(embedded(&points, &volume).outside, 0);
        let mut random = Random::new(1);
        let outside: Vec<[f64; 3]> = (0..10_000)
            .map(|_| [1.5 + random.unit(), random.unit(), random.unit()])
            .collect();
        assert_eq!(embedded(&outside, &volume).outside, 10_000);
    }
}
