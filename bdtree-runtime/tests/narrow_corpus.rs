//! `triangles_intersect` against pair lists that CGAL's exact kernel made for real meshes.
//!
//! The lists are not to be trusted at triangles of zero area (the library that made them leaves those
//! undefined; two pairs of one such triangle, 0.06 apart, are listed as touching): there an exact
//! linear program decides.

use std::collections::HashSet;

use bdtree_fixtures::corpus;
use bdtree_runtime::narrow::{Triangle, triangle_distance, triangles_intersect};

use crate::collisions;
use crate::narrow_oracle::{big, cross, is_zero, minus, share_point};

/// All pairs whose boxes overlap in x, y and z, through a sweep over x.
fn candidates(a: &[Triangle], b: &[Triangle], mut visit: impl FnMut(usize, usize)) {
    let span = |t: &Triangle, k: usize| {
        let [x, y, z] = t.map(|p| p[k]);
        (x.min(y).min(z), x.max(y).max(z))
    };
    let mut order: Vec<usize> = (0..b.len()).collect();
    order.sort_by(|&i, &j| span(&b[i], 0).0.total_cmp(&span(&b[j], 0).0));
    let boxes: Vec<[(f64, f64); 3]> = order
        .iter()
        .map(|&j| [0, 1, 2].map(|k| span(&b[j], k)))
        .collect();
    let widest = boxes.iter().fold(0.0_f64, |w, s| w.max(s[0].1 - s[0].0));
    for (i, tri) in a.iter().enumerate() {
        let mine = [0, 1, 2].map(|k| span(tri, k));
        // A little wider than needed: the difference may round.
        let first = boxes.partition_point(|s| s[0].0 < mine[0].0 - widest * 1.001);
        for (s, &j) in boxes[first..].iter().zip(&order[first..]) {
            if s[0].0 > mine[0].1 {
                break;
            }
            if (0..3).all(|k| s[k].0 <= mine[k].1 && mine[k].0 <= s[k].1) {
                visit(i, j);
            }
        }
    }
}

fn has_no_area(tri: &Triangle) -> bool {
    let [a, b, c] = big(tri);
    cross(&minus(&b, &a), &minus(&c, &a)).iter().all(is_zero)
}

#[test]
fn agrees_with_exact_pair_lists() {
    let test = "narrow_agrees_with_exact_pair_lists";
    let Some(folder) = corpus::path(test, "") else {
        return;
    };
    let mut differences = 0;
    for case in collisions::cases(&folder) {
        let (a, b) = (case.triangles("a"), case.triangles("b"));
        let listed: HashSet<(usize, usize)> = case
            .listed()
            .into_iter()
            .map(|(i, j)| (i as usize, j as usize))
            .collect();
        let mut found = HashSet::new();
        let mut tested = 0;
        let start = std::time::Instant::now();
        candidates(&a, &b, |i, j| {
            tested += 1;
            if triangles_intersect(&a[i], &b[j]) {
                found.insert((i, j));
            }
        });
        let seconds = start.elapsed().as_secs_f64();
        let wrong: Vec<_> = listed.symmetric_difference(&found).collect();
        println!(
            "{}: {} listed, {} found, {} differ, {tested} tested in {seconds:.3} s",
            case.id(),
            listed.len(),
            found.len(),
            wrong.len()
        );
        for &&(i, j) in &wrong {
            if has_no_area(&a[i]) || has_no_area(&b[j]) {
                let truth = share_point(&big(&a[i]), &big(&b[j]));
                assert_eq!(found.contains(&(i, j)), truth, "{i} {j}");
                continue;
            }
            differences += 1;
            println!(
                "  {i} {j}: listed {}, distance {:e}\n    {:?}\n    {:?}",
                listed.contains(&(i, j)),
                triangle_distance(&a[i], &b[j]).distance,
                a[i],
                b[j]
            );
        }
    }
    assert_eq!(differences, 0);
}
