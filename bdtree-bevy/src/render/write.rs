//! The pass that writes deformed vertices to Bevy's vertex buffers.

use bdtree_gpu::Output;
use wgpu::util::DeviceExt;

/// Where the vertices of some meshes of one layout lie in a buffer.
pub(crate) struct Target<'b> {
    pub(crate) buffer: &'b wgpu::Buffer,
    /// The part of the buffer to bind (bytes).
    pub(crate) start: u64,
    pub(crate) len: u64,
    pub(crate) layout: VertexLayout,
    /// Of each instance, from `first_instance` of the output on, the first word within that part.
    pub(crate) places: Vec<u32>,
    pub(crate) first_instance: u32,
    /// Of each instance.
    pub(crate) vertex_count: u32,
    /// The words of the meshes' `Tangents`; not there unless the layout has a place for them.
    pub(crate) tangents: Option<&'b wgpu::Buffer>,
}

/// Where a vertex has what is written (words).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct VertexLayout {
    pub(crate) stride: u32,
    pub(crate) position: u32,
    pub(crate) normal: u32,
    /// Where tangents are to be written.
    pub(crate) tangent: Option<u32>,
}

/// The pass, made once per device.
pub(crate) struct Writer {
    device: wgpu::Device,
    pipeline: wgpu::ComputePipeline,
}

impl Writer {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("write.wgsl"));
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("bdtree vertices"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self {
            device: device.clone(),
            pipeline,
        }
    }

    /// Records the copy of instances of the output to their places.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        output: &Output,
        target: &Target<'_>,
    ) {
        let Some(normals) = output.normals() else {
            return;
        };
        let threads = u64::from(target.vertex_count) * target.places.len() as u64;
        let groups = threads.div_ceil(64);
        if groups == 0 {
            return;
        }
        let layout = target.layout;
        // A binding needs a buffer, read or not.
        let (tangent, around) = match (layout.tangent, target.tangents) {
            (Some(tangent), Some(around)) => (tangent, around),
            _ => (u32::MAX, output.positions()),
        };
        let mut job = vec![
            target.vertex_count,
            target.places.len() as u32,
            layout.stride,
            layout.position,
            layout.normal,
            tangent,
            target.first_instance,
        ];
        job.extend(&target.places);
        let bytes: Vec<u8> = job.iter().flat_map(|word| word.to_le_bytes()).collect();
        let job = self
            .device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("bdtree places"),
                contents: &bytes,
                usage: wgpu::BufferUsages::STORAGE,
            });
        let vertices = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: target.buffer,
            offset: target.start,
            size: std::num::NonZeroU64::new(target.len),
        });
        let resources = [
            job.as_entire_binding(),
            output.positions().as_entire_binding(),
            normals.as_entire_binding(),
            vertices,
            around.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("bdtree vertices"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("bdtree vertices"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let most = u64::from(
            self.device
                .limits()
                .max_compute_workgroups_per_dimension
                .max(1),
        );
        let y = groups.div_ceil(most);
        pass.dispatch_workgroups(groups.div_ceil(y) as u32, y as u32, 1);
    }
}
