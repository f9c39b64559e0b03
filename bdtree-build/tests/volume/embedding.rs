//! Points embedded in volumes.

use super::shapes::{cross, dot, sub, trilinear};
use bdtree_build::basis::embed::{Embedding, embed};
use bdtree_build::input::volume::{RawVolume, surface};
use bdtree_tests::fixtures::math::Random;
use bdtree_tests::fixtures::volume::{hex_block, tet_block};

fn tetrahedra((nodes, tetrahedra): (Vec<[f64; 3]>, Vec<[u32; 4]>)) -> RawVolume {
    RawVolume {
        name: "v".into(),
        nodes,
        tetrahedra,
        ..RawVolume::default()
    }
}

fn hexahedra((nodes, hexahedra): (Vec<[f64; 3]>, Vec<[u32; 8]>)) -> RawVolume {
    RawVolume {
        name: "v".into(),
        nodes,
        hexahedra,
        ..RawVolume::default()
    }
}

/// A smooth map without folds that bends every cell: warped faces.
fn bend(p: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = p;
    [
        x + 0.1 * y * z,
        y + 0.2 * x * x - 0.1 * z,
        z + 0.15 * x * y + 0.05 * x,
    ]
}

fn bent(mut volume: RawVolume) -> RawVolume {
    for node in &mut volume.nodes {
        *node = bend(*node);
    }
    volume
}

/// The same with every node moved by up to `most` along each axis.
fn shaken(mut volume: RawVolume, most: f64) -> RawVolume {
    let mut random = Random::new(3);
    for x in volume.nodes.iter_mut().flatten() {
        *x += random.range(-most, most);
    }
    volume
}

