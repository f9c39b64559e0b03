//! Many bodies of a few assets in one picture.
//!
//! Bodies that the picture does not show are left out ([`Camera::frustum`]). The others are deformed on the device and
//! drawn in batches, which keep the memory for deformed vertices within a limit however many there are: a batch is
//! deformed, drawn, and its memory is the next one's.

mod batch;
mod detail;
mod light;
mod stamps;
mod view;

use std::time::Instant;

use bdtree_gpu::Skinner;
use bdtree_runtime::{BoneMatrices, Model, Transform};
use wgpu::{Texture, TextureUsages};

use crate::camera::Camera;
use crate::error::RenderError;
use crate::gpu::Gpu;
use crate::image::Image;
use crate::renderer::{
    BodyPasses, Floor, Light, Line, Renderer, Scene, Sphere, allows_picture, texture,
};
use crate::studio::{FORMAT, SAMPLES};
use batch::Member;
use stamps::Stamps;
use view::{View, ViewMemory};

/// A body of a crowd.
#[derive(Debug, Clone, Copy)]
pub struct Body<'b> {
    /// Which of the crowd's assets it is made of.
    pub asset: usize,
    /// A number per mode.
    pub q: &'b [f32],
    /// Its bones, of an asset with a skin.
    pub bones: BoneMatrices<'b>,
    /// Where it stands (world).
    pub placement: Transform,
    /// Red, green, blue.
    pub colour: [u8; 3],
}

impl<'b> Body<'b> {
    /// A body whose bones, if it has any, are at rest.
    pub fn new(asset: usize, q: &'b [f32], placement: Transform, colour: [u8; 3]) -> Self {
        Self {
            asset,
            q,
            bones: BoneMatrices::Rest,
            placement,
            colour,
        }
    }
}

/// What a picture shows. y is up.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'s> {
    /// Pixels.
    pub size: [u32; 2],
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What camera, floor, spheres and lines are relative to (world): a point near the camera where the world is large.
    pub origin: [f64; 3],
    /// Behind everything: red, green, blue, opacity.
    pub background: [u8; 4],
    /// Below everything; not seen from below.
    pub floor: Option<Floor>,
    /// In any order.
    pub bodies: &'s [Body<'s>],
    /// In any order; translucent ones show what is behind them.
    pub spheres: &'s [Sphere],
    /// Later ones over earlier ones.
    pub lines: &'s [Line],
    /// Whether bodies outside of the picture are left out; the picture is the same.
    pub culls: bool,
    /// By how many pixels corners of far bodies may be moved for fewer triangles; 0: all triangles are drawn.
    pub coarser_by: f64,
}

impl Shot<'_> {
    /// A white picture of nothing.
    pub fn new(size: [u32; 2], camera: Camera) -> Self {
        Self {
            size,
            camera,
            origin: [0.0; 3],
            background: [255; 4],
            floor: None,
            bodies: &[],
            spheres: &[],
            lines: &[],
            culls: true,
            coarser_by: 0.0,
        }
    }
}

/// A picture of a crowd, and what it took.
#[derive(Debug, Clone)]
pub struct CrowdPicture {
    /// The picture.
    pub image: Image,
    /// Bodies that were drawn.
    pub drawn: usize,
    /// Bodies whose sphere lies outside of the picture.
    pub culled_by_sphere: usize,
    /// Other bodies whose triangles all do, as their trees say.
    pub culled_by_tree: usize,
    /// Triangles that were drawn of them.
    pub triangles: u64,
    /// Batches that they were drawn in.
    pub batches: usize,
    /// How long it took.
    pub times: CrowdTimes,
}

/// A picture of a crowd that stays on the device.
#[derive(Debug, Clone)]
pub struct CrowdTexture {
    /// Colours as sRGB numbers (`Rgba8Unorm`), for windows to bind; the next picture of the same size takes its place.
    pub texture: Texture,
    /// How long it took; nothing is read back.
    pub times: CrowdTimes,
}

/// How long a picture took, in seconds by the clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrowdTimes {
    /// To find the bodies that are seen.
    pub cull: f64,
    /// To copy them to the device, deform and draw them and wait for it, the shade among them included.
    pub draw: f64,
    /// To copy the picture back.
    pub read_back: f64,
    /// Of `draw` what the device took from its first command to its last, by its own timestamps if it has any.
    pub device: Option<f64>,
}

