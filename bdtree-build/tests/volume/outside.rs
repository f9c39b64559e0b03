//! Points outside of a volume: against samples of its boundary.

use super::bodies::{check_weights, distance, distorted, embedded, volumes};
use super::located::first_containing;
use bdtree_build::basis::embed::embed;
use bdtree_build::input::volume::{RawVolume, surface};
use bdtree_fixtures::models::math::Random;

/// Points around `volume` and outside of it.
fn around(volume: &RawVolume, count: usize) -> Vec<[f64; 3]> {
    let mut random = Random::new(23);
    (0..count)
        .map(|_| [0, 1, 2].map(|_| random.range(-1.0, 2.0)))
        .filter(|&p| first_containing(volume, p, 0.0).is_none())
        .collect()
}

/// Points of the boundary, `steps` + 1 along each side of a face: of triangles as they are, of
/// quadrilaterals on the bilinear surface.
fn samples(volume: &RawVolume, steps: u32) -> Vec<[f64; 3]> {
    let at = |node: u32| volume.nodes[node as usize];
    let is_quads = !volume.hexahedra.is_empty();
    let mut samples = Vec::new();
    for pair in surface(volume)
        .triangles
        .chunks(if is_quads { 2 } else { 1 })
    {
        let [a, b, c] = pair[0].map(at);
        let d = if is_quads { at(pair[1][2]) } else { a };
        for i in 0..=steps {
            for j in 0..=steps {
                let share = |i: u32| f64::from(i) / f64::from(steps);
                let (s, t) = (share(i), share(j));
                let weights = if is_quads {
                    [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
                } else {
                    [1.0 - s, s * (1.0 - t), s * t, 0.0]
                };
                let corners = [a, b, c, d];
                samples.push([0, 1, 2].map(|k| (0..4).map(|i| weights[i] * corners[i][k]).sum()));
            }
        }
    }
    samples
}

fn least(samples: &[[f64; 3]], p: [f64; 3]) -> f64 {
    let distances = samples.iter().map(|&x| distance(x, p));
    distances.fold(f64::INFINITY, f64::min)
}

#[test]
fn points_outside_follow_the_nearest_point_of_the_boundary() {
    for volume in volumes() {
        let points = around(&volume, 200);
        assert!(points.len() > 150);
        let mut warnings = Vec::new();
        let embedding = embed(&points, &volume, &mut warnings).unwrap();
        check_weights(&embedding);
        let samples = samples(&volume, 12);
        let mut farthest = 0.0_f64;
        for (&p, &q) in points.iter().zip(&embedding.apply(&volume.nodes)) {
            let (found, nearest) = (distance(p, q), least(&samples, p));
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

#[test]
fn warped_faces_are_followed_too() {
    for volume in distorted(60) {
        let points = around(&volume, 60);
        let embedding = embedded(&points, &volume);
        check_weights(&embedding);
        let samples = samples(&volume, 40);
        for (&p, &q) in points.iter().zip(&embedding.apply(&volume.nodes)) {
            let (found, nearest) = (distance(p, q), least(&samples, p));
            assert!(found <= nearest + 1e-13, "{found} {nearest}");
        }
    }
}
