//! Which spheres queries updated (the paper's figure 7).
//!
//! A world asks the trees of two bodies where one of them has left the allowance of the last answer. The picture has the spheres that
//! were updated for the answers in use: in a step in which all bodies are asked again those are what it updated.

use std::error::Error;

use bdtree_dynamics::BodyId;
use bdtree_render::{NodeSphere, Sphere};

use super::scene::Chairs;

/// Opacity of spheres.
const OPACITY: u8 = 70;

/// Of levels, the root's first; those below have the last one's colour.
const COLOURS: [[u8; 3]; 4] = [
    [92, 104, 116],
    [44, 110, 178],
    [240, 150, 30],
    [214, 40, 40],
];

/// Updated spheres, and how many nodes they belong to.
pub(super) struct Updated {
    /// Those below which nothing was updated.
    pub(super) spheres: Vec<Sphere>,
    pub(super) nodes: usize,
}

pub(super) fn updated(scene: &Chairs) -> Result<Updated, Box<dyn Error>> {
    let world = &scene.world;
    let nodes_each = scene.nodes_each()[1] as u32;
    let mut found = Updated {
        spheres: Vec::new(),
        nodes: 0,
    };
    for (body, instance) in world.instances().iter().enumerate() {
        let mut own = Vec::new();
        for node in 0..nodes_each {
            if world.has_updated(BodyId(body), node)? {
                own.push(node);
            }
        }
        found.nodes += own.len();
        for sphere in NodeSphere::of_nodes(&instance.pose(), own.iter().copied())? {
            let goes_on = sphere
                .child
                .is_some_and(|child| own.binary_search(&child).is_ok());
            if !goes_on && sphere.radius.is_finite() {
                let [r, g, b] = COLOURS[sphere.level.min(COLOURS.len() - 1)];
                found.spheres.push(Sphere {
                    center: sphere.center.map(|x| x as f32),
                    radius: sphere.radius as f32,
                    colour: [r, g, b, OPACITY],
                });
            }
        }
    }
    Ok(found)
}
