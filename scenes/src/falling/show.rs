//! Pictures of a scene: bodies where they are, contacts of the last step as small red spheres.

use std::error::Error;
use std::io::BufWriter;
use std::path::Path;

use bdtree_dynamics::{BodyId, ContactRecord};
use bdtree_output::write_whole;
use bdtree_render::{Body, Camera, Crowd, Floor, Gpu, Image, Shot, Sphere};
use serde_json::{Value, json};

use super::log::columns;
use super::{Scene, q};
use crate::film;

/// Where a scene is seen from, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    pub(crate) camera: Camera,
    pub(crate) floor: Floor,
    /// Of the spheres that are contacts, m; without it, none are drawn.
    pub(crate) contact_radius: Option<f32>,
    /// By how many pixels corners of far bodies may be moved.
    pub(crate) coarser_by: f64,
}

/// Takes pictures; the camera does not move.
pub(crate) struct Show {
    crowd: Crowd,
    size: [u32; 2],
    /// What each picture shows.
    pub(crate) drawn: Vec<Drawn>,
}

columns! {
/// What a picture shows.
Drawn {
    bodies,
    left_out_by_sphere,
    left_out_by_tree,
    triangles,
    /// Of all bodies, left out or not.
    triangles_of_all,
    seconds,
}
}

impl Show {
    pub(crate) fn new(scene: &impl Scene, size: [u32; 2]) -> Result<Self, Box<dyn Error>> {
        let crowd = Crowd::new(Gpu::offscreen()?, &scene.models(), Crowd::BATCH_BYTES)?;
        Ok(Self {
            crowd,
            size,
            drawn: Vec::new(),
        })
    }

    /// The scene as it is now, and spheres.
    pub(crate) fn picture(
        &mut self,
        scene: &impl Scene,
        spheres: &[Sphere],
    ) -> Result<Image, Box<dyn Error>> {
        let (world, models) = (scene.world(), scene.models());
        let all_q: Vec<Vec<f32>> = (0..world.len())
            .map(|body| {
                let mut q: Vec<f32> = q(world, body)?.iter().map(|q| *q as f32).collect();
                let (asset, _) = scene.look(body);
                q.resize(models[asset].asset().mode_count(), 0.0);
                Ok(q)
            })
            .collect::<Result<_, Box<dyn Error>>>()?;
        let bodies: Vec<Body<'_>> = (all_q.iter().enumerate())
            .map(|(body, q)| {
                let at = world.placement(BodyId(body))?;
                let (asset, colour) = scene.look(body);
                Ok(Body::new(asset, q, at, colour))
            })
            .collect::<Result<_, Box<dyn Error>>>()?;
        let view = scene.view();
        let shot = Shot {
            background: film::BACKGROUND,
            floor: Some(view.floor),
            bodies: &bodies,
            spheres,
            coarser_by: view.coarser_by,
            ..Shot::new(self.size, view.camera)
        };
        let picture = self.crowd.picture(&shot)?;
        let all: usize = (bodies.iter())
            .map(|body| models[body.asset].asset().triangle_count())
            .sum();
        self.drawn.push(Drawn {
            bodies: picture.drawn as f64,
            left_out_by_sphere: picture.culled_by_sphere as f64,
            left_out_by_tree: picture.culled_by_tree as f64,
            triangles: picture.triangles as f64,
            triangles_of_all: all as f64,
            seconds: picture.times.total(),
        });
        Ok(picture.image)
    }

    /// The points at which bodies pushed each other or the ground in the last step.
    pub(crate) fn contacts(&self, scene: &impl Scene) -> Vec<Sphere> {
        let Some(radius) = scene.view().contact_radius else {
            return Vec::new();
        };
        let pushing = (scene.world().contacts()).filter(|contact| contact.force != [0.0; 3]);
        let sphere = |contact: ContactRecord| Sphere {
            center: contact.point.map(|x| x as f32),
            radius,
            colour: film::RED,
        };
        pushing.map(sphere).collect()
    }

    /// What draws.
    pub(crate) fn adapter(&self) -> String {
        let info = self.crowd.gpu().adapter.get_info();
        [info.name, info.driver_info].join(", ")
    }

    /// Bodies and triangles of a picture, in the mean over all of this run's.
    pub(super) fn told(&self) -> Value {
        let count = self.drawn.len();
        let mean = |of: fn(&Drawn) -> f64| self.drawn.iter().map(of).sum::<f64>() / count as f64;
        json!({"pictures": count, "bodies": mean(|drawn| drawn.bodies),
            "left_out_by_sphere": mean(|drawn| drawn.left_out_by_sphere),
            "left_out_by_tree": mean(|drawn| drawn.left_out_by_tree),
            "triangles": mean(|drawn| drawn.triangles),
            "triangles_of_all": mean(|drawn| drawn.triangles_of_all),
            "times": {"adapter": self.adapter(), "size": self.size, "seconds": mean(|drawn| drawn.seconds)}})
    }
}

/// Writes a picture, whole or not at all.
pub(crate) fn write(path: &Path, image: &Image) -> Result<(), Box<dyn Error>> {
    write_whole(path, |out| image.write_png(BufWriter::new(out)))?;
    Ok(())
}
