//! The compute passes.

use std::sync::OnceLock;

use bdtree_runtime::Asset;

use crate::asset::{GpuAsset, Normals};
use crate::device::{checked, largest_binding, scoped};
use crate::error::GpuError;
use crate::instances::{BLOCK, CAPACITY_MAX, Instances, RowLayout};
use crate::layouts::Layouts;
use crate::output::{Output, bytes};
use crate::ranges::BoundRange;
use crate::shader::{Pass, Variant};

/// From this number of instances on a thread does eight of them: their reading is shared, and lanes
/// that stay idle cost less than reading fields again.
const WIDE_FROM: u32 = 3;

/// Compute passes on one device, and what is made for them. Pipelines are compiled when they are
/// first needed.
#[derive(Debug)]
pub struct Skinner {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) layouts: Layouts,
    pipelines: [OnceLock<wgpu::ComputePipeline>; Variant::COUNT],
}

impl Skinner {
    /// Skinning on the caller's device.
    ///
    /// # Errors
    /// What the device refuses.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Self, GpuError> {
        checked(device, || {
            Ok(Self {
                device: device.clone(),
                queue: queue.clone(),
                layouts: Layouts::new(device),
                pipelines: [const { OnceLock::new() }; Variant::COUNT],
            })
        })
    }

    /// Copies an asset to the device: positions, displacements and mode lists as they lie in the
    /// file. Where these are larger than one binding may be, it is split into ranges of vertices.
    ///
    /// # Errors
    /// Records that break the format's rules; more than the device allows; what it refuses.
    pub fn upload(&self, asset: &Asset<'_>, normals: Normals) -> Result<GpuAsset, GpuError> {
        GpuAsset::new(self, asset, normals)
    }

    /// Room for so many instances of an asset.
    ///
    /// # Errors
    /// More than the device allows; what it refuses.
    pub fn instances(&self, asset: &GpuAsset, capacity: u32) -> Result<Instances, GpuError> {
        let limit = largest_binding(&self.device);
        let layout = RowLayout {
            mode_count: asset.mode_count(),
            bone_count: asset.bone_count(),
        };
        let size = layout.bytes(capacity);
        if size > limit || capacity > CAPACITY_MAX {
            let block = layout.bytes(1) - 32;
            return Err(GpuError::TooManyInstances {
                instances: u64::from(capacity),
                fit: (8 * (limit.saturating_sub(32) / block)).min(u64::from(CAPACITY_MAX)),
                bytes: size,
                limit,
            });
        }
        checked(&self.device, || {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let buffer = self.buffer("instances", size, usage);
            Ok(Instances {
                group: self.bind(&self.layouts.instances, &[&buffer]),
                buffer,
                queue: self.queue.clone(),
                asset: asset.asset,
                layout,
                capacity,
                count: 0,
                origin: [0.0; 3],
                rows: vec![[0.0; BLOCK]],
                memory: Vec::new(),
            })
        })
    }

    /// Room for the positions, and normals if the asset has them, of so many instances.
    ///
    /// # Errors
    /// More than the device allows, with the number of instances that fit; what it refuses.
    pub fn output(&self, asset: &GpuAsset, capacity: u32) -> Result<Output, GpuError> {
        let size = bytes(&self.device, asset.vertex_count(), capacity)?;
        let usage =
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC;
        checked(&self.device, || {
            let positions = self.buffer("positions", size, usage);
            let mut groups = vec![self.bind(&self.layouts.output, &[&positions])];
            let normals = match asset.normals() {
                Normals::None => None,
                Normals::Fields | Normals::Exact => {
                    let normals = self.buffer("normals", size, usage);
                    groups.push(self.bind(&self.layouts.output, &[&normals]));
                    let both = [&positions, &normals];
                    groups.push(self.bind(&self.layouts.exact_output, &both));
                    Some(normals)
                }
            };
            Ok(Output {
                asset: asset.asset,
                kind: asset.normals(),
                capacity,
                positions,
                normals,
                groups,
            })
        })
    }

    /// Records the passes that deform all instances, as they are written when the commands run.
    ///
    /// # Errors
    /// Instances or output of another asset, an output with too little room; what the device refuses.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        asset: &GpuAsset,
        instances: &Instances,
        output: &Output,
    ) -> Result<(), GpuError> {
        if instances.asset != asset.asset {
            return Err(GpuError::Mismatch("the instances were"));
        }
        if (output.asset, output.kind) != (asset.asset, asset.normals()) {
            return Err(GpuError::Mismatch("the output was"));
        }
        if instances.len() > output.capacity() {
            return Err(GpuError::Full {
                capacity: output.capacity(),
            });
        }
        if instances.is_empty() {
            return Ok(());
        }
        scoped(&self.device, || {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("bdtree skinning"),
                timestamp_writes: None,
            });
            pass.set_bind_group(1, &instances.group, &[]);
            let mut run = |kind: Pass, listed: bool, ranges: &[BoundRange], group: usize| {
                if ranges.is_empty() {
                    return Ok(());
                }
                let variant = Variant {
                    pass: kind,
                    skinned: asset.has_skin() && kind != Pass::Exact,
                    listed,
                    wide: instances.len() >= WIDE_FROM,
                };
                pass.set_pipeline(self.pipeline(variant)?);
                pass.set_bind_group(2, &output.groups[group], &[]);
                for range in ranges {
                    pass.set_bind_group(0, &range.group, &[]);
                    let tiles = u64::from(range.count.div_ceil(64));
                    let blocks = u64::from(instances.len().div_ceil(variant.lanes()));
                    let [x, y] = self.workgroups(tiles * blocks);
                    pass.dispatch_workgroups(x, y, 1);
                }
                Ok::<_, GpuError>(())
            };
            run(Pass::Points, asset.listed, &asset.points, 0)?;
            match asset.normals() {
                Normals::None => Ok(()),
                Normals::Fields => {
                    run(Pass::Normals, asset.listed, &asset.tangents, 1)?;
                    run(Pass::Exact, true, &asset.exact, 2)
                }
                Normals::Exact => run(Pass::Exact, false, &asset.exact, 2),
            }
        })
    }

    /// So many workgroups as a grid that the device allows; the shaders count them through.
    fn workgroups(&self, count: u64) -> [u32; 2] {
        let most = self.device.limits().max_compute_workgroups_per_dimension;
        let limit = u64::from(most.max(1));
        let y = count.div_ceil(limit);
        // An output that fits a binding has fewer than 2^28 workgroups, which two dimensions hold.
        [count.div_ceil(y.max(1)) as u32, y as u32]
    }

    fn pipeline(&self, variant: Variant) -> Result<&wgpu::ComputePipeline, GpuError> {
        let place = &self.pipelines[variant.index()];
        if let Some(pipeline) = place.get() {
            return Ok(pipeline);
        }
        let device = &self.device;
        let made = checked(device, || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("bdtree skinning"),
                source: wgpu::ShaderSource::Wgsl(variant.source().into()),
            });
            let output = match variant.pass {
                Pass::Exact => &self.layouts.exact_output,
                _ => &self.layouts.output,
            };
            let groups = [&self.layouts.fields, &self.layouts.instances, output].map(Some);
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("bdtree skinning"),
                bind_group_layouts: &groups,
                immediate_size: 0,
            });
            Ok(
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some("bdtree skinning"),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some("main"),
                    compilation_options: Default::default(),
                    cache: None,
                }),
            )
        })?;
        Ok(place.get_or_init(|| made))
    }
}
