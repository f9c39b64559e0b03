//! Bytes and time of skinning.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::bake::{bumpy_sphere, smooth_basis};
use bdtree_fixtures::{models, poses};
use bdtree_gpu::{GpuError, Instances, NormalFields, Normals, Skinner, request_device};
use bdtree_measure::machine;
use bdtree_runtime::{Asset, Model};
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

fn baked(mesh: &RawMesh, modes: usize) -> Result<Model, Box<dyn Error>> {
    let settings = BakeSettings {
        threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
        ..BakeSettings::default()
    };
    let baked = bake_fields(
        mesh,
        &smooth_basis(mesh, modes, 1),
        &settings,
        &Provenance::default(),
        &Silent,
    )?;
    Ok(Model::from_bytes(&baked.bytes)?)
}

struct Bench<'d> {
    device: &'d wgpu::Device,
    skinner: Skinner,
    timer: Timer<'d>,
    rounds: usize,
    repeats: u32,
    /// Bytes per second.
    copy: f64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (_, device, queue) = pollster::block_on(request_device(&instance, None))?;
    let (info, limits) = (device.adapter_info(), device.limits());
    println!(
        "device     {} ({:?}, {} {})",
        info.name, info.device_type, info.driver, info.driver_info
    );
    println!("processor  {}", machine::processor());
    println!(
        "limits     binding {} MB, buffer {} MB, {} workgroups per dimension",
        limits.max_storage_buffer_binding_size / 1_000_000,
        limits.max_buffer_size / 1_000_000,
        limits.max_compute_workgroups_per_dimension
    );
    let mut bench = Bench {
        device: &device,
        skinner: Skinner::new(&device, &queue)?,
        timer: Timer::new(&device, &queue),
        rounds: arguments.rounds.max(1),
        repeats: arguments.repeats.max(1),
        copy: 0.0,
    };
    println!(
        "measured   by {}, median of {} submissions of {}",
        bench.timer.method(),
        bench.rounds,
        bench.repeats
    );
    bench.measure_copy(arguments.copy_bytes.min(limits.max_buffer_size / 4))?;
    let large = baked(&bumpy_sphere(arguments.rings.max(3), 1), arguments.modes)?;
    bench.asset("one large mesh", large.asset(), 1)?;
    let many = match &arguments.asset {
        Some(path) => Model::read(path)?,
        None => baked(&read_mesh(&models::path("chair"))?, arguments.modes)?,
    };
    bench.asset("many instances", many.asset(), arguments.instances)
}

impl Bench<'_> {
    fn measure_copy(&mut self, bytes: u64) -> Result<(), Box<dyn Error>> {
        let bytes = bytes & !255;
        let buffer = || {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("copy"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let (from, to) = (buffer(), buffer());
        let seconds = self.timer.seconds(self.rounds, self.repeats, |encoder| {
            encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
            Ok(())
        })?;
        self.copy = 2.0 * bytes as f64 / seconds;
        println!(
            "copy       {} MB in {:.3} ms: {:.1} GB/s read and written",
            bytes / 1_000_000,
            1e3 * seconds,
            self.copy / 1e9
        );
        Ok(())
    }

    fn asset(&self, what: &str, asset: &Asset<'_>, count: u32) -> Result<(), Box<dyn Error>> {
        let (n, m) = (asset.vertex_count(), asset.mode_count());
        println!(
            "{what}: {n} vertices, {} triangles, {m} modes",
            asset.triangle_count()
        );
        for normals in [Normals::None, Normals::Fields, Normals::Exact] {
            let start = Instant::now();
            let uploaded = self.skinner.upload(asset, normals)?;
            let upload = start.elapsed().as_secs_f64();
            let (count, output) = match self.skinner.output(&uploaded, count) {
                Err(GpuError::TooManyInstances { fit, .. }) if fit > 0 => {
                    println!("  {count} instances do not fit a binding: {fit} of them");
                    (fit as u32, self.skinner.output(&uploaded, fit as u32)?)
                }
                output => (count, output?),
            };
            let mut instances = self.skinner.instances(&uploaded, count)?;
            let posing = fill(&mut instances, asset, count)?;
            let seconds = self.timer.seconds(self.rounds, self.repeats, |encoder| {
                Ok(self
                    .skinner
                    .record(encoder, &uploaded, &instances, &output)?)
            })?;
            // Each byte that has to be moved, once, whatever caches do.
            let points = 12 * n * count as usize;
            let mut moved = points
                + 12 * asset.positions().len()
                + 12 * n * m
                + instances.buffer().size() as usize;
            moved += match normals {
                Normals::Fields => points + NormalFields::new(asset)?.bytes() as usize,
                Normals::Exact => 2 * points + 4 * n + 24 * asset.triangle_count(),
                _ => 0,
            };
            let bandwidth = moved as f64 / seconds;
            println!(
                "  {:<22} {count:>5} instances {:>9.3} ms {:>8.1} MB moved {:>8.1} GB/s {:>5.1} % of a copy {:>7.2} G vertices/s; \
                 poses {:.2} ms, upload {:.0} ms",
                match normals {
                    Normals::Fields => "positions, fields",
                    Normals::Exact => "positions, exact",
                    _ => "positions",
                },
                1e3 * seconds,
                moved as f64 / 1e6,
                bandwidth / 1e9,
                100.0 * bandwidth / self.copy,
                n as f64 * f64::from(count) / seconds / 1e9,
                1e3 * posing,
                1e3 * upload,
            );
        }
        Ok(())
    }
}

/// Poses all instances at random; returns the seconds that takes, with what is copied.
fn fill(instances: &mut Instances, asset: &Asset<'_>, count: u32) -> Result<f64, Box<dyn Error>> {
    let mut rng = poses::rng(1);
    let placed: Vec<_> = (0..count)
        .map(|_| {
            let q = poses::random_q(asset, 0.1, &mut rng);
            (q, poses::random_transform(10.0, &mut rng))
        })
        .collect();
    let start = Instant::now();
    instances.clear(asset.origin());
    for (q, place) in &placed {
        instances.push_at(asset, q, *place)?;
    }
    instances.write();
    Ok(start.elapsed().as_secs_f64())
}