impl CrowdTimes {
    /// All of it by the clock.
    pub fn total(&self) -> f64 {
        self.cull + self.draw + self.read_back
    }
}

/// Memory on the device in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CrowdMemory {
    /// Assets, once each.
    pub assets: u64,
    /// Bodies of a batch and their deformed vertices and normals: what [`Crowd::new`] limits.
    pub batches: u64,
    /// Samples, depth, the picture and its copy, shade.
    pub pictures: u64,
}

impl CrowdMemory {
    /// All of it.
    pub fn total(&self) -> u64 {
        self.assets + self.batches + self.pictures
    }
}

/// What was drawn, and where.
struct Made {
    picture: Texture,
    batches: usize,
    triangles: u64,
    times: CrowdTimes,
}

/// Draws many bodies of a few assets, as [`Shot`]s describe them.
#[derive(Debug)]
pub struct Crowd {
    gpu: Gpu,
    renderer: Renderer,
    passes: BodyPasses,
    skinner: Skinner,
    members: Vec<Member>,
    picture: Option<Texture>,
    stamps: Option<Stamps>,
    memory: ViewMemory,
}

impl Crowd {
    /// What deformed vertices may take if nothing else is known.
    pub const BATCH_BYTES: u64 = 256 << 20;

    /// Copies assets to the device. `batch_bytes` limits the memory for bodies and their deformed vertices, in equal
    /// parts for each asset; there is room for at least one body of each, whatever it takes.
    ///
    /// # Errors
    /// More than the device takes, a corrupt asset.
    pub fn new(gpu: Gpu, models: &[Model], batch_bytes: u64) -> Result<Self, RenderError> {
        let renderer = Renderer::new(&gpu.device, FORMAT, SAMPLES);
        let passes = BodyPasses::new(&gpu.device, &renderer);
        let skinner = Skinner::new(&gpu.device, &gpu.queue)?;
        let share = batch_bytes / models.len().max(1) as u64;
        let members = models
            .iter()
            .map(|model| Member::new(&gpu, &skinner, model, share))
            .collect::<Result<_, _>>()?;
        gpu.check()?;
        Ok(Self {
            stamps: Stamps::new(&gpu),
            gpu,
            renderer,
            passes,
            skinner,
            members,
            picture: None,
            memory: ViewMemory::default(),
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Memory on the device that is taken now.
    pub fn memory(&self) -> CrowdMemory {
        let sum = |of: fn(&Member) -> u64| self.members.iter().map(of).sum();
        let picture = self.picture.as_ref().map_or(0, |picture| {
            // The copy's rows are padded to 256 bytes.
            let row = u64::from(4 * picture.width());
            (row + row.next_multiple_of(256)) * u64::from(picture.height())
        });
        CrowdMemory {
            assets: sum(Member::asset_bytes),
            batches: sum(Member::batch_bytes),
            pictures: picture + self.renderer.target_bytes() + self.passes.bytes(),
        }
    }

    /// The picture of a shot. The same device makes the same picture of the same shot, to the last bit.
    ///
    /// # Errors
    /// An asset that is not there; q, bones or a placement that it refuses; more than the device takes; a lost device.
    pub fn picture(&mut self, shot: &Shot<'_>) -> Result<CrowdPicture, RenderError> {
        let (view, made) = self.make(shot)?;
        let start = Instant::now();
        let image = self.gpu.read_back(&made.picture)?;
        let read_back = start.elapsed().as_secs_f64();
        Ok(CrowdPicture {
            image,
            drawn: view.drawn.len(),
            culled_by_sphere: view.culled_by_sphere,
            culled_by_tree: view.culled_by_tree,
            triangles: made.triangles,
            batches: made.batches,
            times: CrowdTimes {
                read_back,
                ..made.times
            },
        })
    }

    /// The same picture, drawn and left on the device.
    ///
    /// # Errors
    /// Those of [`Crowd::picture`].
    pub fn texture(&mut self, shot: &Shot<'_>) -> Result<CrowdTexture, RenderError> {
        let (_, made) = self.make(shot)?;
        Ok(CrowdTexture {
            texture: made.picture,
            times: made.times,
        })
    }

    /// Draws a shot and waits for the device.
    fn make(&mut self, shot: &Shot<'_>) -> Result<(View, Made), RenderError> {
        allows_picture(&self.gpu.device, shot.size)?;
        let start = Instant::now();
        // Without a frustum, of a camera that is nowhere, nothing can be left out.
        let frustum = shot.camera.frustum(shot.size, shot.origin);
        let frustum = frustum.as_ref().filter(|_| shot.culls);
        let models: Vec<&Model> = self.members.iter().map(Member::model).collect();
        let eye = shot.camera.eye.as_dvec3().to_array();
        let eye = [0, 1, 2].map(|k| shot.origin[k] + eye[k]);
        let view = View::of(&models, shot.bodies, (eye, frustum), &mut self.memory)?;
        let cull = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let picture = self.target(shot.size);
        let (batches, triangles) = self.draw(shot, &view, &picture)?;
        self.gpu.finish()?;
        let draw = start.elapsed().as_secs_f64();
        let device = self.stamps.as_ref().and_then(|s| s.seconds(&self.gpu));
        let times = CrowdTimes {
            cull,
            draw,
            read_back: 0.0,
            device,
        };
        let made = Made {
            picture,
            batches,
            triangles,
            times,
        };
        Ok((view, made))
    }

    /// The texture of pictures of a size.
    fn target(&mut self, size: [u32; 2]) -> Texture {
        let kept = self.picture.take();
        let fits = |kept: &Texture| [kept.width(), kept.height()] == size;
        let usage = TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::COPY_SRC
            | TextureUsages::TEXTURE_BINDING;
        let picture = kept
            .filter(fits)
            .unwrap_or_else(|| texture(&self.gpu.device, "picture", size, 1, FORMAT, usage));
        self.picture.insert(picture).clone()
    }

    /// Deforms and draws, a submission for each batch and one for all else. Returns how many batches, and triangles of
    /// bodies.
    fn draw(
        &mut self,
        shot: &Shot<'_>,
        view: &View,
        picture: &Texture,
    ) -> Result<(usize, u64), RenderError> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let floor = shot.floor.filter(|floor| shot.camera.eye.y > floor.height);
        let light = Light::among(
            &view.spheres,
            shot.origin,
            shot.floor.map(|floor| floor.height),
        );
        self.passes.write(queue, &light, floor, shot.background);
        let scene = Scene {
            background: shot.background,
            ground: None,
            meshes: &[],
            spheres: shot.spheres,
            lines: shot.lines,
        };
        let shapes = (self.renderer).prepare(device, queue, shot.size, &shot.camera, &scene)?;
        let target = picture.create_view(&Default::default());
        let mut clear = Some(shot.background);
        let (mut batches, mut triangles) = (0, 0);
        // World units per pixel at a unit's distance.
        let pixel = 2.0 * f64::from((0.5 * shot.camera.fov_y_rad).tan()) / f64::from(shot.size[1]);
        let mut encoder = device.create_command_encoder(&Default::default());
        if let Some(stamps) = &self.stamps {
            stamps.begin(&mut encoder);
        }
        let mut rest = &view.drawn[..];
        while let Some(first) = rest.first() {
            let asset = first.asset;
            let own = rest.partition_point(|drawn| drawn.asset == asset);
            let member = &mut self.members[asset];
            member.make_room(&self.gpu, &self.skinner, own)?;
            let (now, later) = rest.split_at(own.min(member.room()));
            rest = later;
            member.deform(
                (&self.skinner, queue, &mut encoder),
                shot,
                now,
                shot.coarser_by * pixel,
            )?;
            triangles += member.triangles();
            let mut pass = (self.renderer).pass(&mut encoder, &target, clear.take(), false)?;
            if let Some(buffers) = member.buffers() {
                self.passes.draw_bodies(&mut pass, &buffers);
            }
            drop(pass);
            queue.submit([encoder.finish()]);
            batches += 1;
            encoder = device.create_command_encoder(&Default::default());
        }
        let mut pass = self.renderer.pass(&mut encoder, &target, clear, true)?;
        if floor.is_some() {
            self.passes.draw_floor(&mut pass);
        }
        let lines = shot.lines.len() as u32;
        self.renderer.draw_shapes(&mut pass, shapes, lines);
        drop(pass);
        if let Some(stamps) = &self.stamps {
            stamps.end(&mut encoder);
        }
        queue.submit([encoder.finish()]);
        Ok((batches, triangles))
    }
}
