//! Deformed vertices of one body in the world, twelve bytes each, to be read sixteen at a time.

use bdtree_runtime::narrow::Triangle;
use glam::{Vec3A, Vec4};

use crate::Body;

/// x, y, z of all vertices and one number more.
#[derive(Debug, Clone)]
pub(super) struct Vertices(pub(super) Vec<f32>);

impl Vertices {
    /// At rest.
    pub(super) fn new(body: &Body) -> Self {
        let mut flat = body.at_rest().as_flattened().to_vec();
        flat.push(0.0);
        Self(flat)
    }

    /// One of them.
    #[inline(always)]
    pub(super) fn get(&self, vertex: u32) -> Vec3A {
        let at = 3 * vertex as usize;
        Vec3A::from_vec4(Vec4::from_slice(&self.0[at..at + 4]))
    }

    /// A triangle's corners.
    #[inline(always)]
    pub(super) fn corners(&self, corners: [u32; 3]) -> [Vec3A; 3] {
        let [a, b, c] = corners;
        [self.get(a), self.get(b), self.get(c)]
    }

    /// A triangle's corners in f64, for the exact tests.
    #[inline(always)]
    pub(super) fn exact(&self, corners: [u32; 3]) -> Triangle {
        corners.map(|v| {
            let at = 3 * v as usize;
            let p = &self.0[at..at + 3];
            [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])]
        })
    }
}

/// The box around a ball, rounded outwards.
pub(super) fn box_of(center: [f64; 3], radius: f64) -> [Vec3A; 2] {
    let low = center.map(|c| ((c - radius) as f32).next_down());
    let high = center.map(|c| ((c + radius) as f32).next_up());
    [Vec3A::from_array(low), Vec3A::from_array(high)]
}
