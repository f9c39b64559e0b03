//! A mesh in memory of the device.

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferDescriptor, BufferUsages, Device, IndexFormat, Queue,
    RenderPass, RenderPipeline,
};
use zerocopy::IntoBytes;

use super::pipelines::uniform;
use crate::error::RenderError;
use crate::gpu::Gpu;
use crate::shading;

/// Vertices, normals and triangles of a mesh, and its colour.
///
/// Positions and normals are packed, three f32 each: written by the caller ([`Mesh::write`]), or by the
/// runtime's skinning on the device ([`Renderer::mesh_of_buffers`](crate::Renderer::mesh_of_buffers)).
#[derive(Debug)]
pub struct Mesh {
    positions: Buffer,
    normals: Buffer,
    smoothness: Buffer,
    indices: Buffer,
    index_count: u32,
    look: Buffer,
    group: BindGroup,
    colour: [u8; 3],
}

/// Light, a little warm.
const COLOUR: [u8; 3] = [214, 209, 200];

impl Mesh {
    pub(super) fn new(
        device: &Device,
        layout: &BindGroupLayout,
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, RenderError> {
        let bytes = 12 * rest.len() as u64;
        let positions = buffer(device, "positions of vertices", bytes)?;
        let normals = buffer(device, "normals of vertices", bytes)?;
        let corners = triangles.as_bytes();
        let indices = filled(device, "corners of triangles", corners, BufferUsages::INDEX)?;
        let smoothness = shading::smoothness(rest, triangles);
        let buffers = [&positions, &normals, &indices];
        Self::of_buffers(device, layout, buffers, &smoothness, triangles.len() as u32)
    }

    /// A mesh whose positions, normals (three f32 per vertex, packed) and corners (u32) are kept by others,
    /// and how smooth it is at its vertices.
    pub(super) fn of_buffers(
        device: &Device,
        layout: &BindGroupLayout,
        [positions, normals, indices]: [&Buffer; 3],
        smoothness: &[f32],
        triangle_count: u32,
    ) -> Result<Self, RenderError> {
        let what = "smoothness of vertices";
        let smoothness = filled(device, what, smoothness.as_bytes(), BufferUsages::VERTEX)?;
        let (look, group) = uniform(device, layout, "colour", 16);
        Ok(Self {
            positions: positions.clone(),
            normals: normals.clone(),
            smoothness,
            indices: indices.clone(),
            index_count: 3 * triangle_count,
            look,
            group,
            colour: COLOUR,
        })
    }

    /// Gives it a colour: red, green, blue.
    pub fn set_colour(&mut self, colour: [u8; 3]) {
        self.colour = colour;
    }

    /// Puts in positions and unit normals, as many of each as the mesh has vertices or fewer.
    pub fn write(&self, queue: &Queue, positions: &[[f32; 3]], normals: &[[f32; 3]]) {
        for (buffer, values) in [(&self.positions, positions), (&self.normals, normals)] {
            let room = (buffer.size() / 12) as usize;
            let values = &values[..values.len().min(room)];
            if !values.is_empty() {
                queue.write_buffer(buffer, 0, values.as_bytes());
            }
        }
    }

    pub(super) fn draw_shadow(&self, pass: &mut RenderPass<'_>, pipeline: &RenderPipeline) {
        if self.index_count > 0 {
            pass.set_pipeline(pipeline);
            pass.set_vertex_buffer(0, self.positions.slice(..));
            pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
            pass.draw_indexed(0..self.index_count, 0, 0..1);
        }
    }

    pub(super) fn draw(&self, queue: &Queue, pass: &mut RenderPass<'_>, pipeline: &RenderPipeline) {
        if self.index_count == 0 {
            return;
        }
        let [r, g, b] = self.colour.map(|c| f32::from(c) / 255.0);
        queue.write_buffer(&self.look, 0, [r, g, b, 1.0].as_bytes());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_vertex_buffer(1, self.normals.slice(..));
        pass.set_vertex_buffer(2, self.smoothness.slice(..));
        pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
        pass.draw_indexed(0..self.index_count, 0, 0..1);
    }
}

/// A vertex buffer that is written later.
fn buffer(device: &Device, what: &'static str, bytes: u64) -> Result<Buffer, RenderError> {
    Gpu::allows_buffer(device, what, bytes)?;
    Ok(device.create_buffer(&BufferDescriptor {
        label: Some(what),
        size: bytes.max(12),
        usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    }))
}

/// A buffer with content (a multiple of four bytes). Too little memory for it is an error of the device.
pub(crate) fn filled(
    device: &Device,
    what: &'static str,
    content: &[u8],
    usage: BufferUsages,
) -> Result<Buffer, RenderError> {
    Gpu::allows_buffer(device, what, content.len() as u64)?;
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some(what),
        size: content.len().max(4) as u64,
        usage,
        mapped_at_creation: true,
    });
    if !content.is_empty()
        && let Ok(mut view) = buffer.get_mapped_range_mut(..)
    {
        view.copy_from_slice(content);
    }
    buffer.unmap();
    Ok(buffer)
}
