//! Which element a point follows: against looking at every element, and on what elements share.

use super::bodies::{check_weights, distance, embedded, volumes};
use super::shapes::{cross, dot, sub, trilinear};
use bdtree_build::input::volume::RawVolume;
use bdtree_fixtures::models::math::Random;

/// The slow twin: all elements in order, tetrahedra by the signs of their faces, hexahedra by halving
/// boxes of the unit cube as long as their corners surround the point.
pub(crate) fn first_containing(volume: &RawVolume, p: [f64; 3], slack: f64) -> Option<usize> {
    let at = |node: u32| volume.nodes[node as usize];
    let in_tetrahedron = |corners: [[f64; 3]; 4]| {
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
            .into_iter()
            .all(|face| {
                let [a, b, c] = face.map(|i: usize| corners[i]);
                let outward = cross(sub(b, a), sub(c, a));
                dot(sub(p, a), outward) <= slack * dot(outward, outward).sqrt()
            })
    };
    let in_hexahedron = |corners: [[f64; 3]; 8]| {
        let mut boxes = vec![([0.0; 3], 1.0)];
        while let Some((low, side)) = boxes.pop() {
            let corner = |i: usize| {
                let bit = |b: usize| side * f64::from(u8::from(i >> b & 1 == 1));
                [low[0] + bit(0), low[1] + bit(1), low[2] + bit(2)]
            };
            let values: Vec<[f64; 3]> = (0..8).map(|i| trilinear(&corners, corner(i))).collect();
            let surrounds = (0..3).all(|a| {
                values.iter().any(|v| v[a] <= p[a] + slack)
                    && values.iter().any(|v| v[a] >= p[a] - slack)
            });
            if surrounds && side < 1e-9 {
                return true;
            }
            if surrounds {
                boxes.extend((0..8).map(|i| {
                    let bit = |b: usize| 0.5 * side * f64::from(u8::from(i >> b & 1 == 1));
                    (
                        [low[0] + bit(0), low[1] + bit(1), low[2] + bit(2)],
                        0.5 * side,
                    )
                }));
            }
        }
        false
    };
    let tetrahedra = volume.tetrahedra.iter().map(|c| in_tetrahedron(c.map(at)));
    let hexahedra = volume.hexahedra.iter().map(|c| in_hexahedron(c.map(at)));
    tetrahedra.chain(hexahedra).position(|inside| inside)
}

#[test]
fn points_follow_the_element_that_contains_them() {
    for volume in volumes() {
        let mut random = Random::new(17);
        let points: Vec<[f64; 3]> = (0..600)
            .map(|_| [0, 1, 2].map(|_| random.range(-0.3, 1.3)))
            .collect();
        let embedding = embedded(&points, &volume);
        check_weights(&embedding);
        let mut found = 0;
        for (i, &p) in points.iter().enumerate() {
            let element = first_containing(&volume, p, 0.0);
            let moved = distance(embedding.apply(&volume.nodes)[i], p);
            assert_eq!(element.is_some(), moved < 1e-13, "{p:?} {moved}");
            let Some(element) = element else { continue };
            found += 1;
            let of = match volume.tetrahedra.get(element) {
                Some(nodes) => nodes.to_vec(),
                None => volume.hexahedra[element - volume.tetrahedra.len()].to_vec(),
            };
            assert!(
                embedding
                    .weights(i)
                    .iter()
                    .all(|(node, _)| of.contains(node))
            );
        }
        assert!(found > 50 && found < 550, "{found}");
        assert_eq!(embedding.outside, points.len() - found);
    }
}

/// Faces, edges and corners belong to several elements: the lowest one is taken, and none is missed.
#[test]
fn points_between_elements_follow_the_lowest() {
    for volume in volumes() {
        let mut points = Vec::new();
        let faces = volume.tetrahedra.iter().map(|&[a, b, c, _]| vec![a, b, c]);
        let faces = faces.chain(
            volume
                .hexahedra
                .iter()
                .map(|h| vec![h[1], h[2], h[6], h[5]]),
        );
        for face in faces {
            let at = |i: usize| volume.nodes[face[i] as usize];
            let mean =
                |n: usize| [0, 1, 2].map(|a| (0..n).map(|i| at(i)[a]).sum::<f64>() / n as f64);
            points.extend([mean(face.len()), mean(2)]);
        }
        let embedding = embedded(&points, &volume);
        assert_eq!(embedding.outside, 0);
        for (i, &p) in points.iter().enumerate() {
            assert!(distance(embedding.apply(&volume.nodes)[i], p) < 1e-14);
            let lowest = first_containing(&volume, p, 1e-14).expect("inside");
            let of = match volume.tetrahedra.get(lowest) {
                Some(nodes) => nodes.to_vec(),
                None => volume.hexahedra[lowest].to_vec(),
            };
            assert!(
                embedding
                    .weights(i)
                    .iter()
                    .all(|(node, _)| of.contains(node)),
                "{p:?}"
            );
        }
    }
}
