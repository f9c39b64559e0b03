//! Spheres and lines as callers give them and as shaders take them.

use zerocopy::{Immutable, IntoBytes};

use crate::camera::Camera;

/// A sphere to draw.
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, Immutable)]
#[repr(C)]
pub struct Sphere {
    /// Its center.
    pub center: [f32; 3],
    /// Its radius.
    pub radius: f32,
    /// Red, green, blue, opacity; 255 is opaque.
    pub colour: [u8; 4],
}

/// A line to draw.
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, Immutable)]
#[repr(C)]
pub struct Line {
    /// From where to where.
    pub ends: [[f32; 3]; 2],
    /// Red, green, blue, opacity.
    pub colour: [u8; 4],
    /// In pixels.
    pub width: f32,
}

/// The spheres that can be seen in the order in which they are drawn, and how many of them are opaque:
/// those first, then the others from far to near, by their points nearest to the eye.
pub(super) fn sphere_instances(spheres: &[Sphere], camera: &Camera) -> (Vec<Sphere>, u32) {
    let is_sound = |s: &&Sphere| {
        s.center.iter().all(|x| x.is_finite()) && s.radius > 0.0 && s.radius.is_finite()
    };
    let (mut all, translucent): (Vec<Sphere>, Vec<Sphere>) = spheres
        .iter()
        .filter(is_sound)
        .partition(|sphere| sphere.colour[3] == 255);
    let opaque = all.len() as u32;
    let mut keyed: Vec<(f32, Sphere)> = translucent
        .into_iter()
        .filter(|sphere| sphere.colour[3] > 0)
        .map(|s| (camera.eye.distance(s.center.into()) - s.radius, s))
        .collect();
    keyed.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.extend(keyed.into_iter().map(|(_, sphere)| sphere));
    (all, opaque)
}
