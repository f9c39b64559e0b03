//! The GPU that tests run on, on a machine without one Mesa's lavapipe; and assets skinned on it.

use bdtree_fixtures::{bake, golden, poses};
use bdtree_gpu::{GpuError, Instances, Normals, Skinner, read_back, request_device};
use bdtree_runtime::{Asset, Model, Transform};

/// A device and its queue.
pub(crate) struct Gpu {
    /// Where everything is made.
    pub(crate) device: wgpu::Device,
    /// Where everything is submitted.
    pub(crate) queue: wgpu::Queue,
    /// What draws, and its version.
    pub(crate) driver: String,
}

/// What came back of all instances, one behind the other.
pub(crate) struct Skinned {
    /// Positions less the origin.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Empty without normals.
    pub(crate) normals: Vec<[f32; 3]>,
    /// The instances, for twins.
    pub(crate) instances: Instances,
    /// The bound of each instance's positions.
    pub(crate) errors: Vec<f64>,
}

impl Gpu {
    /// A device with all that the first adapter allows.
    ///
    /// # Panics
    /// When there is none: tests that need one do not pass without.
    pub(crate) fn new() -> Self {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let (_, device, queue) = pollster::block_on(request_device(&instance, None))
            .expect("a GPU, or Mesa's lavapipe (mesa-vulkan-drivers, libvulkan1)");
        Self::of(device, queue)
    }

    /// A device that allows less.
    ///
    /// # Panics
    /// When there is none.
    pub(crate) fn with_limits(change: impl FnOnce(&mut wgpu::Limits)) -> Self {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = pollster::block_on(instance.request_adapter(&options)).expect("an adapter");
        let mut limits = adapter.limits();
        change(&mut limits);
        let descriptor = wgpu::DeviceDescriptor {
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
        Self::of(device, queue)
    }

    fn of(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let info = device.adapter_info();
        Self {
            driver: format!("{} ({} {})", info.name, info.driver, info.driver_info),
            device,
            queue,
        }
    }

    /// Uploads an asset, deforms it for all q and placements, and reads back.
    ///
    /// # Errors
    /// Those of each step.
    pub(crate) fn skin(
        &self,
        asset: &Asset<'_>,
        normals: Normals,
        placed: &[(Vec<f32>, Transform)],
        origin: [f64; 3],
    ) -> Result<Skinned, GpuError> {
        self.skin_each(asset, normals, placed.len(), origin, |instances, k| {
            let (q, transform) = &placed[k];
            instances.push_at(asset, q, *transform)
        })
    }

    /// The same of so many instances, added by `push`.
    ///
    /// # Errors
    /// Those of each step.
    pub(crate) fn skin_each(
        &self,
        asset: &Asset<'_>,
        normals: Normals,
        count: usize,
        origin: [f64; 3],
        mut push: impl FnMut(&mut Instances, usize) -> Result<f64, GpuError>,
    ) -> Result<Skinned, GpuError> {
        let skinner = Skinner::new(&self.device, &self.queue)?;
        let uploaded = skinner.upload(asset, normals)?;
        let mut instances = skinner.instances(&uploaded, count as u32)?;
        let output = skinner.output(&uploaded, count as u32)?;
        instances.clear(origin);
        let mut errors = Vec::new();
        for k in 0..count {
            errors.push(push(&mut instances, k)?);
        }
        instances.write();
        let mut encoder = self.device.create_command_encoder(&Default::default());
        skinner.record(&mut encoder, &uploaded, &instances, &output)?;
        self.queue.submit([encoder.finish()]);
        let all = asset.vertex_count() * count;
        let read = |buffer| read_back(&self.device, &self.queue, buffer, all);
        Ok(Skinned {
            positions: read(output.positions())?,
            normals: output.normals().map(read).transpose()?.unwrap_or_default(),
            instances,
            errors,
        })
    }
}

impl Default for Gpu {
    fn default() -> Self {
        Self::new()
    }
}

/// Golden files and baked ones: no modes, one, many and more than a chunk of them, of all vertices or of
/// some; beside the origin, far from it, tiny, huge.
///
/// # Panics
/// When a golden file is missing or a bake fails.
pub(crate) fn assets() -> Vec<(String, Model)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(golden::folder()).expect("the golden files") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|e| e == "bdt") {
            let model = Model::read(&path).expect("a golden file");
            all.push((path.display().to_string(), model));
        }
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    let (small, large) = (bake::bumpy_sphere(6, 2), bake::bumpy_sphere(14, 1));
    let scaled = |by: f64, scale: f64| {
        let mut mesh = small.clone();
        for p in &mut mesh.positions {
            *p = [scale * p[0] + by, scale * p[1] - by, scale * p[2]];
        }
        mesh
    };
    for (name, mesh, modes) in [
        ("one mode", &small, 1),
        ("eight modes", &large, 8),
        ("ten modes", &large, 10),
        ("64 modes", &small, 64),
        ("far", &scaled(1e6, 1.0), 5),
        ("tiny", &scaled(0.0, 1e-7), 5),
        ("huge", &scaled(0.0, 1e9), 5),
    ] {
        let basis = bake::smooth_basis(mesh, modes, 3);
        all.push((name.into(), bake::baked(mesh, &basis)));
    }
    for (name, mesh, modes) in [("12 local", &large, 12), ("25 local", &small, 25)] {
        let basis = bake::local_basis(mesh, modes, 3);
        all.push((name.into(), bake::baked(mesh, &basis)));
    }
    all.push(("rigid".into(), bake::baked(&large, &bake::rigid(&large))));
    all
}

/// q at rest, adversarial, at its limits and random, each placed at random.
pub(crate) fn placed(asset: &Asset<'_>, seed: u64) -> Vec<(Vec<f32>, Transform)> {
    let mut rng = poses::rng(seed);
    let mut all = vec![(vec![0.0; asset.mode_count()], Transform::IDENTITY)];
    let mut qs = poses::hard_qs(asset);
    qs.extend((0..9).map(|_| poses::random_q(asset, 0.3, &mut rng)));
    for q in qs {
        all.push((q, poses::random_transform(3.0, &mut rng)));
    }
    all
}
