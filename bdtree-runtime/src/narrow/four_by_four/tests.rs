use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{PLANES_FROM, Triangle, WorldFour};
use crate::narrow::{nearest_points, triangle_distance};
use crate::simd::Quad;
use crate::simd::quad::Array4;

/// Four triangles as a walk keeps them.
fn four(triangles: &[Triangle; 4]) -> WorldFour {
    let mut four = WorldFour::EMPTY;
    let row =
        |i: usize, axis: usize| Array4::load(&[0, 1, 2, 3].map(|k: usize| triangles[k][i][axis]));
    four.set::<Array4>([0, 1, 2].map(|i| [row(i, 0), row(i, 1), row(i, 2)]));
    four
}

/// A plain triangle, a sliver, a needle, one without area, or one of a grid.
fn triangle(r: &mut Pcg64, center: [f64; 3], size: f64) -> Triangle {
    let shape = r.random_range(0..6);
    let thin = 10.0_f64.powi(r.random_range(-17..-1));
    let mut point = |by: f64| center.map(|x| x + by * size * r.random_range(-1.0..1.0));
    let [p, q, far] = [point(1.0), point(1.0), point(1.0)];
    let near = |to: [f64; 3], off: [f64; 3]| [0, 1, 2].map(|k| to[k] + thin * (off[k] - center[k]));
    let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    match shape {
        0 => [p, near(middle, far), q],
        1 => [p, q, near(q, far)],
        2 => [p, q, middle],
        3 => [p, q, far].map(|x| x.map(|c| (4.0 * c / size).round() * 0.25 * size)),
        _ => [p, q, far],
    }
}

/// No pair within the tolerance is left out, whatever its shape and size, and the tolerance right at its distance; of those that are
/// farther apart by half of it, most are.
#[test]
fn near_pairs_stay_and_most_others_go() {
    let mut r = Pcg64::seed_from_u64(61);
    let (mut far, mut left_out) = (0, 0);
    for round in 0..40_000 {
        let size = match round % 4 {
            0 => 2.0_f64.powi(r.random_range(-120..90)),
            _ => 1.0,
        };
        let offset = [0; 3].map(|_| 2.0 * size * r.random_range(-1.0..1.0));
        let a = [0; 4].map(|_| triangle(&mut r, [0.0; 3], size));
        let b = [0; 4].map(|_| triangle(&mut r, offset, size));
        let (fours_a, fours_b) = (four(&a), four(&b));
        for (i, a) in a.iter().enumerate() {
            let nearest = b.map(|b| triangle_distance(a, &b));
            for (j, nearest) in nearest.into_iter().enumerate() {
                let (distance, touching) = (nearest.distance, nearest.distance == 0.0);
                // Just at it, a little beyond it, or below it by half.
                for tolerance in [distance, distance.next_up(), distance / 1.5] {
                    let left = fours_a.near::<Array4>(i, &fours_b, tolerance);
                    let is_left = left >> j & 1 != 0;
                    // A search that ends at the tolerance finds the same, or nothing within it.
                    let found = nearest_points(a, &b[j], touching, tolerance);
                    if distance <= tolerance {
                        assert_eq!(found, nearest);
                        assert!(is_left, "{a:?} {:?} at {distance}, {tolerance}", b[j]);
                        continue;
                    }
                    assert!(found.distance > tolerance);
                    if tolerance >= PLANES_FROM && size == 1.0 {
                        far += 1;
                        left_out += u32::from(!is_left);
                    }
                }
            }
        }
    }
    // With boxes alone it is 0.44.
    let share = f64::from(left_out) / f64::from(far);
    assert!(far > 100_000 && share > 0.9, "{left_out} of {far}");
}
