//! What a mesh is shaded by: normals, and where it is smooth.

use crate::camera::{add, cross, dot, length, scale, sub};

/// Cosines of the angles (40 and 25 degrees) between a vertex's normal and that of its triangle which is
/// farthest from it: from the one on it is a crease, up to the other it is smooth. A cube's edges have 45
/// degrees, an icosphere of 80 triangles 18.
const CREASE: f32 = 0.766;
const SMOOTH: f32 = 0.906;

/// A unit normal per vertex: the sum of its triangles' normals, each as long as its area. Vertices
/// without a triangle of any area get 0; corners that are no vertex are left out.
pub fn normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0_f32; 3]; positions.len()];
    for corners in triangles {
        let at = corners.map(|v| positions.get(v as usize));
        let [Some(a), Some(b), Some(c)] = at else {
            continue;
        };
        let normal = cross(sub(*b, *a), sub(*c, *a));
        for v in corners {
            sums[*v as usize] = add(sums[*v as usize], normal);
        }
    }
    for sum in &mut sums {
        let n = length(*sum);
        *sum = if n > 0.0 && n.is_finite() {
            scale(*sum, 1.0 / n)
        } else {
            [0.0; 3]
        };
    }
    sums
}

/// How smooth a mesh is at each vertex, 0 (a crease: each triangle is shaded by its own normal) to 1 (by
/// the normals of its vertices).
pub fn smoothness(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let means = normals(positions, triangles);
    let mut least = vec![1.0_f32; positions.len()];
    for corners in triangles {
        let at = corners.map(|v| positions.get(v as usize));
        let [Some(a), Some(b), Some(c)] = at else {
            continue;
        };
        let normal = cross(sub(*b, *a), sub(*c, *a));
        let n = length(normal);
        if n > 0.0 && n.is_finite() {
            for v in corners.map(|v| v as usize) {
                least[v] = least[v].min(dot(normal, means[v]) / n);
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
