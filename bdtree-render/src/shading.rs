//! What a mesh is shaded by: normals, and where it is smooth.

use glam::Vec3;

/// Cosines of the angles (40 and 25 degrees) between a vertex's normal and that of its triangle which is
/// farthest from it: from the one on it is a crease, up to the other it is smooth. A cube's edges have 45
/// degrees, an icosphere of 80 triangles 18.
const CREASE: f32 = 0.766;
const SMOOTH: f32 = 0.906;

/// A unit normal per vertex: the sum of its triangles' normals, each as long as its area. Vertices
/// without a triangle of any area get 0; corners that are no vertex are left out.
pub fn normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for (corners, normal) in triangle_normals(positions, triangles) {
        for v in corners {
            sums[v as usize] += normal;
        }
    }
    let unit = |sum: Vec3| {
        let n = sum.length();
        let is_sound = n > 0.0 && n.is_finite();
        let unit = if is_sound {
            sum * (1.0 / n)
        } else {
            Vec3::ZERO
        };
        unit.to_array()
    };
    sums.into_iter().map(unit).collect()
}

/// Triangles whose corners are vertices, and their normals, twice as long as their areas.
fn triangle_normals(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
) -> impl Iterator<Item = ([u32; 3], Vec3)> {
    let at = |v: u32| positions.get(v as usize).map(|p| Vec3::from(*p));
    triangles.iter().filter_map(move |corners| {
        let [Some(a), Some(b), Some(c)] = corners.map(at) else {
            return None;
        };
        Some((*corners, (b - a).cross(c - a)))
    })
}

/// How smooth a mesh is at each vertex, 0 (a crease: each triangle is shaded by its own normal) to 1 (by
/// the normals of its vertices).
pub fn smoothness(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let means = normals(positions, triangles);
    let mut least = vec![1.0_f32; positions.len()];
    for (corners, normal) in triangle_normals(positions, triangles) {
        let n = normal.length();
        if n > 0.0 && n.is_finite() {
            for v in corners.map(|v| v as usize) {
                least[v] = least[v].min(normal.dot(means[v].into()) / n);
            }
        }
    }
    let of = |cosine: f32| ((cosine - CREASE) / (SMOOTH - CREASE)).clamp(0.0, 1.0);
    least.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::{normals, smoothness};

    #[test]
    fn folds_are_creases_and_bends_are_not() {
        // Two squares that meet at an edge, the second turned by an angle around it.
        let at = |angle: f32| {
            let (s, c) = angle.to_radians().sin_cos();
            let positions = [
                [-1.0, 0.0, 0.0],
                [-1.0, 0.0, 1.0],
                [0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0],
                [c, s, 0.0],
                [c, s, 1.0],
                // Of no triangle.
                [5.0; 3],
            ];
            let triangles = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [0, 2, 9]];
            smoothness(&positions, &triangles)
        };
        assert_eq!(at(30.0), [1.0; 7]);
        // One of the ends of the fold has two triangles on one side and one on the other.
        let folded = at(90.0);
        assert_eq!(folded, [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        let between = at(52.0)[3];
        assert!(between > 0.0 && between < 1.0, "{between}");
    }

    #[test]
    fn a_fold_has_the_mean_of_its_sides() {
        let positions = [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [9.0, 9.0, 9.0],
        ];
        let found = normals(&positions, &[[0, 1, 2], [1, 0, 3], [0, 0, 7]]);
        let half = 0.5_f32.sqrt();
        assert_eq!(found[2], [0.0, 1.0, 0.0]);
        assert_eq!(found[3], [1.0, 0.0, 0.0]);
        for k in 0..3 {
            assert!((found[0][k] - [half, half, 0.0][k]).abs() < 1e-6);
        }
        assert_eq!(found[4], [0.0; 3], "of a vertex of no triangle");
    }
}
