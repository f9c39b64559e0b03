//! Where the window's pixels go.

use std::sync::Arc;

use bdtree_render::{Gpu, RenderError};
use wgpu::{
    CurrentSurfaceTexture, PresentMode, Surface, SurfaceConfiguration, SurfaceTexture,
    TextureUsages,
};
use winit::window::Window;

use crate::picture::allows;

/// Times in a row that a surface may be made anew before we give up.
const TRIES: u32 = 4;

/// The surface of a window.
pub(crate) struct Screen {
    window: Arc<Window>,
    surface: Surface<'static>,
    configuration: SurfaceConfiguration,
    failures: u32,
}

impl Screen {
    /// Gets a surface ready; `is_read`: what is drawn will be copied from it.
    ///
    /// # Errors
    /// A device that cannot draw to it or copy from it.
    pub(crate) fn new(
        gpu: &Gpu,
        window: Arc<Window>,
        surface: Surface<'static>,
        is_read: bool,
    ) -> Result<Self, RenderError> {
        let refused = |what: &str| RenderError::Device(format!("the window's surface {what}"));
        let able = surface.get_capabilities(&gpu.adapter);
        let format = egui_wgpu::preferred_framebuffer_format(&able.formats)
            .map_err(|_| refused("takes no format of pixels"))?;
        let size = window.inner_size();
        let configuration = surface.get_default_config(&gpu.adapter, size.width, size.height);
        let mut configuration = configuration.ok_or_else(|| refused("takes no pictures"))?;
        configuration.format = format;
        configuration.present_mode = PresentMode::AutoVsync;
        if is_read {
            if !able.usages.contains(TextureUsages::COPY_SRC) {
                return Err(refused("cannot be copied from: no screenshot"));
            }
            configuration.usage |= TextureUsages::COPY_SRC;
        }
        let mut screen = Self {
            window,
            surface,
            configuration,
            failures: 0,
        };
        screen.resize(gpu, [size.width, size.height])?;
        Ok(screen)
    }

    /// Width and height in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.configuration.width, self.configuration.height]
    }

    /// The pixels' format.
    pub(crate) fn format(&self) -> wgpu::TextureFormat {
        self.configuration.format
    }

    /// Follows the window's size; a window without a size keeps its last one.
    ///
    /// # Errors
    /// More than the device takes.
    pub(crate) fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), RenderError> {
        if size.contains(&0) {
            return Ok(());
        }
        allows(gpu, size)?;
        [self.configuration.width, self.configuration.height] = size;
        self.surface.configure(&gpu.device, &self.configuration);
        gpu.check()
    }

    /// The next picture to draw; `None`: not now. Lost surfaces are made anew.
    ///
    /// # Errors
    /// The surface cannot be had back, a lost device.
    pub(crate) fn next(&mut self, gpu: &Gpu) -> Result<Option<SurfaceTexture>, RenderError> {
        let is_new = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture)
            | CurrentSurfaceTexture::Suboptimal(texture) => {
                self.failures = 0;
                return Ok(Some(texture));
            }
            CurrentSurfaceTexture::Occluded => return Ok(None),
            // A machine with much else to do may be late any number of times; a device that is gone is found here.
            CurrentSurfaceTexture::Timeout => {
                self.window.request_redraw();
                return gpu.check().map(|()| None);
            }
            CurrentSurfaceTexture::Outdated => false,
            CurrentSurfaceTexture::Lost | CurrentSurfaceTexture::Validation => true,
        };
        gpu.check()?;
        self.failures += 1;
        if self.failures > TRIES {
            let text = "the window's surface is lost and cannot be had back";
            return Err(RenderError::Device(text.to_string()));
        }
        if is_new {
            let surface = gpu.instance.create_surface(self.window.clone());
            self.surface = surface.map_err(|error| RenderError::Device(error.to_string()))?;
        }
        let size = self.window.inner_size();
        self.resize(gpu, [size.width, size.height])?;
        self.window.request_redraw();
        Ok(None)
    }
}
