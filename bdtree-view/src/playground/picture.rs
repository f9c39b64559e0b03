//! The bodies as they are now, in a texture.

use bdtree_dynamics::BodyId;
use bdtree_render::{
    Body, Camera, Crowd, CrowdTexture, Floor, Gpu, Image, Line, RenderError, Shot, Sphere, texture,
};
use bdtree_runtime::{Model, Transform};
use egui::ecolor::Hsva;
use wgpu::{Texture, TextureFormat, TextureUsages};

use super::play::{Playground, follow};
use crate::picture::allows;

/// Behind everything, and the ground.
pub(super) const BACKGROUND: [u8; 4] = [232, 236, 240, 255];
const FLOOR: [u8; 3] = [206, 203, 198];
/// Contacts.
pub(super) const CONTACT: [u8; 4] = [222, 24, 20, 255];
/// The spring that holds a body.
const SPRING: [u8; 4] = [20, 60, 160, 255];

/// Radius of contacts over the largest body's reach.
const DOT: f64 = 0.03;

/// By how many pixels corners of far bodies may be moved for fewer triangles.
const COARSER_BY: f64 = 1.0;

/// A turn of hues that leaves each body's color far from those of the bodies before it.
const GOLDEN: f32 = 0.618_034;

/// What a picture shows: two equal ones look the same.
#[derive(Debug, Clone, PartialEq)]
struct View {
    camera: Camera,
    size: [u32; 2],
    /// Kind, place and q of each body.
    bodies: Vec<(usize, Transform, Vec<f32>)>,
    spheres: Vec<Sphere>,
    lines: Vec<Line>,
    /// How far the ground reaches, m.
    ground: f32,
}

impl View {
    fn of(play: &Playground, camera: Camera, size: [u32; 2]) -> Self {
        let simulation = &play.simulation;
        let bodies = simulation.of().iter().enumerate();
        let bodies = bodies.filter_map(|(body, kind)| {
            let at = simulation.world().placement(BodyId(body)).ok()?;
            Some((*kind, at, simulation.q(body)))
        });
        let reach = play.reach();
        let mut spheres = Vec::new();
        if play.has_contacts {
            let pushing = simulation.world().contacts();
            let pushing = pushing.filter(|contact| contact.force != [0.0; 3]);
            spheres.extend(pushing.map(|contact| Sphere {
                center: contact.point.map(|x| x as f32),
                radius: (DOT * reach) as f32,
                colour: CONTACT,
            }));
        }
        let lines = play.grabbed().map(|grab| Line {
            ends: grab.ends().map(|end| end.map(|x| x as f32)),
            colour: SPRING,
            width: 2.0,
        });
        Self {
            camera,
            size,
            bodies: bodies.collect(),
            spheres,
            lines: lines.into_iter().collect(),
            ground: f32::max(8.0 * reach as f32, 2.0 * camera.distance()),
        }
    }

    fn draw(&self, crowd: &mut Crowd) -> Result<CrowdTexture, RenderError> {
        let all = self.bodies.iter().enumerate();
        let bodies: Vec<Body<'_>> = all
            .map(|(k, (kind, at, q))| Body::new(*kind, q, *at, colour(k)))
            .collect();
        crowd.texture(&Shot {
            background: BACKGROUND,
            floor: Some(Floor {
                height: 0.0,
                middle: [self.camera.target.x, self.camera.target.z],
                radius: self.ground,
                colour: FLOOR,
            }),
            bodies: &bodies,
            spheres: &self.spheres,
            lines: &self.lines,
            coarser_by: COARSER_BY,
            ..Shot::new(self.size, self.camera)
        })
    }
}

/// Of a body: told apart from others, and from the red of contacts by being paler.
fn colour(body: usize) -> [u8; 3] {
    let turn = body as f32 * GOLDEN;
    let [saturation, value] = [[0.45, 0.9], [0.6, 0.75], [0.25, 0.95]][body % 3];
    let [r, g, b, _] =
        Hsva::new(0.58 + turn - turn.floor(), saturation, value, 1.0).to_srgba_unmultiplied();
    [r, g, b]
}

/// The picture of a window.
pub(crate) struct Picture {
    crowd: Crowd,
    pub(super) texture: Texture,
    drawn: Option<View>,
}

fn crowd(gpu: &Gpu, play: &Playground) -> Result<Crowd, RenderError> {
    let kinds = play.simulation.kinds().iter();
    let models: Vec<Model> = kinds.map(|kind| kind.model.clone()).collect();
    Crowd::new(gpu.clone(), &models, Crowd::BATCH_BYTES)
}

impl Picture {
    /// Of one pixel, with all files on the device.
    pub(super) fn new(gpu: &Gpu, play: &Playground) -> Result<Self, RenderError> {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let format = TextureFormat::Rgba8Unorm;
        Ok(Self {
            crowd: crowd(gpu, play)?,
            texture: texture(&gpu.device, "bodies", [1, 1], 1, format, usage),
            drawn: None,
        })
    }

    /// Makes it show the bodies, and returns whether its texture is another one.
    pub(super) fn draw(
        &mut self,
        play: &mut Playground,
        size: [u32; 2],
    ) -> Result<bool, RenderError> {
        let Some(camera) = play.camera else {
            return Ok(false);
        };
        if size.contains(&0) {
            return Ok(false);
        }
        allows(self.crowd.gpu(), size)?;
        let view = View::of(play, camera, size);
        if self.drawn.as_ref() == Some(&view) {
            return Ok(false);
        }
        let CrowdTexture { texture, times } = view.draw(&mut self.crowd)?;
        follow(&mut play.times.drawing, 1e3 * times.total());
        self.drawn = Some(view);
        let is_new = texture != self.texture;
        self.texture = texture;
        Ok(is_new)
    }
}

/// The picture without a window, and the adapter that has drawn it.
///
/// # Errors
/// No adapter, more than it takes.
pub(super) fn picture(
    play: &mut Playground,
    size: [u32; 2],
) -> Result<(Image, String), RenderError> {
    let gpu = Gpu::offscreen()?;
    let mut crowd = crowd(&gpu, play)?;
    play.fit(size[0] as f32 / size[1] as f32);
    let camera = play
        .camera
        .ok_or(RenderError::Device("no camera".to_string()))?;
    let drawn = View::of(play, camera, size).draw(&mut crowd)?;
    play.times.drawing = Some(1e3 * drawn.times.total());
    let adapter = gpu.adapter.get_info().name;
    Ok((gpu.read_back(&drawn.texture)?, adapter))
}
