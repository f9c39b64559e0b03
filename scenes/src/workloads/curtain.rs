//! W1: a ball goes through a folded curtain.

use bdtree_build::input::RawMesh;
use bdtree_measure::Body;

use super::{sequence, with_modes};

/// Modes of the curtain.
const MODES: usize = 12;

/// Frames of the motion.
pub const FRAMES: usize = 110;

/// Vertices across and down of the curtains of 12 thousand, 200 thousand and 2 million triangles.
pub const SIZES: [(&str, usize, usize); 3] = [
    ("cloth12k", 79, 78),
    ("cloth200k", 317, 317),
    ("cloth2m", 1001, 1001),
];

/// The curtain's coordinates and the ball, frame by frame.
#[derive(Debug, Clone)]
pub struct Curtain {
    /// The cloth.
    pub body: Body,
    /// q, frame after frame.
    pub q: Vec<f32>,
    /// Center and radius.
    pub balls: Vec<[f32; 4]>,
}

/// The folded sheet over [−1, 1]² with `across` × `down` vertices, and its modes.
pub fn cloth(name: &'static str, across: usize, down: usize) -> Body {
    let mut positions = Vec::with_capacity(across * down);
    for j in 0..down {
        for i in 0..across {
            let x = -1.0 + 2.0 * i as f64 / (across - 1) as f64;
            let y = -1.0 + 2.0 * j as f64 / (down - 1) as f64;
            let fold = 0.05 * (9.0 * x + 0.7 * y).sin() + 0.02 * (5.0 * y).sin();
            positions.push([x, y, fold]);
        }
    }
    let mut triangles = Vec::with_capacity(2 * (across - 1) * (down - 1));
    for j in 0..down - 1 {
        for i in 0..across - 1 {
            let here = (j * across + i) as u32;
            let below = here + across as u32;
            triangles.push([here, here + 1, below + 1]);
            triangles.push([here, below + 1, below]);
        }
    }
    let mesh = RawMesh {
        positions,
        triangles,
        ..RawMesh::default()
    };
    with_modes(&mesh, name, MODES, 3.0, 1)
}

/// The workload on a cloth of this size.
pub fn curtain(name: &'static str, across: usize, down: usize) -> Curtain {
    let balls = (0..FRAMES).map(|t| {
        let s = t as f64 / (FRAMES - 1) as f64;
        [-0.35 + 0.7 * s, 0.25 - 0.4 * s, -0.4 + 0.8 * s, 0.1].map(|x| x as f32)
    });
    Curtain {
        body: cloth(name, across, down),
        q: sequence(FRAMES, MODES, 0.8, 2),
        balls: balls.collect(),
    }
}

impl Curtain {
    /// q of a frame.
    pub fn q(&self, frame: usize) -> &[f32] {
        let modes = self.body.modes;
        &self.q[frame * modes..(frame + 1) * modes]
    }

    /// Center and radius of a frame's ball.
    pub fn ball(&self, frame: usize) -> ([f64; 3], f64) {
        let [x, y, z, radius] = self.balls[frame].map(f64::from);
        ([x, y, z], radius)
    }
}
