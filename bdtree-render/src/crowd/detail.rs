//! Fewer triangles for bodies that are far away, over the same vertices, so that deforming stays as it is.
//!
//! Vertices in one cell of a grid that face the same way become one of them, at rest; triangles that lose a corner are left out. Since fields
//! are smooth, what is near at rest stays near. A body takes the fewest triangles that move no corner by more pixels than
//! a picture allows.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use crate::shading::normals;

/// Cells across the diagonal of the box, from fine to coarse.
const CELLS: [f64; 6] = [256.0, 128.0, 64.0, 32.0, 16.0, 8.0];
/// A level with more triangles than this part of those of the level before is not worth it.
const WORTH: f64 = 0.75;

/// Triangles instead of all.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Detail {
    /// How far a corner moves at rest (stored units).
    pub(super) moved: f64,
    /// Their corners.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Levels of detail below all triangles, from fine to coarse.
pub(super) fn details(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<Detail> {
    let points: Vec<DVec3> = positions.iter().map(|p| p.map(f64::from).into()).collect();
    let facing: Vec<i64> = normals(positions, triangles)
        .into_iter()
        .map(facing)
        .collect();
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let diagonal = (high - low).length();
    let mut found: Vec<Detail> = Vec::new();
    if !(diagonal > 0.0 && diagonal.is_finite()) {
        return found;
    }
    let mut most = triangles.len();
    for cells in CELLS {
        let detail = clustered((&points, &facing), triangles, low, diagonal / cells);
        if !detail.triangles.is_empty() && detail.triangles.len() as f64 <= WORTH * most as f64 {
            most = detail.triangles.len();
            found.push(detail);
        }
    }
    found
}

/// Which of six ways a vertex faces. The sides of a thin wall face away from each other: were they one, they would show
/// through each other.
fn facing(normal: [f32; 3]) -> i64 {
    let size = normal.map(f32::abs);
    let axis = (1..3).fold(0, |most, k| if size[k] > size[most] { k } else { most });
    2 * axis as i64 + i64::from(normal[axis] < 0.0)
}

fn clustered(
    (points, facing): (&[DVec3], &[i64]),
    triangles: &[[u32; 3]],
    low: DVec3,
    size: f64,
) -> Detail {
    let keys: Vec<[i64; 4]> = (points.iter().zip(facing))
        .map(|(p, facing)| {
            let [x, y, z] = ((p - low) / size).to_array().map(|x| x.floor() as i64);
            [x, y, z, *facing]
        })
        .collect();
    let mut sums: HashMap<[i64; 4], (DVec3, f64)> = HashMap::new();
    for (p, key) in points.iter().zip(&keys) {
        let (sum, count) = sums.entry(*key).or_default();
        *sum += *p;
        *count += 1.0;
    }
    // Of each cell the vertex nearest to the middle of all, the first of several.
    let mut nearest: HashMap<[i64; 4], (f64, u32)> = HashMap::new();
    for ((vertex, p), key) in (0..).zip(points).zip(&keys) {
        let (sum, count) = sums.get(key).copied().unwrap_or_default();
        let away = p.distance_squared(sum / count);
        let best = nearest.entry(*key).or_insert((away, vertex));
        if away < best.0 {
            *best = (away, vertex);
        }
    }
    let of = |key: &[i64; 4]| nearest.get(key).map_or(0, |best| best.1);
    let kept: Vec<u32> = keys.iter().map(of).collect();
    let moved = points.iter().zip(&kept);
    let moved = moved.map(|(p, to)| p.distance(points[*to as usize]));
    let mut seen = HashSet::new();
    let mut fewer = Vec::new();
    for corners in triangles {
        let corners = corners.map(|v| kept.get(v as usize).copied().unwrap_or(0));
        let [a, b, c] = corners;
        let mut sorted = corners;
        sorted.sort_unstable();
        if a != b && b != c && c != a && seen.insert(sorted) {
            fewer.push(corners);
        }
    }
    Detail {
        moved: moved.fold(0.0, f64::max),
        triangles: fewer,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_fewer_triangles_the_farther_corners_move() {
        // A sheet of 64 × 64 squares.
        const SIDE: u32 = 64;
        let at = |i: u32, j: u32| i + (SIDE + 1) * j;
        let positions: Vec<[f32; 3]> = (0..=SIDE)
            .flat_map(|j| (0..=SIDE).map(move |i| [i as f32, j as f32, 0.0]))
            .collect();
        let mut triangles = Vec::new();
        for j in 0..SIDE {
            for i in 0..SIDE {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        let levels = details(&positions, &triangles);
        assert!(levels.len() >= 3, "{} levels", levels.len());
        let (mut most, mut least_moved) = (triangles.len(), 0.0);
        for level in &levels {
            assert!(level.triangles.len() < most && level.moved >= least_moved);
            (most, least_moved) = (level.triangles.len(), level.moved);
            // The sheet has no holes: its area is there.
            let area: f32 = level
                .triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| positions[v as usize]);
                    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
                })
                .sum();
            let kept = f64::from(area) / f64::from(SIDE * SIDE);
            assert!(kept > 1.0 - 4.0 * level.moved / f64::from(SIDE), "{kept}");
        }
        assert!(details(&[], &[]).is_empty() && details(&[[1.0; 3]], &[[0; 3]]).is_empty());
    }
}
