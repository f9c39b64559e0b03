//! W3: rays from a sphere around a bumpy body towards its inside; nineteen in twenty hit.

use super::bodies::{MODES, blob};
use super::random::Stream;
use bdtree_measure::Body;

use super::sequence;

/// Frames of the motion.
pub const FRAMES: usize = 30;

/// Rays that frames take from, in turn.
pub const RAYS: usize = 100_000;

/// A deforming body and rays.
#[derive(Debug, Clone)]
pub struct Rays {
    /// The body.
    pub body: Body,
    /// q, frame after frame.
    pub q: Vec<f32>,
    /// Origin and unit direction.
    pub rays: Vec<[[f32; 3]; 2]>,
}

/// The two bodies: name and how often each face of the icosahedron is split.
pub const SIZES: [(&str, usize); 2] = [("blob36k", 42), ("blob480k", 155)];

/// The workload on a body of 20 `n`² triangles.
pub fn rays(name: &'static str, n: usize) -> Rays {
    let mut stream = Stream::new(7);
    let rays = (0..RAYS).map(|_| {
        let from = stream.direction();
        let towards = stream.direction();
        let far = stream.unit().cbrt() * 1.1;
        let d = [0, 1, 2].map(|k| towards[k] * far - 3.0 * from[k]);
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        [from.map(|x| 3.0 * x), d.map(|x| x / length)].map(|v| v.map(|x| x as f32))
    });
    Rays {
        rays: rays.collect(),
        body: blob(name, n, 3),
        q: sequence(FRAMES, MODES, 0.8, 8),
    }
}

impl Rays {
    /// q of a frame.
    pub fn q(&self, frame: usize) -> &[f32] {
        &self.q[frame * MODES..(frame + 1) * MODES]
    }

    /// The `count` rays of a frame.
    pub fn of(
        &self,
        frame: usize,
        count: usize,
    ) -> impl ExactSizeIterator<Item = [[f32; 3]; 2]> + '_ {
        (0..count).map(move |i| self.rays[(frame * count + i) % RAYS])
    }

    /// The same in the numbers that the product takes.
    pub fn wide(
        &self,
        frame: usize,
        count: usize,
    ) -> impl ExactSizeIterator<Item = [[f64; 3]; 2]> + '_ {
        self.of(frame, count)
            .map(|[origin, direction]| [widened(origin), widened(direction)])
    }
}

/// Written out: an `array::map` that is called per ray costs as much as a part of the query.
#[inline]
fn widened([x, y, z]: [f32; 3]) -> [f64; 3] {
    [x.into(), y.into(), z.into()]
}
