//! Textures as pictures in memory.

use std::sync::mpsc;

use wgpu::{
    BufferDescriptor, BufferUsages, MapMode, TexelCopyBufferInfo, TexelCopyBufferLayout, Texture,
    TextureFormat,
};

use crate::error::RenderError;
use crate::gpu::Gpu;
use crate::image::Image;
use crate::renderer::extent;

impl Gpu {
    /// What a texture of 8-bit RGBA or BGRA holds, after all work that has been submitted. It has to
    /// be one that can be copied from (`COPY_SRC`).
    ///
    /// # Errors
    /// Another format; more than the device takes; a lost device.
    pub fn read_back(&self, texture: &Texture) -> Result<Image, RenderError> {
        let lost = |error: String| RenderError::Device(error);
        let swaps_red_and_blue = match texture.format() {
            TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => false,
            TextureFormat::Bgra8Unorm | TextureFormat::Bgra8UnormSrgb => true,
            other => return Err(lost(format!("pictures of format {other:?} are not read"))),
        };
        let size = [texture.width(), texture.height()];
        let row_bytes = (4 * size[0]).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(row_bytes) * u64::from(size[1]);
        Self::allows_buffer(&self.device, "picture", bytes)?;
        let copy = self.device.create_buffer(&BufferDescriptor {
            label: Some("picture"),
            size: bytes,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            TexelCopyBufferInfo {
                buffer: &copy,
                layout: TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row_bytes),
                    rows_per_image: None,
                },
            },
            extent(size),
        );
        self.queue.submit([encoder.finish()]);
        let (done, mapped) = mpsc::channel();
        copy.map_async(MapMode::Read, .., move |result| {
            let _ = done.send(result);
        });
        self.finish()?;
        match mapped.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(lost(error.to_string())),
            Err(_) => return Err(lost("the picture did not come back".to_string())),
        }
        let view = copy
            .get_mapped_range(..)
            .map_err(|error| lost(error.to_string()))?;
        let mut image = Image::new(size);
        let rows = view.chunks_exact(row_bytes as usize);
        for (row, out) in rows.zip(image.rows_mut()) {
            out.copy_from_slice(&row[..out.len()]);
            if swaps_red_and_blue {
                for pixel in out.as_chunks_mut::<4>().0 {
                    pixel.swap(0, 2);
                }
            }
        }
        Ok(image)
    }
}
