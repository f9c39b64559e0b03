//! Pipelines for many deformed bodies and the floor below them.

use std::ops::Range;

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, Buffer, BufferBindingType,
    BufferDescriptor, BufferUsages, Device, Extent3d, FilterMode, IndexFormat, PrimitiveTopology,
    Queue, RenderPass, RenderPipeline, SamplerBindingType, SamplerDescriptor, ShaderStages,
    TexelCopyBufferLayout, Texture, TextureDescriptor, TextureDimension, TextureFormat,
    TextureSampleType, TextureUsages, TextureViewDimension, VertexBufferLayout, VertexStepMode,
    vertex_attr_array,
};
use zerocopy::{Immutable, IntoBytes};

use super::Renderer;
use super::pipelines::{Kind, shader};

/// A level floor that fades into the background; y is up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// Its height.
    pub height: f32,
    /// Its middle, x and z.
    pub middle: [f32; 2],
    /// How far from the middle it begins to fade; at three times that it is gone.
    pub radius: f32,
    /// Red, green, blue.
    pub colour: [u8; 3],
}

/// How much of the sky is seen from the points of a grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Light {
    /// The lowest corner of the grid's box.
    pub(crate) low: [f32; 3],
    /// Sizes of the box.
    pub(crate) sizes: [f32; 3],
    /// 255 is all of it, x first, then y, then z: values of cells.
    pub(crate) open: Vec<u8>,
}

impl Light {
    /// Cells along x, y and z.
    pub(crate) const CELLS: [usize; 3] = [64, 32, 64];
}

/// The shader's `Light`.
#[derive(IntoBytes, Immutable)]
#[repr(C)]
struct Record {
    low: [f32; 4],
    per_size: [f32; 4],
    floor: [f32; 4],
    middle: [f32; 4],
    background: [f32; 4],
}

/// Pipelines for bodies and a floor, beside those of a [`Renderer`].
#[derive(Debug)]
pub(crate) struct BodyPasses {
    body: RenderPipeline,
    floor: RenderPipeline,
    record: Buffer,
    sky: Texture,
    group: BindGroup,
}

/// What is drawn of bodies of one asset: buffers of three f32 per vertex, body behind body, and of
/// four bytes per body.
pub(crate) struct BodyBuffers<'b> {
    pub(crate) positions: &'b Buffer,
    pub(crate) normals: &'b Buffer,
    pub(crate) smoothness: &'b Buffer,
    pub(crate) indices: &'b Buffer,
    pub(crate) colours: &'b Buffer,
    pub(crate) vertex_count: u32,
    /// Of each body which of the indices are drawn.
    pub(crate) corners: &'b [Range<u32>],
}

