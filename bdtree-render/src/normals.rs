//! Normals of a deformed mesh, for shading.

use crate::camera::{add, cross, length, scale, sub};

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

#[cfg(test)]
mod tests {
    use super::normals;

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
