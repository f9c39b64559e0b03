//! Deformed positions and normals on the device.

use bdtree_runtime::AssetId;
use zerocopy::IntoBytes;

use crate::asset::Normals;
use crate::device::{checked, largest_binding, wait};
use crate::error::GpuError;

/// Positions and normals of all instances: packed `f32` triples, instance by instance, N of each. The
/// buffers serve as vertex buffers (`Float32x3`, stride 12), in shaders, and as sources of copies.
#[derive(Debug)]
pub struct Output {
    pub(crate) asset: AssetId,
    pub(crate) kind: Normals,
    pub(crate) capacity: u32,
    pub(crate) positions: wgpu::Buffer,
    pub(crate) normals: Option<wgpu::Buffer>,
    /// Group 2 of the passes for positions, and with normals of those from fields and of exact ones.
    pub(crate) groups: Vec<wgpu::BindGroup>,
}

impl Output {
    /// World positions less the origin of the instances.
    pub fn positions(&self) -> &wgpu::Buffer {
        &self.positions
    }

    /// Unit normals in world axes, in the direction that the triangles' order gives; zero where a
    /// vertex has no triangle with an area.
    pub fn normals(&self) -> Option<&wgpu::Buffer> {
        self.normals.as_ref()
    }

    /// Number of instances that there is room for.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }
}

/// Bytes of a buffer of `instances` times `vertices` triples.
///
/// # Errors
/// More than the device binds.
pub(crate) fn bytes(device: &wgpu::Device, vertices: u32, instances: u32) -> Result<u64, GpuError> {
    let one = 12 * u64::from(vertices);
    let bytes = one * u64::from(instances);
    // Shaders count the numbers in u32.
    let limit = largest_binding(device);
    if bytes > limit {
        return Err(GpuError::TooManyInstances {
            instances: u64::from(instances),
            fit: limit / one.max(1),
            bytes,
            limit,
        });
    }
    Ok(bytes)
}

/// The first `count` triples of a buffer, waited for. For tests and tools: an engine leaves them on
/// the device.
///
/// # Errors
/// A lost device; what the device refuses.
pub fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    count: usize,
) -> Result<Vec<[f32; 3]>, GpuError> {
    let mut points = vec![[0.0_f32; 3]; count];
    let bytes = points.as_mut_bytes();
    if bytes.is_empty() {
        return Ok(points);
    }
    checked(device, || {
        let size = bytes.len() as u64;
        let copy = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, size);
        queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        wait(device)?;
        // Not mapped: the device was lost on the way.
        let view = copy.slice(..).get_mapped_range();
        bytes.copy_from_slice(&view.map_err(|_| GpuError::DeviceLost)?);
        Ok(())
    })?;
    Ok(points)
}