fn volumes() -> Vec<RawVolume> {
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

/// Points inside: weighted means of the corners of elements.
fn inside(volume: &RawVolume, count: usize) -> Vec<[f64; 3]> {
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

fn embedded(points: &[[f64; 3]], volume: &RawVolume) -> Embedding {
    embed(points, volume, &mut Vec::new()).expect("an embedding")
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}

/// Weights are between 0 and 1 and add up to 1.
fn check_weights(embedding: &Embedding) {
    for i in 0..embedding.point_count() {
        let weights = embedding.weights(i);
        assert!(!weights.is_empty() && weights.len() <= 8);
        let sum: f64 = weights.iter().map(|(_, w)| w).sum();
        assert!((sum - 1.0).abs() < 1e-14, "{i}: {sum}");
        assert!(weights.iter().all(|&(_, w)| w > 0.0 && w <= 1.0 + 1e-14));
    }
}

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

/// The slow twin: all elements in order, tetrahedra by the signs of their faces, hexahedra by
/// following the map from the best of many starts.
fn first_containing(volume: &RawVolume, p: [f64; 3], slack: f64) -> Option<usize> {
    let at = |node: u32| volume.nodes[node as usize];
    let in_tetrahedron = |corners: [[f64; 3]; 4]| {
        [[0, 2, 1, 3], [0, 1, 3, 2], [1, 2, 3, 0], [0, 3, 2, 1]]
            .into_iter()
            .all(|[a, b, c, _]| {
                let normal = cross(sub(corners[b], corners[a]), sub(corners[c], corners[a]));
                dot(sub(p, corners[a]), normal) <= slack * dot(normal, normal).sqrt()
            })
    };
    let in_hexahedron = |corners: [[f64; 3]; 8]| {
        // Halving boxes whose corner values surround p, without a frame and without Newton.
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

/// Outside: no sample of the boundary is nearer than the point that is followed.
#[test]
fn points_outside_follow_the_nearest_point_of_the_boundary() {
    for volume in volumes() {
        let mut random = Random::new(23);
        let points: Vec<[f64; 3]> = (0..200)
            .map(|_| [0, 1, 2].map(|_| random.range(-1.0, 2.0)))
            .filter(|&p| first_containing(&volume, p, 0.0).is_none())
            .collect();
        assert!(points.len() > 150);
        let mut warnings = Vec::new();
        let embedding = embed(&points, &volume, &mut warnings).unwrap();
        check_weights(&embedding);
        let moved = embedding.apply(&volume.nodes);

        // Samples: of triangles directly, of quadrilaterals on the bilinear surface.
        let at = |node: u32| volume.nodes[node as usize];
        let mesh = surface(&volume);
        let mut samples: Vec<[f64; 3]> = Vec::new();
        let steps = 12;
        let is_quads = !volume.hexahedra.is_empty();
        for pair in mesh.triangles.chunks(if is_quads { 2 } else { 1 }) {
            let [a, b, c] = pair[0].map(at);
            let d = if is_quads { at(pair[1][2]) } else { a };
            for i in 0..=steps {
                for j in 0..=steps {
                    let (s, t) = (
                        f64::from(i) / f64::from(steps),
                        f64::from(j) / f64::from(steps),
                    );
                    let weights = if is_quads {
                        [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
                    } else {
                        [1.0 - s, s * (1.0 - t), s * t, 0.0]
                    };
                    samples.push([0, 1, 2].map(|k| {
                        weights[0] * a[k]
                            + weights[1] * b[k]
                            + weights[2] * c[k]
                            + weights[3] * d[k]
                    }));
                }
            }
        }
        let mut farthest = 0.0_f64;
        for (&p, &q) in points.iter().zip(&moved) {
            let nearest = samples
                .iter()
                .map(|&x| distance(x, p))
                .fold(f64::INFINITY, f64::min);
            let found = distance(p, q);
            farthest = farthest.max(found);
            // A sample is within half a step, 0.02, of the nearest point.
            assert!(
                found <= nearest + 1e-13 && nearest < found + 0.02,
                "{found} {nearest}"
            );
        }
        let (_, relative) = embedding.farthest.unwrap();
        let low = [0, 1, 2].map(|a| volume.nodes.iter().fold(f64::INFINITY, |m, p| m.min(p[a])));
        let high = [0, 1, 2].map(|a| volume.nodes.iter().fold(-f64::INFINITY, |m, p| m.max(p[a])));
        assert!((relative * distance(low, high) - farthest).abs() < 1e-12);
        assert_eq!(embedding.outside, points.len());
        assert_eq!(warnings.len(), 1);
        let text = format!(
            "v: {} of {} vertices lie outside",
            points.len(),
            points.len()
        );
        assert!(warnings[0].starts_with(&text), "{}", warnings[0]);
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

#[test]
fn rounding_is_not_called_outside() {
    let volume = tetrahedra(tet_block(3, 3, 3, [1.0; 3]));
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
    let expected = "vertex 1: position [NaN, 0.0, 0.0] is not finite\n\
                    vertex 2: position [0.0, inf, 0.0] is not finite";
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
    assert_eq!(refused(&[], &odd), "v: nodes are not finite");
    // An element and its mirror image: no face is left.
    let mut odd = volume.clone();
    let [a, b, c, d] = odd.tetrahedra[0];
    odd.tetrahedra = vec![[a, b, c, d], [a, c, b, d]];
    assert_eq!(refused(&[], &odd), "v: a volume without a boundary");
    assert_eq!(embedded(&[], &volume).point_count(), 0);
}

/// `cargo test --release -p bdtree-build --test volume -- --ignored --nocapture`
#[test]
#[ignore = "timing, run by hand"]
fn hundred_thousand_points_in_hundred_thousand_elements() {
    let size = [1.0, 1.0, 1.0];
    for volume in [
        tetrahedra(tet_block(26, 26, 25, size)),
        hexahedra(hex_block(47, 46, 46, size)),
        bent(hexahedra(hex_block(47, 46, 46, size))),
    ] {
        let elements = volume.tetrahedra.len() + volume.hexahedra.len();
        let points = inside(&volume, 100_000);
        let start = std::time::Instant::now();
        let embedding = embedded(&points, &volume);
        println!("{elements} elements, inside: {:?}", start.elapsed());
        assert_eq!(embedding.outside, 0);
        let mut random = Random::new(1);
        let outside: Vec<[f64; 3]> = (0..100_000)
            .map(|_| [1.5 + random.unit(), random.unit(), random.unit()])
            .collect();
        let start = std::time::Instant::now();
        let embedding = embedded(&outside, &volume);
        println!("{elements} elements, outside: {:?}", start.elapsed());
        assert_eq!(embedding.outside, 100_000);
    }
}
