//! W2: two bumpy bodies, both deforming, pressed against each other along no coordinate axis.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::random::Stream;
use bdtree_build::input::RawMesh;
use bdtree_measure::Body;
use bdtree_measure::place::{Place, matrix, undo_after};

use super::{sequence, with_modes};

/// Modes of every bumpy body.
pub const MODES: usize = 10;

/// Frames of the motion.
pub const FRAMES: usize = 100;

/// Two copies of one body; A stands still.
#[derive(Debug, Clone)]
pub struct Bodies {
    /// Both bodies.
    pub body: Body,
    /// q of A and of B, frame after frame.
    pub q: [Vec<f32>; 2],
    /// B in the frame of A.
    pub places: Vec<Place>,
    /// The same for bodies that do not deform.
    pub rigid_places: Vec<Place>,
}

/// A closed bumpy sphere of 20 `n`² triangles, an icosahedron with split faces, and its modes.
pub fn blob(name: &'static str, n: usize, seed: u64) -> Body {
    blob_with(name, n, MODES, seed)
}

/// [`blob`] with any number of modes.
pub fn blob_with(name: &'static str, n: usize, modes: usize, seed: u64) -> Body {
    with_modes(&bumpy(n), name, modes, 2.5, seed)
}

/// Corners of the icosahedron's faces.
const FACES: [[usize; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// The icosahedron's corners: three golden rectangles.
fn corners() -> [[f64; 3]; 12] {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let signs = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let mut all = [[0.0; 3]; 12];
    for (k, [s, t]) in signs.into_iter().enumerate() {
        all[k] = [s, t * g, 0.0];
        all[4 + k] = [0.0, s, t * g];
        all[8 + k] = [t * g, 0.0, s];
    }
    all
}

fn bumpy(n: usize) -> RawMesh {
    let corners = corners();
    let mut shape = RawMesh::default();
    // Faces share the points on their edges, which differ in rounding only.
    let mut known: HashMap<[i64; 3], u32> = HashMap::new();
    for face in FACES {
        let mut grid = vec![vec![0_u32; n + 1]; n + 1];
        for i in 0..=n {
            for j in 0..=n - i {
                let weights = [n - i - j, i, j];
                let mut p = [0.0; 3];
                for (w, corner) in weights.into_iter().zip(face) {
                    for k in 0..3 {
                        p[k] += w as f64 * corners[corner][k];
                    }
                }
                let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
                let p = p.map(|x| x / length);
                let key = p.map(|x| (x * 1e8).round() as i64);
                grid[i][j] = *known.entry(key).or_insert_with(|| {
                    let [x, y, z] = p;
                    let r = 1.0
                        + 0.05 * (5.0 * x + 1.0).sin() * (4.0 * y).cos()
                        + 0.04 * (6.0 * z + 3.0 * x).sin();
                    shape.positions.push([r * x, r * y, r * z]);
                    shape.positions.len() as u32 - 1
                });
            }
        }
        for i in 0..n {
            for j in 0..n - i {
                let (a, b, c) = (grid[i][j], grid[i + 1][j], grid[i][j + 1]);
                shape.triangles.push([a, b, c]);
                if i + j + 1 < n {
                    shape.triangles.push([b, grid[i + 1][j + 1], c]);
                }
            }
        }
    }
    shape
}

/// p' with one fused multiply-add per mode, as the poses of this workload were once defined.
fn fused(body: &Body, q: &[f32]) -> Vec<[f32; 3]> {
    let n = body.positions.len();
    let mut all = body.positions.clone();
    for (field, q) in body.fields.chunks_exact(n).zip(q) {
        for (p, u) in all.iter_mut().zip(field) {
            for k in 0..3 {
                p[k] = u[k].mul_add(*q, p[k]);
            }
        }
    }
    all
}

/// The points turned by the rows of a matrix.
fn turned(rows: &[[f64; 3]; 3], points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let rows = rows.map(|row| row.map(|x| x as f32));
    let turn =
        |p: &[f32; 3]| rows.map(|[a, b, c]| a.mul_add(p[0], b.mul_add(p[1], c.mul_add(p[2], 0.0))));
    points.iter().map(turn).collect()
}

/// How far B has to move along x so that it enters A by `depth`, on a grid over y and z.
fn approach(a: &[[f32; 3]], b: &[[f32; 3]], depth: f32) -> f32 {
    const SIDE: usize = 64;
    let cell = |p: &[f32; 3]| {
        let at = [p[1], p[2]].map(|c| (c + 1.0) * 0.5 * SIDE as f32);
        let inside = at.iter().all(|x| (0.0..SIDE as f32).contains(x));
        inside.then(|| at[0] as usize * SIDE + at[1] as usize)
    };
    let mut front = vec![f32::MIN; SIDE * SIDE];
    let mut back = vec![f32::MAX; SIDE * SIDE];
    for p in a.iter().filter(|p| p[0] > 0.0) {
        if let Some(c) = cell(p) {
            front[c] = front[c].max(p[0]);
        }
    }
    for p in b.iter().filter(|p| p[0] < 0.0) {
        if let Some(c) = cell(p) {
            back[c] = back[c].min(p[0]);
        }
    }
    let gap = front
        .iter()
        .zip(&back)
        .filter(|(f, b)| **f > f32::MIN && **b < f32::MAX)
        .map(|(f, b)| b - f)
        .fold(f32::MAX, f32::min);
    -gap - depth
}

/// The workload: bodies of 35 280 triangles, 208 to 403 touching pairs of triangles a frame.
pub fn bodies() -> Bodies {
    let body = blob("blob36k", 42, 3);
    let q = [4, 5].map(|seed| sequence(FRAMES, MODES, 0.8, seed));
    let mut stream = Stream::new(6);
    let turns = [stream.rotation(), stream.rotation()];
    let [rows_a, rows_b] = turns.map(matrix);
    // Both are turned, pushed together along x, and seen from A again.
    let place = |far: f32| {
        let along = rows_a[0].map(|x| x * f64::from(far));
        Place::new(undo_after(turns[0], turns[1]), along)
    };
    let rest = [
        turned(&rows_a, &body.positions),
        turned(&rows_b, &body.positions),
    ];
    let (mut places, mut rigid_places) = (Vec::new(), Vec::new());
    for t in 0..FRAMES {
        let swing = (TAU * 3.0 * t as f64 / FRAMES as f64).sin() as f32;
        let depth = 0.12 + 0.06 * swing;
        let own = t * MODES..(t + 1) * MODES;
        let a = turned(&rows_a, &fused(&body, &q[0][own.clone()]));
        let b = turned(&rows_b, &fused(&body, &q[1][own]));
        places.push(place(approach(&a, &b, depth)));
        rigid_places.push(place(approach(&rest[0], &rest[1], depth)));
    }
    Bodies {
        body,
        q,
        places,
        rigid_places,
    }
}

impl Bodies {
    /// q of A and of B.
    pub fn q(&self, frame: usize) -> [&[f32]; 2] {
        let own = frame * MODES..(frame + 1) * MODES;
        [&self.q[0][own.clone()], &self.q[1][own]]
    }
}
