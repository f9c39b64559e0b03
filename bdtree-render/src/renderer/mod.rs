//! Draws meshes, spheres and lines into a texture.
//!
//! Spheres are exact: a square per sphere whose pixels meet it by ray, so that many are cheap to
//! store and none has corners. Opaque ones are drawn in any order, translucent ones from far to near,
//! by where they begin. Lines come last.

mod bodies;
mod globals;
mod mesh;
mod pipelines;
mod shapes;
mod targets;

pub use bodies::Floor;
pub(crate) use bodies::{BodyBuffers, BodyPasses, Light};
pub use mesh::Mesh;
pub(crate) use mesh::filled;
pub use shapes::{Line, Sphere};
pub use targets::texture;
pub(crate) use targets::{allows_picture, extent};

use glam::Vec3;
use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, Color, CommandEncoder, Device, LoadOp, Operations,
    Queue, RenderPass, RenderPassColorAttachment, RenderPassDepthStencilAttachment,
    RenderPassDescriptor, StoreOp, TextureFormat, TextureView,
};
use zerocopy::{Immutable, IntoBytes};

use crate::camera::Camera;
use crate::error::RenderError;
use crate::gpu::Gpu;
use globals::Globals;
use pipelines::Pipelines;
use shapes::sphere_instances;
use targets::Targets;

/// A plane below meshes that only their shadows show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Its normal, away from below; unit.
    pub up: [f32; 3],
    /// The normal's product with its points.
    pub height: f32,
    /// From each shadow toward the light, as far as a unit above the ground.
    pub light: [f32; 3],
    /// Color of shadows: red, green, blue.
    pub shadow: [u8; 3],
}

impl Ground {
    /// Whether an eye is above it and sees shadows on it.
    pub fn is_seen_from(&self, eye: Vec3) -> bool {
        eye.dot(self.up.into()) > self.height
    }
}

/// What is to be seen.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'s> {
    /// Behind everything: red, green, blue, opacity.
    pub background: [u8; 4],
    /// Where meshes throw shadows; none is seen from below it.
    pub ground: Option<Ground>,
    /// Meshes, in any order.
    pub meshes: &'s [&'s Mesh],
    /// Spheres, in any order.
    pub spheres: &'s [Sphere],
    /// Lines, later ones over earlier ones. Translucent spheres do not dim them.
    pub lines: &'s [Line],
}

/// Pipelines and memory for drawing to one kind of target.
#[derive(Debug)]
pub struct Renderer {
    pipelines: Pipelines,
    globals: Globals,
    format: TextureFormat,
    samples: u32,
    targets: Option<Targets>,
    spheres: Growing,
    lines: Growing,
}

impl Renderer {
    /// For targets of a format, with `samples` per pixel (1 or 4).
    pub fn new(device: &Device, format: TextureFormat, samples: u32) -> Self {
        let globals = Globals::new(device);
        Self {
            pipelines: Pipelines::new(device, &globals.layout, format, samples),
            globals,
            format,
            samples,
            targets: None,
            spheres: Growing::new("spheres"),
            lines: Growing::new("lines"),
        }
    }

