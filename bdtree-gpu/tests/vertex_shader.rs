//! Skinning inside a vertex shader: drawn as points into a picture of floats, the same as compute passes
//! give.

use bdtree_gpu::{
    GpuError, Instances, NormalFields, Normals, Skinner, read_back, twin, vertex_layout,
    vertex_source,
};
use bdtree_runtime::Asset;

use crate::devices::{Gpu, assets, placed};

/// Behind the text of `vertex_source`: vertex v of instance k becomes pixel (v, 2 k) with its position
/// and pixel (v, 2 k + 1) with its normal.
const SHADER: &str = "
struct Drawn { @builtin(position) at: vec4<f32>, @location(0) @interpolate(flat) value: vec4<f32> }

@vertex
fn vertex(@builtin(vertex_index) v: u32, @builtin(instance_index) i: u32) -> Drawn {
    let size = vec2<f32>(WIDTH, HEIGHT);
    let drawn = bdtree_vertex(v, i / 2u);
    let pixel = (vec2(f32(v), f32(i)) + 0.5) / size;
    let at = vec4(2.0 * pixel.x - 1.0, 1.0 - 2.0 * pixel.y, 0.0, 1.0);
    return Drawn(at, vec4(select(drawn.position, drawn.normal, i % 2u == 1u), 1.0));
}

@fragment
fn fragment(drawn: Drawn) -> @location(0) vec4<f32> { return drawn.value; }
";

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Draws and returns rows of `width` pixels.
fn draw(
    gpu: &Gpu,
    source: &str,
    layout: &wgpu::BindGroupLayout,
    group: &wgpu::BindGroup,
    [width, height]: [u32; 2],
    vertices: u32,
) -> Vec<[f32; 4]> {
    let device = &gpu.device;
    let text = format!("{source}{SHADER}")
        .replace("WIDTH", &format!("{width}.0"))
        .replace("HEIGHT", &format!("{height}.0"));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    // Bind group 1: the engine's own is 0.
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[None, Some(layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::PointList,
            ..Default::default()
        },
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let row = 16 * width; // a multiple of 256: width is one of 16
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let view = texture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(1, group, &[]);
        pass.draw(0..vertices, 0..height);
    }
    let copy = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout: wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        },
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, size);
    gpu.queue.submit([encoder.finish()]);
    let flat = (width * height * 4).div_ceil(3) as usize;
    assert_eq!(
        flat * 3,
        (width * height * 4) as usize,
        "read back in triples"
    );
    let read = read_back(device, &gpu.queue, &buffer, flat).expect("read");
    read.as_flattened().as_chunks().0.to_vec()
}

/// Draws so many instances, added by `push`, and compares positions with their twin's; `check` is told instance,
/// vertex, the normal drawn, and the twin's (zeros without normals). Returns how many vertices were compared.
pub(crate) fn drawn_as_twin(
    gpu: &Gpu,
    (name, asset): (&str, &Asset<'_>),
    normals: Normals,
    (count, origin): (usize, [f64; 3]),
    mut push: impl FnMut(&mut Instances, usize) -> Result<f64, GpuError>,
    mut check: impl FnMut(usize, usize, [f32; 3], [f32; 3]),
) -> usize {
    let n = asset.vertex_count();
    let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
    let layout = vertex_layout(&gpu.device);
    let fields = (normals == Normals::Fields).then(|| NormalFields::new(asset).expect("fields"));
    let uploaded = skinner.upload(asset, normals).expect("upload");
    let instances = skinner.instances(&uploaded, count as u32);
    let mut instances = instances.expect("instances");
    instances.clear(origin);
    let errors = (0..count).map(|k| push(&mut instances, k).expect("push"));
    let errors: Vec<f64> = errors.collect();
    instances.write();
    let group = skinner.vertex_group(&layout, &uploaded, &instances);
    let group = group.expect("group");
    let source = vertex_source(&uploaded, 1).expect("source");
    let width = n.next_multiple_of(48);
    let size = [width as u32, 2 * count as u32];
    let pixels = draw(gpu, &source, &layout, &group, size, n as u32);
    for (k, error) in errors.iter().enumerate() {
        let twin = twin::positions(asset, &instances, k as u32).expect("twin");
        // From fields alone, at marked vertices too.
        let normals = match &fields {
            Some(fields) => twin::field_normals(asset, fields, &instances, k as u32),
            None => Ok(vec![[0.0; 3]; n]),
        };
        let normals = normals.expect("twin");
        for v in 0..n {
            let row = |i: usize| pixels[(2 * k + i) * width + v];
            let [position, [x, y, z, _]] = [row(0), row(1)];
            assert_eq!(position[3], 1.0, "{name}: vertex {v} was not drawn");
            for axis in 0..3 {
                let off = f64::from(position[axis]) - f64::from(twin[v][axis]);
                assert!(off.abs() <= 2.0 * error, "{name} {k} {v}: {off}");
            }
            check(k, v, [x, y, z], normals[v]);
        }
    }
    count * n
}

#[test]
fn a_vertex_shader_computes_the_same() {
    let gpu = Gpu::new();
    let mut compared = 0;
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        let placed = placed(asset, seed);
        let all = (12.min(placed.len()), [0.5, 0.0, -1.0]);
        for normals in [Normals::None, Normals::Fields] {
            compared += drawn_as_twin(
                &gpu,
                (&name, asset),
                normals,
                all,
                |instances, k| {
                    let (q, place) = &placed[k];
                    instances.push_at(asset, q, *place)
                },
                |k, v, found, expected| {
                    for axis in 0..3 {
                        let off = (found[axis] - expected[axis]).abs();
                        assert!(off <= 1e-4, "{name} {k} {v}: {found:?} {expected:?}");
                    }
                },
            );
        }
        let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
        let exact = skinner.upload(asset, Normals::Exact).expect("upload");
        let refused = vertex_source(&exact, 0);
        assert!(
            matches!(refused, Err(GpuError::Unsupported(_))),
            "{refused:?}"
        );
    }
    assert!(compared > 50_000, "{compared}");
}
