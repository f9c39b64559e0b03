//! The layouts of bind groups.

/// The bind group layouts of all compute passes.
#[derive(Debug)]
pub(crate) struct Layouts {
    /// Group 0: what is stored of a range of vertices.
    pub(crate) fields: wgpu::BindGroupLayout,
    /// Group 1: instances.
    pub(crate) instances: wgpu::BindGroupLayout,
    /// Group 2: points or normals from fields, written.
    pub(crate) output: wgpu::BindGroupLayout,
    /// Group 2 of exact normals: points, read, and normals, written.
    pub(crate) exact_output: wgpu::BindGroupLayout,
}

/// How a shader sees a buffer.
#[derive(Clone, Copy)]
pub(crate) enum Access {
    Uniform,
    Read,
    Write,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        use Access::{Read, Uniform, Write};
        let compute = wgpu::ShaderStages::COMPUTE;
        Self {
            fields: layout(device, compute, &[Uniform, Read, Read, Read]),
            instances: layout(device, compute, &[Read]),
            output: layout(device, compute, &[Write]),
            exact_output: layout(device, compute, &[Read, Write]),
        }
    }
}

/// A layout of buffers at bindings 0, 1, 2, ….
pub(crate) fn layout(
    device: &wgpu::Device,
    visibility: wgpu::ShaderStages,
    accesses: &[Access],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, access): (u32, &Access)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: match access {
                Access::Uniform => wgpu::BufferBindingType::Uniform,
                Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
                Access::Write => wgpu::BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(accesses).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("bdtree"),
        entries: &entries,
    })
}