    /// A mesh in memory of the device, to be drawn by this renderer: see [`Mesh`]. Where its rest shape has
    /// creases, each triangle is shaded by its own normal.
    ///
    /// # Errors
    /// More than the device takes.
    pub fn mesh(
        &self,
        device: &Device,
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Mesh, RenderError> {
        Mesh::new(device, &self.pipelines.look_layout, rest, triangles)
    }

    /// A mesh whose positions, normals (three f32 per vertex, packed: vertex buffers) and corners (u32: an
    /// index buffer) others write, and [how smooth](crate::smoothness) it is at each vertex.
    ///
    /// # Errors
    /// More than the device takes.
    pub fn mesh_of_buffers(
        &self,
        device: &Device,
        buffers: [&Buffer; 3],
        smoothness: &[f32],
        triangle_count: u32,
    ) -> Result<Mesh, RenderError> {
        let layout = &self.pipelines.look_layout;
        Mesh::of_buffers(device, layout, buffers, smoothness, triangle_count)
    }

    /// Records the drawing of a scene into `view`, a texture of this renderer's format and of `size`
    /// pixels. What was in it is lost.
    ///
    /// # Errors
    /// More than the device takes.
    #[expect(
        clippy::too_many_arguments,
        reason = "what every drawing call of wgpu needs"
    )]
    pub fn draw(
        &mut self,
        device: &Device,
        queue: &Queue,
        encoder: &mut CommandEncoder,
        view: &TextureView,
        size: [u32; 2],
        camera: &Camera,
        scene: &Scene<'_>,
    ) -> Result<(), RenderError> {
        let opaque = self.prepare(device, queue, size, camera, scene)?;
        let clear = Some(scene.background);
        let mut pass = self.pass(encoder, view, clear, true)?;
        if scene
            .ground
            .is_some_and(|ground| ground.is_seen_from(camera.eye))
        {
            for mesh in scene.meshes {
                mesh.draw_shadow(&mut pass, &self.pipelines.shadow);
            }
        }
        for mesh in scene.meshes {
            mesh.draw(queue, &mut pass, &self.pipelines.mesh);
        }
        self.draw_shapes(&mut pass, opaque, scene.lines.len() as u32);
        Ok(())
    }

    /// Makes room for pictures of `size` pixels and writes what passes read, but for meshes. Returns how many of the
    /// spheres are opaque, and how many there are.
    pub(crate) fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        size: [u32; 2],
        camera: &Camera,
        scene: &Scene<'_>,
    ) -> Result<[u32; 2], RenderError> {
        let targets = match self.targets.take() {
            Some(targets) if targets.size == size => targets,
            _ => Targets::new(device, self.format, self.samples, size)?,
        };
        self.targets = Some(targets);
        let encode = !self.format.is_srgb();
        self.globals
            .write(queue, camera, size, encode, scene.ground);
        let (spheres, opaque) = sphere_instances(scene.spheres, camera);
        self.spheres.write(device, queue, &spheres)?;
        self.lines.write(device, queue, scene.lines)?;
        Ok([opaque, spheres.len() as u32])
    }

    /// A pass into `view`, which is cleared first where there is a colour; the last one of a picture puts its
    /// samples together. [`Renderer::prepare`] comes before.
    pub(crate) fn pass<'e>(
        &self,
        encoder: &'e mut CommandEncoder,
        view: &TextureView,
        clear: Option<[u8; 4]>,
        is_last: bool,
    ) -> Result<RenderPass<'e>, RenderError> {
        let Some(targets) = &self.targets else {
            return Err(RenderError::Device("no picture was prepared".to_string()));
        };
        let (view, resolve_target) = match &targets.samples {
            Some(samples) => (samples, is_last.then_some(view)),
            None => (view, None),
        };
        let encode = !self.format.is_srgb();
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("bdtree scene"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: Operations {
                    load: clear.map_or(LoadOp::Load, |c| LoadOp::Clear(clear_colour(c, encode))),
                    store: StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(Operations {
                    load: clear.map_or(LoadOp::Load, |_| LoadOp::Clear(0.0)),
                    store: if is_last {
                        StoreOp::Discard
                    } else {
                        StoreOp::Store
                    },
                }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_bind_group(0, &self.globals.group, &[]);
        Ok(pass)
    }

    /// Draws the spheres and lines that were prepared: opaque spheres, the others, lines.
    pub(crate) fn draw_shapes(
        &self,
        pass: &mut RenderPass<'_>,
        [opaque, count]: [u32; 2],
        lines: u32,
    ) {
        if let Some(buffer) = &self.spheres.buffer {
            pass.set_vertex_buffer(0, buffer.slice(..));
            draw_square_each(pass, &self.pipelines.opaque, 0..opaque);
            draw_square_each(pass, &self.pipelines.translucent, opaque..count);
        }
        if let Some(buffer) = &self.lines.buffer {
            pass.set_vertex_buffer(0, buffer.slice(..));
            draw_square_each(pass, &self.pipelines.lines, 0..lines);
        }
    }

    /// Bytes of the textures that drawing needs beside its target: colour and depth of each sample.
    pub(crate) fn target_bytes(&self) -> u64 {
        let pixels = self
            .targets
            .as_ref()
            .map_or(0, |targets| targets.size.map(u64::from).iter().product());
        let of_colour = if self.samples > 1 { 4 } else { 0 };
        u64::from(self.samples) * pixels * (4 + of_colour)
    }
}

/// Four corners for each of some spheres or lines.
fn draw_square_each(
    pass: &mut RenderPass<'_>,
    pipeline: &wgpu::RenderPipeline,
    instances: std::ops::Range<u32>,
) {
    if !instances.is_empty() {
        pass.set_pipeline(pipeline);
        pass.draw(0..4, instances);
    }
}

/// A clear colour as the target wants it: linear where the target encodes.
fn clear_colour([r, g, b, a]: [u8; 4], encoded: bool) -> Color {
    let of = |c: u8| {
        let c = f64::from(c) / 255.0;
        match encoded {
            true => c,
            false if c <= 0.04045 => c / 12.92,
            false => ((c + 0.055) / 1.055).powf(2.4),
        }
    };
    Color {
        r: of(r),
        g: of(g),
        b: of(b),
        a: f64::from(a) / 255.0,
    }
}

/// A vertex buffer that becomes as large as it has to be.
#[derive(Debug)]
struct Growing {
    what: &'static str,
    buffer: Option<Buffer>,
}

impl Growing {
    fn new(what: &'static str) -> Self {
        Self { what, buffer: None }
    }

    fn write<T: IntoBytes + Immutable>(
        &mut self,
        device: &Device,
        queue: &Queue,
        items: &[T],
    ) -> Result<(), RenderError> {
        let bytes = items.as_bytes();
        let needed = bytes.len() as u64;
        if needed == 0 {
            return Ok(());
        }
        let fits = |buffer: &Buffer| buffer.size() >= needed;
        let buffer = match self.buffer.take().filter(fits) {
            Some(buffer) => buffer,
            None => {
                Gpu::allows_buffer(device, self.what, needed)?;
                let most = device.limits().max_buffer_size;
                device.create_buffer(&BufferDescriptor {
                    label: Some(self.what),
                    size: needed.next_power_of_two().min(most),
                    usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            }
        };
        queue.write_buffer(self.buffer.insert(buffer), 0, bytes);
        Ok(())
    }
}
