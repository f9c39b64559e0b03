//! Embree 4: a dynamic scene of one mesh that is refitted, in a shared library that is found when the
//! program runs; the only `unsafe` of this crate.
//!
//! One thread, vertices deformed straight into Embree's memory. Balls are its point query with the
//! exact test in the callback, rays its own single-ray query.
#![allow(unsafe_code)] // calls into a C library; every block has its proof

mod api;
mod device;
mod scene;

pub use device::{Device, VARIABLE};

use std::rc::Rc;

use bdtree_runtime::Contact;

use super::{Peer, Target};
use crate::Body;
use crate::leaf;
use scene::Scene;

/// A body in Embree.
pub struct Embree {
    scene: Scene,
    triangles: Vec<[u32; 3]>,
}

impl Embree {
    /// Of a body at rest.
    ///
    /// # Errors
    /// What Embree refuses.
    pub fn new(device: &Rc<Device>, body: &Body) -> Result<Self, String> {
        Ok(Self {
            scene: Scene::new(device, body.at_rest(), &body.triangles)?,
            triangles: body.triangles.clone(),
        })
    }
}

impl Peer for Embree {
    fn update_with(&mut self, to: Target<'_>, scratch: &mut Vec<f32>, deformed: &mut dyn FnMut()) {
        to.write(scratch, self.scene.vertices_mut());
        deformed();
        self.scene.refit().expect("a mesh that was built refits");
    }

    fn ball(&mut self, center: [f64; 3], radius: f64, found: &mut Vec<Contact>) {
        let near = center.map(|c| c as f32);
        // Embree measures in f32, from a rounded center: a few roundings more, so that nothing is lost.
        let off = (0..3).map(|k| (center[k] - f64::from(near[k])).abs());
        let wide = (radius + off.sum::<f64>()) * (1.0 + 8.0 * f64::from(f32::EPSILON));
        let vertices = self.scene.vertices().as_chunks::<3>().0;
        self.scene.near(near, wide as f32, |id| {
            let corners = self.triangles[id as usize].map(|v| vertices[v as usize].map(f64::from));
            leaf::ball(id, &corners, center, radius, found);
        });
    }

    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
        self.scene.ray(origin, direction).map(f64::from)
    }
}