impl BodyPasses {
    pub(crate) fn new(device: &Device, renderer: &Renderer) -> Self {
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: stages,
            ty,
            count: None,
        };
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("light"),
            entries: &[
                entry(
                    0,
                    BindingType::Buffer {
                        ty: BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                ),
                entry(
                    1,
                    BindingType::Texture {
                        sample_type: TextureSampleType::Float { filterable: true },
                        view_dimension: TextureViewDimension::D3,
                        multisampled: false,
                    },
                ),
                entry(2, BindingType::Sampler(SamplerBindingType::Filtering)),
            ],
        });
        let shader = shader(device, "bodies", include_str!("bodies.wgsl"));
        let buffer = |array_stride, step_mode, attributes| {
            Some(VertexBufferLayout {
                array_stride,
                step_mode,
                attributes,
            })
        };
        let vertex = VertexStepMode::Vertex;
        let position = vertex_attr_array![0 => Float32x3];
        let normal = vertex_attr_array![1 => Float32x3];
        let smoothness = vertex_attr_array![2 => Float32];
        let colour = vertex_attr_array![3 => Unorm8x4];
        let buffers = [
            buffer(12, vertex, &position),
            buffer(12, vertex, &normal),
            buffer(4, vertex, &smoothness),
            buffer(4, VertexStepMode::Instance, &colour),
        ];
        let layouts = [Some(&renderer.globals.layout), Some(&layout)];
        let make = |label, buffers: &[_], topology| {
            let kind = Kind {
                label,
                layouts: &layouts,
                buffers,
                topology,
                is_opaque: true,
            };
            kind.pipeline(device, &shader, renderer.format, renderer.samples)
        };
        let record = device.create_buffer(&BufferDescriptor {
            label: Some("light"),
            size: size_of::<Record>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sky = device.create_texture(&TextureDescriptor {
            label: Some("open sky"),
            size: cells(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D3,
            format: TextureFormat::R8Unorm,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let sampler = device.create_sampler(&SamplerDescriptor {
            label: Some("open sky"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..SamplerDescriptor::default()
        });
        let view = sky.create_view(&Default::default());
        let resources = [
            record.as_entire_binding(),
            BindingResource::TextureView(&view),
            BindingResource::Sampler(&sampler),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| BindGroupEntry { binding, resource })
            .collect();
        Self {
            body: make("body", &buffers, PrimitiveTopology::TriangleList),
            floor: make("floor", &[], PrimitiveTopology::TriangleStrip),
            group: device.create_bind_group(&BindGroupDescriptor {
                label: Some("light"),
                layout: &layout,
                entries: &entries,
            }),
            record,
            sky,
        }
    }

    /// Bytes of its texture.
    pub(crate) fn bytes(&self) -> u64 {
        Light::CELLS.map(|n| n as u64).iter().product()
    }

    /// Writes what all passes of a picture read.
    pub(crate) fn write(
        &self,
        queue: &Queue,
        light: &Light,
        floor: Option<Floor>,
        background: [u8; 4],
    ) {
        let shares = |colour: [u8; 3]| colour.map(|c| f32::from(c) / 255.0);
        let four = |[x, y, z]: [f32; 3], w| [x, y, z, w];
        let [r, g, b, _] = background;
        let record = Record {
            low: four(light.low, 0.0),
            per_size: four(light.sizes.map(|size| 1.0 / size), 0.0),
            floor: floor.map_or([0.0; 4], |f| four(shares(f.colour), f.height)),
            middle: floor.map_or([0.0; 4], |f| {
                [
                    f.middle[0],
                    f.middle[1],
                    f.radius.max(f32::MIN_POSITIVE),
                    0.0,
                ]
            }),
            background: four(shares([r, g, b]), 1.0),
        };
        queue.write_buffer(&self.record, 0, record.as_bytes());
        let [x, y, _] = Light::CELLS.map(|n| n as u32);
        queue.write_texture(
            self.sky.as_image_copy(),
            &light.open,
            TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(x),
                rows_per_image: Some(y),
            },
            cells(),
        );
    }

    pub(crate) fn draw_bodies(&self, pass: &mut RenderPass<'_>, bodies: &BodyBuffers<'_>) {
        pass.set_pipeline(&self.body);
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_vertex_buffer(2, bodies.smoothness.slice(..));
        pass.set_vertex_buffer(3, bodies.colours.slice(..));
        pass.set_index_buffer(bodies.indices.slice(..), IndexFormat::Uint32);
        let stride = 12 * u64::from(bodies.vertex_count);
        for (k, corners) in (0..).zip(bodies.corners) {
            // Not by a base vertex, which would move on in the smoothness, too.
            let own = u64::from(k) * stride..u64::from(k + 1) * stride;
            pass.set_vertex_buffer(0, bodies.positions.slice(own.clone()));
            pass.set_vertex_buffer(1, bodies.normals.slice(own));
            pass.draw_indexed(corners.clone(), 0, k..k + 1);
        }
    }

    pub(crate) fn draw_floor(&self, pass: &mut RenderPass<'_>) {
        pass.set_pipeline(&self.floor);
        pass.set_bind_group(1, &self.group, &[]);
        pass.draw(0..4, 0..1);
    }
}

fn cells() -> Extent3d {
    let [width, height, depth_or_array_layers] = Light::CELLS.map(|n| n as u32);
    Extent3d {
        width,
        height,
        depth_or_array_layers,
    }
}
