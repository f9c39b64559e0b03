//! Points outside of a volume: against samples of its boundary.

use super::bodies::{check_weights, distance, volumes};
use super::located::first_containing;
use bdtree_build::basis::embed::embed;
use bdtree_build::input::volume::surface;
use bdtree_tests::fixtures::math::Random;

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
