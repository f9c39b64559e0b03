//! W4: a thousand stiff bodies in a tilted lattice, most neighbours just apart.

use super::bodies::{MODES, blob};
use super::random::Stream;
use bdtree_measure::Body;
use bdtree_measure::place::{Place, matrix};

use super::sequence;

/// Bodies along each side of the lattice.
const SIDE: usize = 10;

/// Number of bodies.
pub const COUNT: usize = SIDE * SIDE * SIDE;

/// Steps of the motion.
pub const STEPS: usize = 3;

/// Instances of one body, each with its own q and place.
#[derive(Debug, Clone)]
pub struct Pile {
    /// What all are instances of.
    pub body: Body,
    /// q of step, body, mode.
    pub q: Vec<f32>,
    /// Place of step, body.
    pub places: Vec<Place>,
    /// Neighbours: those that may touch.
    pub pairs: Vec<[u32; 2]>,
}

/// The workload: bodies of 18 000 triangles.
pub fn pile() -> Pile {
    let body = blob("blob18k", 30, 9);
    let mut stream = Stream::new(10);
    let mut q = vec![0.0_f32; STEPS * COUNT * MODES];
    let mut places = vec![Place::IDENTITY; STEPS * COUNT];
    let mut centers = Vec::with_capacity(COUNT);
    // A lattice along the axes would flatter trees of boxes.
    let tilt = matrix(stream.rotation());
    for i in 0..COUNT {
        let own = sequence(40, MODES, 0.15, stream.bits());
        let turn = stream.rotation();
        let cell = [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
        let cell = cell.map(|k| 2.11 * k as f64 + 0.03 * stream.signed());
        let center = tilt.map(|row| row[0] * cell[0] + row[1] * cell[1] + row[2] * cell[2]);
        let drift = stream.direction();
        for t in 0..STEPS {
            let at = (t * COUNT + i) * MODES;
            q[at..at + MODES].copy_from_slice(&own[t * MODES..(t + 1) * MODES]);
            let far = 0.01 * t as f64;
            let center = [0, 1, 2].map(|k| center[k] + far * drift[k]);
            places[t * COUNT + i] = Place::new(turn, center);
        }
        centers.push(center);
    }
    let mut pairs = Vec::new();
    for i in 0..COUNT {
        for j in i + 1..COUNT {
            let apart = [0, 1, 2].map(|k| (centers[i][k] - centers[j][k]).powi(2));
            if apart[0] + apart[1] + apart[2] < 2.5 * 2.5 {
                pairs.push([i as u32, j as u32]);
            }
        }
    }
    Pile {
        body,
        q,
        places,
        pairs,
    }
}

impl Pile {
    /// q of a body at a step.
    pub fn q(&self, step: usize, body: usize) -> &[f32] {
        let at = (step * COUNT + body) * MODES;
        &self.q[at..at + MODES]
    }

    /// The place of a body at a step.
    pub fn place(&self, step: usize, body: usize) -> &Place {
        &self.places[step * COUNT + body]
    }
}
