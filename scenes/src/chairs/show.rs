//! Pictures of a scene: bodies where they are, contacts of the last step as small red spheres.

use std::error::Error;
use std::io::BufWriter;
use std::path::Path;

use bdtree_dynamics::BodyId;
use bdtree_output::write_whole;
use bdtree_render::{Body, Crowd, Floor, Gpu, Image, Shot, Sphere};

use super::scene::Scene;
use crate::film;

/// Takes pictures; the camera does not move.
pub(super) struct Show {
    crowd: Crowd,
    size: [u32; 2],
    /// Half the width of the square above which chairs begin to fall, m.
    half_width: f32,
    /// Distance of the camera over it.
    away: f32,
}

impl Show {
    pub(super) fn new(scene: &Scene, size: [u32; 2]) -> Result<Self, Box<dyn Error>> {
        let models = std::slice::from_ref(&scene.model);
        let crowd = Crowd::new(Gpu::offscreen()?, models, Crowd::BATCH_BYTES)?;
        Ok(Self {
            crowd,
            size,
            half_width: scene.waves.half_width() as f32,
            // A heap is wider than the waves that make it.
            away: match scene.waves.waves() {
                1 => 2.4,
                waves => 3.1 + 0.02 * waves.min(50) as f32,
            },
        })
    }

    /// The scene as it is now, and spheres.
    pub(super) fn picture(
        &mut self,
        scene: &Scene,
        spheres: &[Sphere],
    ) -> Result<Image, Box<dyn Error>> {
        let modes = scene.model.asset().mode_count();
        let all_q: Vec<Vec<f32>> = (0..scene.world.len())
            .map(|body| {
                let mut q: Vec<f32> = scene.q(body)?.iter().map(|q| *q as f32).collect();
                q.resize(modes, 0.0);
                Ok(q)
            })
            .collect::<Result<_, Box<dyn Error>>>()?;
        let bodies: Vec<Body<'_>> = (all_q.iter().enumerate())
            .map(|(body, q)| {
                let at = scene.world.placement(BodyId(body))?;
                Ok(Body::new(0, q, at, film::colour(body)))
            })
            .collect::<Result<_, Box<dyn Error>>>()?;
        let wide = self.half_width;
        let away = self.away * wide + 1.5;
        let eye = [0.3 * away, 0.36 * away + 0.5, 0.88 * away];
        let shot = Shot {
            background: film::BACKGROUND,
            floor: Some(Floor {
                height: 0.0,
                middle: [0.0; 2],
                radius: 2.0 * wide + 1.0,
                colour: film::FLOOR,
            }),
            bodies: &bodies,
            spheres,
            ..Shot::new(self.size, film::view(eye, [0.0, 0.12 * wide + 0.2, 0.0]))
        };
        Ok(self.crowd.picture(&shot)?.image)
    }

    /// The points at which bodies pushed each other or the ground in the last step.
    pub(super) fn contacts(&self, scene: &Scene) -> Vec<Sphere> {
        let pushing = scene
            .world
            .contacts()
            .filter(|contact| contact.force != [0.0; 3]);
        let sphere = |contact: bdtree_dynamics::ContactRecord| Sphere {
            center: contact.point.map(|x| x as f32),
            radius: 0.012 + 0.003 * self.half_width,
            colour: film::RED,
        };
        pushing.map(sphere).collect()
    }
}

/// Writes a picture, whole or not at all.
pub(super) fn write(path: &Path, image: &Image) -> Result<(), Box<dyn Error>> {
    write_whole(path, |out| image.write_png(BufWriter::new(out)))?;
    Ok(())
}
