//! Bytes and time of skinning.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::bake::{bumpy_sphere, smooth_basis};
use bdtree_fixtures::bones::random_matrices;
use bdtree_fixtures::{models, poses};
use bdtree_gpu::{GpuError, Instances, NormalFields, Normals, Skinner, request_device};
use bdtree_runtime::{Asset, BoneMatrices, Model};
use bdtree_scenes::contenders::assets::baked_mesh;
use bdtree_scenes::report::{Report, Row, table};
use bdtree_scenes::row;
use clap::Args;

use crate::timer::Timer;

#[derive(Args)]
pub(crate) struct Arguments {
    /// A baked file instead of the chair of fixtures/ with smooth fields
    #[arg(long)]
    asset: Option<PathBuf>,
    /// Number of instances of it
    #[arg(long, default_value_t = 3601)]
    instances: u32,
    /// Rings of the large mesh, a sphere: about twice their square are its vertices
    #[arg(long, default_value_t = 500)]
    rings: u32,
    /// Number of modes
    #[arg(long, default_value_t = 10)]
    modes: usize,
    /// Bytes of the buffer that is copied to find the device's bandwidth (at most a quarter of its largest)
    #[arg(long, default_value_t = 1 << 30)]
    copy_bytes: u64,
    /// Submissions per figure, of which the median counts
    #[arg(long, default_value_t = 15)]
    rounds: usize,
    /// Executions per submission
    #[arg(long, default_value_t = 4)]
    repeats: u32,
}

/// A mesh with smooth modes.
fn smooth(mesh: &RawMesh, modes: usize) -> Result<Model, Box<dyn Error>> {
    baked_mesh(mesh, &smooth_basis(mesh, modes, 1))
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (_, device, queue) = pollster::block_on(request_device(&instance, None))?;
    let (info, limits) = (device.adapter_info(), device.limits());
    let repeats = arguments.repeats.max(1);
    let timer = Timer::new(&device, &queue, arguments.rounds.max(1), repeats);
    let bytes = (arguments.copy_bytes)
        .min(limits.max_buffer_size / 4)
        .min(limits.max_storage_buffer_binding_size)
        & !255;
    let seconds = copy_seconds(&device, &timer, bytes)?;
    let bandwidth = 2.0 * bytes as f64 / seconds;
    let about = row! {
        "device" => format!("{} ({:?}, {} {})", info.name, info.device_type, info.driver, info.driver_info),
        "binding, MB" => limits.max_storage_buffer_binding_size / 1_000_000,
        "buffer, MB" => limits.max_buffer_size / 1_000_000,
        "workgroups per dimension" => u64::from(limits.max_compute_workgroups_per_dimension),
        "measured by" => timer.method(),
        "submissions, of which the median counts" => timer.rounds, "executions in each" => u64::from(repeats),
        "copied, MB" => bytes / 1_000_000, "copy, ms" => 1e3 * seconds,
        "copy, GB/s read and written" => bandwidth / 1e9,
    };
    let skinner = Skinner::new(&device, &queue)?;
    let large = smooth(&bumpy_sphere(arguments.rings.max(3), 1), arguments.modes)?;
    let many = match &arguments.asset {
        Some(path) => Model::read(path)?,
        None => smooth(&read_mesh(&models::path("chair"))?, arguments.modes)?,
    };
    let mut rows = Vec::new();
    for (what, model, count) in [
        ("one large mesh", &large, 1),
        ("many instances", &many, arguments.instances),
    ] {
        for normals in [Normals::None, Normals::Fields, Normals::Exact] {
            let mut row = row! {"asset" => what};
            row.extend(skin(
                (&skinner, &timer),
                model.asset(),
                (normals, count),
                bandwidth,
            )?);
            rows.push(row);
        }
    }
    let tables = vec![
        table("device", "The device", &[about]),
        table("skin", "Skinning", &rows),
    ];
    Report::of_tables("skin", tables).show(None)
}

/// Copies `from` to `to`, a run of 16 bytes per thread and turn.
const COPY: &str = "
@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copied: array<vec4<u32>>;
@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    for (var k = id.x; k < arrayLength(&source); k += 256u * groups.x) {
        copied[k] = source[k];
    }
}";

