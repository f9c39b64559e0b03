//! Pictures in memory.

use bdtree_runtime::Asset;
use wgpu::{TextureFormat, TextureUsages};

use crate::camera::Camera;
use crate::error::RenderError;
use crate::gpu::Gpu;
use crate::image::Image;
use crate::renderer::{Mesh, Renderer, Scene, allows_picture, texture};
use crate::skinned::SkinnedMesh;

/// Samples per pixel.
pub(crate) const SAMPLES: u32 = 4;

/// Colours are blended as sRGB numbers: as light, translucent dark blue over white would be grey.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// A device without a window, and a renderer on it.
#[derive(Debug)]
pub struct Studio {
    /// The device.
    pub gpu: Gpu,
    renderer: Renderer,
}

impl Studio {
    /// On the fastest adapter there is, a program that draws on the processor included.
    ///
    /// # Errors
    /// No adapter, or one that cannot be used.
    pub fn open() -> Result<Self, RenderError> {
        let gpu = Gpu::offscreen()?;
        let renderer = Renderer::new(&gpu.device, FORMAT, SAMPLES);
        gpu.check()?;
        Ok(Self { gpu, renderer })
    }

    /// A mesh for this studio's pictures: see [`Mesh`].
    ///
    /// # Errors
    /// More than the device takes.
    pub fn mesh(&self, rest: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Mesh, RenderError> {
        let mesh = self.renderer.mesh(&self.gpu.device, rest, triangles)?;
        self.gpu.check()?;
        Ok(mesh)
    }

    /// An asset that is deformed on the device.
    ///
    /// # Errors
    /// More than the device takes, a corrupt asset.
    pub fn skinned(&self, asset: &Asset<'_>) -> Result<SkinnedMesh, RenderError> {
        SkinnedMesh::new(&self.gpu, &self.renderer, asset)
    }

    /// The picture of a scene, `size` pixels wide and high. The same device makes the same picture of
    /// the same scene, to the last bit.
    ///
    /// # Errors
    /// More than the device takes; a lost device.
    pub fn picture(
        &mut self,
        size: [u32; 2],
        camera: &Camera,
        scene: &Scene<'_>,
    ) -> Result<Image, RenderError> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        allows_picture(device, size)?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = texture(device, "picture", size, 1, FORMAT, usage);
        let mut encoder = device.create_command_encoder(&Default::default());
        let view = texture.create_view(&Default::default());
        self.renderer
            .draw(device, queue, &mut encoder, &view, size, camera, scene)?;
        queue.submit([encoder.finish()]);
        self.gpu.read_back(&texture)
    }
}
