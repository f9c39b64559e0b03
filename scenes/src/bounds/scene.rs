//! Bodies, poses and places of the study: bumpy spheres in contact, a curtain, rays.

use std::collections::HashMap;
use std::f64::consts::TAU;

use bdtree_build::tree::Split;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

use super::body::Body;

/// A mesh before its tree.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Vertices.
    pub positions: Vec<[f32; 3]>,
    /// Triangles.
    pub corners: Vec<[u32; 3]>,
}

impl Mesh {
    /// The body with `fields` and a tree.
    pub fn body(&self, fields: &[Vec<Vector3<f64>>], split: Split, leaf_size: usize) -> Body {
        let corners = self.corners.clone();
        Body::new(&self.positions, fields.to_vec(), corners, split, leaf_size)
    }

    /// Diagonal of the box.
    pub fn diagonal(&self) -> f64 {
        let all = self.positions.iter();
        let (low, high) = all.fold(
            ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
            |(low, high), p| {
                let each = |f: fn(f32, f32) -> f32, a: [f32; 3]| [0, 1, 2].map(|k| f(a[k], p[k]));
                (each(f32::min, low), each(f32::max, high))
            },
        );
        (0..3)
            .map(|k| f64::from(high[k] - low[k]).powi(2))
            .sum::<f64>()
            .sqrt()
    }
}

/// An octahedron whose faces are cut in `n²` and pushed onto a bumpy sphere: 8 n² triangles.
pub fn bumpy_sphere(n: i32) -> Mesh {
    let mut positions = Vec::new();
    let mut corners = Vec::new();
    let mut known = HashMap::new();
    // Lattice points with |i| + |j| + |k| = n are the vertices.
    let mut vertex = |at: [i32; 3]| {
        *known.entry(at).or_insert_with(|| {
            let p = Vector3::from(at.map(f64::from)).normalize();
            let bump = 1.0
                + 0.05 * (5.0 * p.x + 1.0).sin() * (4.0 * p.y).cos()
                + 0.04 * (6.0 * p.z + 3.0 * p.x).sin();
            positions.push((p * bump).map(|x| x as f32).into());
            positions.len() as u32 - 1
        })
    };
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|k| if octant >> k & 1 == 0 { 1 } else { -1 });
        let mut at = |i: i32, j: i32| vertex([sign[0] * i, sign[1] * j, sign[2] * (n - i - j)]);
        let outward = sign[0] * sign[1] * sign[2] > 0;
        for i in 0..n {
            for j in 0..n - i {
                let [a, b, c] = [at(i, j), at(i + 1, j), at(i, j + 1)];
                corners.push(if outward { [a, b, c] } else { [a, c, b] });
                if i + j + 1 < n {
                    let d = at(i + 1, j + 1);
                    corners.push(if outward { [b, d, c] } else { [b, c, d] });
                }
            }
        }
    }
    Mesh { positions, corners }
}

/// A folded curtain over [−1, 1]² of `n²` vertices.
pub fn curtain(n: u32) -> Mesh {
    let step = 2.0 / f64::from(n - 1);
    let positions = (0..n * n).map(|i| {
        let (x, y) = (f64::from(i % n) * step - 1.0, f64::from(i / n) * step - 1.0);
        let z = 0.05 * (9.0 * x + 0.7 * y).sin() + 0.02 * (5.0 * y).sin();
        [x, y, z].map(|x| x as f32)
    });
    let corners = (0..(n - 1) * (n - 1)).flat_map(|i| {
        let a = i / (n - 1) * n + i % (n - 1);
        [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]
    });
    Mesh {
        positions: positions.collect(),
        corners: corners.collect(),
    }
}

/// Smooth fields whose waves have wave numbers from 0.8 to `wave_max`; q = 1 moves the farthest
/// vertex by 5 % of the diagonal.
pub fn smooth_fields(
    mesh: &Mesh,
    count: usize,
    wave_max: f64,
    rng: &mut impl Rng,
) -> Vec<Vec<Vector3<f64>>> {
    let diagonal = mesh.diagonal();
    let last = (count.max(2) - 1) as f64;
    (0..count)
        .map(|j| {
            let wave_number = 0.8 + (wave_max - 0.8) * j as f64 / last;
            let waves = [0; 3].map(|_| {
                let along = direction(rng) * wave_number;
                (
                    along,
                    rng.random_range(0.0..TAU),
                    rng.random_range(0.3..1.0),
                )
            });
            let field = mesh.positions.iter().map(|p| {
                let p = Vector3::from(p.map(f64::from));
                Vector3::from(
                    waves.map(|(along, phase, size)| size * (along.dot(&p) + phase).sin()),
                )
            });
            let field: Vec<_> = field.collect();
            let largest = field.iter().map(Vector3::norm).fold(0.0, f64::max);
            // What a file would store.
            let scaled = field.iter().map(|u| u * (0.05 * diagonal / largest));
            scaled.map(|u| u.map(|x| f64::from(x as f32))).collect()
        })
        .collect()
}

/// A random unit vector.
pub fn direction(rng: &mut impl Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from([0; 3].map(|_| rng.random_range(-1.0..1.0_f64)));
        if (0.1..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    }
}

/// A random rotation.
pub fn rotation(rng: &mut impl Rng) -> UnitQuaternion<f64> {
    let axis = nalgebra::Unit::new_normalize(direction(rng));
    UnitQuaternion::from_axis_angle(&axis, rng.random_range(0.0..TAU))
}

/// q_j = a_j sin φ_j with random phases and amplitudes 0.8/√(1 + j).
pub fn amplitudes(count: usize, rng: &mut impl Rng) -> Vec<f64> {
    (0..count)
        .map(|j| 0.8 / (1.0 + j as f64).sqrt() * rng.random_range(0.0..TAU).sin())
        .collect()
}

/// q_j = a_j sin φ_j with random phases and amplitudes 0.8/√(1 + j), scaled so that the farthest
/// vertex moves by `displacement` diagonals; `None` leaves them as they are.
pub fn pose(body: &Body, diagonal: f64, displacement: Option<f64>, rng: &mut impl Rng) -> Vec<f64> {
    let q = amplitudes(body.mode_count(), rng);
    let Some(displacement) = displacement else {
        return q;
    };
    let deformed = body.deformed(&q);
    let moves = deformed.iter().zip(&body.positions);
    let largest = moves.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    q.iter()
        .map(|q| q * displacement * diagonal / largest)
        .collect()
}

/// A second body's place in random rotation and direction at this distance of the origins.
pub fn placed(rotation: UnitQuaternion<f64>, along: Vector3<f64>, distance: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(along * distance), rotation)
}
