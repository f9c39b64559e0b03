//! What all shaders share: the camera and the light.

use glam::{Mat4, Vec3, Vec4};
use wgpu::{BindGroup, BindGroupLayout, Buffer, Device, Queue};
use zerocopy::{Immutable, IntoBytes};

use super::Ground;
use super::pipelines::{uniform, uniform_layout};
use crate::camera::Camera;

/// The shader's `Globals`.
#[derive(IntoBytes, Immutable)]
#[repr(C)]
struct Record {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 4],
    forward: [f32; 4],
    light: [f32; 4],
    up: [f32; 4],
    size: [f32; 4],
    ground: [f32; 4],
    shadow: [f32; 4],
    shadow_light: [f32; 4],
}

#[derive(Debug)]
pub(super) struct Globals {
    buffer: Buffer,
    pub(super) layout: BindGroupLayout,
    pub(super) group: BindGroup,
}

impl Globals {
    pub(super) fn new(device: &Device) -> Self {
        let layout = uniform_layout(device, "camera");
        let size = size_of::<Record>() as u64;
        let (buffer, group) = uniform(device, &layout, "camera", size);
        Self {
            buffer,
            layout,
            group,
        }
    }

    /// `encode`: the target takes colours as they are, so the shader makes them sRGB.
    pub(super) fn write(
        &self,
        queue: &Queue,
        camera: &Camera,
        size: [u32; 2],
        encode: bool,
        ground: Option<Ground>,
    ) {
        let [right, up, forward] = camera.axes();
        let near = camera.near();
        let slope = (0.5 * camera.fov_y_rad).tan();
        let aspect = size[0].max(1) as f32 / size[1].max(1) as f32;
        // Rows of view and projection together: x / slope, y / slope, near and depth.
        let row = |axis: Vec3, by: f32| (axis * by).extend(-by * axis.dot(camera.eye));
        let rows = Mat4::from_cols(
            row(right, 1.0 / (slope * aspect)),
            row(up, 1.0 / slope),
            Vec4::new(0.0, 0.0, 0.0, near),
            row(forward, 1.0),
        );
        // From above, left and before.
        let light = right * -0.45 + up * 0.75 + forward * -0.6;
        let light = light * (1.0 / light.length());
        let encode = f32::from(u8::from(encode));
        let record = Record {
            view_projection: rows.transpose().to_cols_array_2d(),
            eye: camera.eye.extend(near).to_array(),
            forward: forward.extend(encode).to_array(),
            light: light.extend(0.0).to_array(),
            up: up.extend(0.0).to_array(),
            size: [size[0] as f32, size[1] as f32, 0.0, 0.0],
            ground: ground.map_or([0.0; 4], |g| Vec3::from(g.up).extend(g.height).to_array()),
            shadow: ground.map_or([0.0; 4], |g| {
                let [r, g, b] = g.shadow.map(|c| f32::from(c) / 255.0);
                [r, g, b, 1.0]
            }),
            shadow_light: ground.map_or([0.0; 4], |g| Vec3::from(g.light).extend(0.0).to_array()),
        };
        queue.write_buffer(&self.buffer, 0, record.as_bytes());
    }
}
