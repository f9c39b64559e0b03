//! Pictures of a scene: bodies where they are, contacts of the last step as small red spheres.

use std::error::Error;
use std::io::BufWriter;
use std::path::Path;

use bdtree_dynamics::{BodyId, ContactRecord};
use bdtree_output::write_whole;
use bdtree_render::{Body, Camera, Crowd, Floor, Gpu, Image, Shot, Sphere};
use serde_json::{Value, json};

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
    drawn: Drawn,
}

/// Sums over all pictures.
#[derive(Debug, Default)]
struct Drawn {
    pictures: u64,
    bodies: u64,
    culled_by_sphere: u64,
    culled_by_tree: u64,
    triangles: u64,
    /// Of all bodies, left out or not.
    triangles_of_all: u64,
    seconds: f64,
}

impl Show {
    pub(super) fn new(scene: &impl Scene, size: [u32; 2]) -> Result<Self, Box<dyn Error>> {
        let crowd = Crowd::new(Gpu::offscreen()?, &scene.models(), Crowd::BATCH_BYTES)?;
        Ok(Self {
            crowd,
            size,
            drawn: Drawn::default(),
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
        let sums = &mut self.drawn;
        sums.pictures += 1;
        sums.bodies += picture.drawn as u64;
        sums.culled_by_sphere += picture.culled_by_sphere as u64;
        sums.culled_by_tree += picture.culled_by_tree as u64;
        sums.triangles += picture.triangles;
        sums.triangles_of_all += all as u64;
        sums.seconds += picture.times.total();
        Ok(picture.image)
    }

    /// The points at which bodies pushed each other or the ground in the last step.
    pub(super) fn contacts(&self, scene: &impl Scene) -> Vec<Sphere> {
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

    /// Bodies and triangles of a picture, in the mean over all of this run's.
    pub(super) fn told(&self) -> Value {
        let sums = &self.drawn;
        let each = |sum: u64| sum as f64 / sums.pictures as f64;
        json!({"pictures": sums.pictures, "bodies": each(sums.bodies),
            "left_out_by_sphere": each(sums.culled_by_sphere),
            "left_out_by_tree": each(sums.culled_by_tree), "triangles": each(sums.triangles),
            "triangles_of_all": each(sums.triangles_of_all),
            "times": {"seconds": sums.seconds / sums.pictures as f64}})
    }
}

/// Writes a picture, whole or not at all.
pub(crate) fn write(path: &Path, image: &Image) -> Result<(), Box<dyn Error>> {
    write_whole(path, |out| image.write_png(BufWriter::new(out)))?;
    Ok(())
}
