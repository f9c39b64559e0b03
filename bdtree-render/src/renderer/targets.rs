//! Textures that drawing needs beside its target: depth, and samples.

use wgpu::{
    Device, Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
    TextureView,
};

use super::pipelines::DEPTH_FORMAT;
use crate::error::RenderError;

#[derive(Debug)]
pub(super) struct Targets {
    pub(super) size: [u32; 2],
    pub(super) depth: TextureView,
    /// Where there are several samples per pixel.
    pub(super) samples: Option<TextureView>,
}

impl Targets {
    pub(super) fn new(
        device: &Device,
        format: TextureFormat,
        samples: u32,
        size: [u32; 2],
    ) -> Result<Self, RenderError> {
        allows_picture(device, size)?;
        let texture = |label, format| {
            let usage = TextureUsages::RENDER_ATTACHMENT;
            let texture = texture(device, label, size, samples, format, usage);
            texture.create_view(&Default::default())
        };
        Ok(Self {
            size,
            depth: texture("depth", DEPTH_FORMAT),
            samples: (samples > 1).then(|| texture("samples", format)),
        })
    }
}

/// A texture of `size` pixels.
pub fn texture(
    device: &Device,
    label: &str,
    size: [u32; 2],
    sample_count: u32,
    format: TextureFormat,
    usage: TextureUsages,
) -> Texture {
    device.create_texture(&TextureDescriptor {
        label: Some(label),
        size: extent(size),
        mip_level_count: 1,
        sample_count,
        dimension: TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

pub(crate) fn extent([width, height]: [u32; 2]) -> Extent3d {
    Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}

/// Checks that a picture may have so many pixels.
pub(crate) fn allows_picture(device: &Device, size: [u32; 2]) -> Result<(), RenderError> {
    let limit = u64::from(device.limits().max_texture_dimension_2d);
    for (what, n) in [
        ("width of the picture", size[0]),
        ("height of the picture", size[1]),
    ] {
        let needed = u64::from(n);
        if needed > limit || needed == 0 {
            return Err(RenderError::TooLarge {
                what,
                needed,
                limit,
                unit: "pixels",
            });
        }
    }
    Ok(())
}
