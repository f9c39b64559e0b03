//! The pipelines: one each for meshes, their shadows, opaque and translucent spheres, and lines.

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingType, BlendState, Buffer, BufferBindingType, BufferDescriptor,
    BufferUsages, ColorTargetState, ColorWrites, CompareFunction, DepthStencilState, Device,
    FragmentState, MultisampleState, PipelineLayoutDescriptor, PrimitiveState, PrimitiveTopology,
    RenderPipeline, RenderPipelineDescriptor, ShaderModule, ShaderStages, TextureFormat,
    VertexBufferLayout, VertexState, VertexStepMode, vertex_attr_array,
};

/// Reversed depth wants the digits of f32 near 0.
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) mesh: RenderPipeline,
    pub(super) shadow: RenderPipeline,
    pub(super) opaque: RenderPipeline,
    pub(super) translucent: RenderPipeline,
    pub(super) lines: RenderPipeline,
    pub(super) look_layout: BindGroupLayout,
}

impl Pipelines {
    pub(super) fn new(
        device: &Device,
        globals: &BindGroupLayout,
        format: TextureFormat,
        samples: u32,
    ) -> Self {
        let shader = shader(device, "scene", include_str!("draw.wgsl"));
        let look_layout = uniform_layout(device, "colour");
        let packed = vertex_attr_array![0 => Float32x3];
        let packed_too = vertex_attr_array![1 => Float32x3];
        let smoothness = vertex_attr_array![2 => Float32];
        let sphere = vertex_attr_array![0 => Float32x4, 1 => Unorm8x4];
        let line = vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4, 3 => Float32];
        let buffer = |array_stride, step_mode, attributes| {
            Some(VertexBufferLayout {
                array_stride,
                step_mode,
                attributes,
            })
        };
        let vertex = VertexStepMode::Vertex;
        let on_mesh = [
            buffer(12, vertex, &packed),
            buffer(12, vertex, &packed_too),
            buffer(4, vertex, &smoothness),
        ];
        let on_sphere = [buffer(20, VertexStepMode::Instance, &sphere)];
        let on_line = [buffer(32, VertexStepMode::Instance, &line)];
        let make = |kind: Kind<'_>| kind.pipeline(device, &shader, format, samples);
        let alone = [Some(globals)];
        let both = [Some(globals), Some(&look_layout)];
        let mesh = make(Kind {
            label: "mesh",
            layouts: &both,
            buffers: &on_mesh,
            topology: PrimitiveTopology::TriangleList,
            is_opaque: true,
        });
        // It hides nothing: what lies on the ground is drawn over it.
        let shadow = make(Kind {
            label: "shadow",
            layouts: &alone,
            buffers: &on_mesh[..1],
            topology: PrimitiveTopology::TriangleList,
            is_opaque: false,
        });
        let of_spheres = |is_opaque| Kind {
            label: "sphere",
            layouts: &alone,
            buffers: &on_sphere,
            topology: PrimitiveTopology::TriangleStrip,
            is_opaque,
        };
        let opaque = make(of_spheres(true));
        let translucent = make(of_spheres(false));
        let lines = make(Kind {
            label: "line",
            layouts: &alone,
            buffers: &on_line,
            topology: PrimitiveTopology::TriangleStrip,
            is_opaque: false,
        });
        Self {
            mesh,
            shadow,
            opaque,
            translucent,
            lines,
            look_layout,
        }
    }
}

/// Shaders behind what all of them begin with.
pub(super) fn shader(device: &Device, label: &str, own: &str) -> ShaderModule {
    let source = [include_str!("common.wgsl"), own].join("\n");
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

/// What pipelines differ in.
pub(super) struct Kind<'k> {
    /// Before `_vertex` and `_fragment` in the shader.
    pub(super) label: &'static str,
    pub(super) layouts: &'k [Option<&'k BindGroupLayout>],
    pub(super) buffers: &'k [Option<VertexBufferLayout<'k>>],
    pub(super) topology: PrimitiveTopology,
    /// Else it is blended and hides nothing.
    pub(super) is_opaque: bool,
}

impl Kind<'_> {
    pub(super) fn pipeline(
        &self,
        device: &Device,
        shader: &ShaderModule,
        format: TextureFormat,
        samples: u32,
    ) -> RenderPipeline {
        let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: self.layouts,
            immediate_size: 0,
        });
        device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: VertexState {
                module: shader,
                entry_point: Some(&format!("{}_vertex", self.label)),
                compilation_options: Default::default(),
                buffers: self.buffers,
            },
            primitive: PrimitiveState {
                topology: self.topology,
                ..PrimitiveState::default()
            },
            depth_stencil: Some(DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(self.is_opaque),
                depth_compare: Some(CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: MultisampleState {
                count: samples,
                ..MultisampleState::default()
            },
            fragment: Some(FragmentState {
                module: shader,
                entry_point: Some(&format!("{}_fragment", self.label)),
                compilation_options: Default::default(),
                targets: &[Some(ColorTargetState {
                    format,
                    blend: (!self.is_opaque).then_some(BlendState::ALPHA_BLENDING),
                    write_mask: ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// The layout of a group with one uniform buffer.
pub(super) fn uniform_layout(device: &Device, label: &str) -> BindGroupLayout {
    device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &[BindGroupLayoutEntry {
            binding: 0,
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty: BindingType::Buffer {
                ty: BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

/// A uniform buffer of so many bytes and the group that shaders see it in.
pub(super) fn uniform(
    device: &Device,
    layout: &BindGroupLayout,
    label: &str,
    size: u64,
) -> (Buffer, BindGroup) {
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some(label),
        size,
        usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &[BindGroupEntry {
            binding: 0,
            resource: buffer.as_entire_binding(),
        }],
    });
    (buffer, group)
}
