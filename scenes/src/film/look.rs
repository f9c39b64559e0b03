//! Colours, floor and camera of all films.

use std::f32::consts::TAU;

use bdtree_render::{Camera, Line};

/// Colours of bodies: plastics that are told apart beside each other, and from [`RED`].
pub const PALETTE: [[u8; 3]; 8] = [
    [236, 236, 228],
    [44, 110, 178],
    [240, 176, 44],
    [62, 150, 98],
    [232, 120, 52],
    [112, 190, 214],
    [126, 92, 160],
    [92, 104, 116],
];

/// Contacts.
pub const RED: [u8; 4] = [222, 24, 20, 255];

/// Behind everything.
pub const BACKGROUND: [u8; 4] = [232, 236, 240, 255];

/// The floor.
pub const FLOOR: [u8; 3] = [206, 203, 198];

/// The colour of a body.
pub fn colour(body: usize) -> [u8; 3] {
    colour_of(body, &PALETTE)
}

/// The same of other colours: its number's, in an order without pattern, so that neighbours in a list differ.
pub fn colour_of(body: usize, palette: &[[u8; 3]]) -> [u8; 3] {
    let mut x = body as u64 ^ 0x9e37_79b9_7f4a_7c15;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    palette[(x >> 33) as usize % palette.len()]
}

/// A camera at `eye` that looks at `target`, y up.
pub fn view(eye: [f32; 3], target: [f32; 3]) -> Camera {
    Camera {
        eye: eye.into(),
        target: target.into(),
        up: [0.0, 1.0, 0.0].into(),
        fov_y_rad: 0.6,
    }
}

/// Three circles of a sphere, one about each axis: a sphere that hides nothing.
pub fn sphere_wires(center: [f32; 3], radius: f32, colour: [u8; 4], width: f32) -> Vec<Line> {
    const PARTS: usize = 32;
    let mut lines = Vec::with_capacity(3 * PARTS);
    for axis in 0..3 {
        let at = |part: usize| {
            let (s, c) = (TAU * part as f32 / PARTS as f32).sin_cos();
            let mut point = center;
            point[(axis + 1) % 3] += radius * c;
            point[(axis + 2) % 3] += radius * s;
            point
        };
        lines.extend((0..PARTS).map(|part| Line {
            ends: [at(part), at(part + 1)],
            colour,
            width,
        }));
    }
    lines
}
