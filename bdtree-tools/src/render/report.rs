//! What a picture shows, in numbers (`--json`).

use std::path::Path;

use bdtree_render::tightness::mean_and_max;
use serde::Serialize;

use super::arguments::Arguments;
use super::picture::{Frame, Painter};

/// One picture.
#[derive(Debug, Serialize)]
pub struct Report {
    /// Its file.
    pub output: String,
    /// The frame of the animation.
    pub frame: Option<u64>,
    /// q of the file's body; null where a scene places several.
    pub q: Option<Vec<f32>>,
    /// The level whose spheres are drawn, with the leaves above it.
    pub level: Option<usize>,
    /// Nodes of the file that the scene's queries visited.
    pub nodes_visited: Option<u64>,
    /// Of all spheres whose growth is finite.
    pub growth: Option<Growth>,
    /// The spheres that are drawn.
    pub spheres: Vec<SphereLine>,
}

/// Mean and largest growth.
#[derive(Debug, Serialize)]
pub struct Growth {
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// A sphere.
#[derive(Debug, Serialize)]
pub struct SphereLine {
    /// Its node.
    pub node: u32,
    /// Its lane there.
    pub lane: usize,
    /// World.
    pub center: [f64; 3],
    /// World units.
    pub radius: f64,
    /// What colours it; null where it is infinite.
    pub growth: Option<f64>,
    /// Where its center is in the picture; null behind the camera.
    pub pixel: Option<[f32; 2]>,
}

impl Report {
    pub(super) fn of(
        arguments: &Arguments,
        path: &Path,
        frame: &Frame<'_>,
        growths: &[f64],
        painter: &Painter<'_>,
    ) -> Self {
        let mut own = frame.content.iter().filter(|content| content.is_file);
        let q = match (own.next(), own.next()) {
            (Some(only), None) => Some(only.body.instance.q().to_vec()),
            _ => None,
        };
        let spheres = frame.content.iter().flat_map(|content| &content.spheres);
        Self {
            output: path.display().to_string(),
            frame: frame.number,
            q,
            level: arguments.spheres,
            nodes_visited: frame.nodes_visited,
            growth: mean_and_max(growths).map(|[mean, max]| Growth { mean, max }),
            spheres: spheres
                .zip(growths)
                .map(|(sphere, growth)| SphereLine {
                    node: sphere.node,
                    lane: sphere.lane,
                    center: sphere.center,
                    radius: sphere.radius,
                    growth: growth.is_finite().then_some(*growth),
                    pixel: painter.pixel(sphere.center),
                })
                .collect(),
        }
    }
}
