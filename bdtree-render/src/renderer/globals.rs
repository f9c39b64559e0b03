//! What all shaders share: the camera and the light.

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, Buffer, BufferDescriptor,
    BufferUsages, Device, Queue,
};
use zerocopy::{Immutable, IntoBytes};

use super::pipelines::uniform_layout;
use crate::camera::{Camera, add, dot, length, scale};

/// The shader's `Globals`.
#[derive(IntoBytes, Immutable)]
#[repr(C)]
struct Record {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 4],
    forward: [f32; 4],
    light: [f32; 4],
    up: [f32; 4],
}

#[derive(Debug)]
pub(super) struct Globals {
    buffer: Buffer,
    layout: BindGroupLayout,
    group: BindGroup,
}

impl Globals {
    pub(super) fn new(device: &Device) -> Self {
        let buffer = device.create_buffer(&BufferDescriptor {
            label: Some("camera"),
            size: size_of::<Record>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layout = uniform_layout(device, "camera");
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("camera"),
            layout: &layout,
            entries: &[BindGroupEntry {
                binding: 0,
                resource: buffer.as_entire_binding(),
            }],
        });
        Self {
            buffer,
            layout,
            group,
        }
    }

    pub(super) fn layout(&self) -> &BindGroupLayout {
        &self.layout
    }

    pub(super) fn group(&self) -> &BindGroup {
        &self.group
    }

    /// `encode`: the target takes colours as they are, so the shader makes them sRGB.
    pub(super) fn write(&self, queue: &Queue, camera: &Camera, size: [u32; 2], encode: bool) {
        let [right, up, forward] = camera.axes();
        let near = camera.near();
        let slope = (0.5 * camera.fov_y_rad).tan();
        let aspect = size[0].max(1) as f32 / size[1].max(1) as f32;
        // Rows of view and projection together: x / slope, y / slope, near and depth.
        let row = |axis: [f32; 3], by: f32| {
            let [x, y, z] = scale(axis, by);
            [x, y, z, -by * dot(axis, camera.eye)]
        };
        let rows = [
            row(right, 1.0 / (slope * aspect)),
            row(up, 1.0 / slope),
            [0.0, 0.0, 0.0, near],
            row(forward, 1.0),
        ];
        let columns = [0, 1, 2, 3].map(|k| [rows[0][k], rows[1][k], rows[2][k], rows[3][k]]);
        // From above, left and before.
        let light = add(
            add(scale(right, -0.45), scale(up, 0.75)),
            scale(forward, -0.6),
        );
        let light = scale(light, 1.0 / length(light));
        let with = |[x, y, z]: [f32; 3], w: f32| [x, y, z, w];
        let record = Record {
            view_projection: columns,
            eye: with(camera.eye, near),
            forward: with(forward, f32::from(u8::from(encode))),
            light: with(light, 0.0),
            up: with(up, 0.0),
        };
        queue.write_buffer(&self.buffer, 0, record.as_bytes());
    }
}