/// Seconds that the device takes to copy so many bytes by a shader: copies by the queue may take an engine that does not reach
/// the memory's bandwidth (on an H200 a fifth of what shaders do).
fn copy_seconds(
    device: &wgpu::Device,
    timer: &Timer<'_>,
    bytes: u64,
) -> Result<f64, Box<dyn Error>> {
    let [from, to] = [(); 2].map(|()| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copy"),
            size: bytes,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("copy"),
        source: wgpu::ShaderSource::Wgsl(COPY.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("copy"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    let entries = [(0, &from), (1, &to)].map(|(binding, buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("copy"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    timer.seconds(|encoder| {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(16_384, 1, 1);
        Ok(())
    })
}

/// Skins so many instances of an asset, or as many as fit; `copy` is the device's bandwidth in bytes per second.
fn skin(
    (skinner, timer): (&Skinner, &Timer<'_>),
    asset: &Asset<'_>,
    (normals, count): (Normals, u32),
    copy: f64,
) -> Result<Row, Box<dyn Error>> {
    let (n, m) = (asset.vertex_count(), asset.mode_count());
    let start = Instant::now();
    let uploaded = skinner.upload(asset, normals)?;
    let upload = start.elapsed().as_secs_f64();
    let (count, output) = match skinner.output(&uploaded, count) {
        Err(GpuError::TooManyInstances { fit, .. }) if fit > 0 => {
            eprintln!("{count} instances do not fit a binding: {fit} of them");
            (fit as u32, skinner.output(&uploaded, fit as u32)?)
        }
        output => (count, output?),
    };
    let mut instances = skinner.instances(&uploaded, count)?;
    let posing = fill(&mut instances, asset, count)?;
    let seconds =
        timer.seconds(|encoder| Ok(skinner.record(encoder, &uploaded, &instances, &output)?))?;
    let points = 12 * n * count as usize;
    let (name, written) = match normals {
        Normals::Fields => {
            let tangents = NormalFields::new(asset)?.bytes() as usize;
            ("positions, fields", points + tangents)
        }
        Normals::Exact => {
            let corners = 4 * n + 24 * asset.triangle_count();
            ("positions, exact", 2 * points + corners)
        }
        _ => ("positions", 0),
    };
    // Each byte that has to be moved, once, whatever caches do.
    let (starts, influences) = asset.all_influences();
    let fields = size_of_val(asset.positions())
        + size_of_val(asset.displacement_fields())
        + size_of_val(asset.vertex_modes())
        + size_of_val(asset.mode_list_entries());
    let skin = size_of_val(starts) + size_of_val(influences);
    let read = fields + skin + instances.buffer().size() as usize;
    let moved = (points + read + written) as f64;
    Ok(row! {
        "vertices" => n, "triangles" => asset.triangle_count(), "modes" => m,
        "bones" => asset.bone_count(), "what" => name, "instances" => u64::from(count), "ms" => 1e3 * seconds, "MB moved" => moved / 1e6,
        "GB/s" => moved / seconds / 1e9, "of a copy, %" => 100.0 * moved / seconds / copy,
        "G vertices/s" => n as f64 * f64::from(count) / seconds / 1e9,
        "poses, ms" => 1e3 * posing, "upload, ms" => 1e3 * upload,
    })
}

/// Poses all instances at random; returns the seconds that takes, with what is copied.
fn fill(instances: &mut Instances, asset: &Asset<'_>, count: u32) -> Result<f64, Box<dyn Error>> {
    let mut rng = poses::rng(1);
    let placed: Vec<_> = (0..count)
        .map(|_| {
            let q = poses::random_q(asset, 0.1, &mut rng);
            let bones = random_matrices(asset, 1, &mut rng);
            (q, bones, poses::random_transform(10.0, &mut rng))
        })
        .collect();
    let start = Instant::now();
    instances.clear(asset.origin());
    for (q, bones, place) in &placed {
        let bones = match bones.as_slice() {
            [] => BoneMatrices::Rest,
            bones => BoneMatrices::Skinning(bones),
        };
        instances.push_with_bones(asset, q, bones, *place)?;
    }
    instances.write();
    Ok(start.elapsed().as_secs_f64())
}
