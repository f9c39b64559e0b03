//! Each frame: the entities whose pose changed are deformed, and their vertices written where Bevy draws from.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use bdtree_gpu::{GpuAsset, GpuError, Instances, Normals, Output, Skinner};
use bdtree_runtime::{AssetId, BoneMatrices, Model, Transform};
use bevy_ecs::prelude::*;
use bevy_log::error;
use bevy_mesh::{Mesh, VertexFormat};
use bevy_render::mesh::RenderMesh;
use bevy_render::mesh::allocator::{MeshAllocator, MeshAllocatorSettings, MeshSlabId};
use bevy_render::render_asset::RenderAssets;
use bevy_render::renderer::{RenderDevice, RenderQueue};
use wgpu::util::DeviceExt;

use super::extract::{Bodies, Body};
use super::tangents::Tangents;
use super::windows::windows;
use super::write::{Target, VertexLayout, Writer};
use crate::faults::Kinds;

/// Bytes of deformed positions and normals of one file at a time: more entities are done one batch behind the other.
const BATCH_BYTES: u64 = 64 << 20;
/// Entities of a batch.
const BATCH: u64 = 512;

/// What deforms, on Bevy's device.
#[derive(Resource)]
pub(crate) struct Deformer {
    skinner: Skinner,
    writer: Writer,
    /// `None`: refused, and reported.
    uploaded: HashMap<AssetId, Option<Uploaded>>,
    /// By their address.
    tangents: HashMap<usize, UploadedTangents>,
    /// Errors that were reported.
    told: Kinds,
}

/// Tangents on the device.
struct UploadedTangents {
    /// They stay, or others could get their address.
    _kept: Arc<Tangents>,
    words: wgpu::Buffer,
}

/// A file on the device.
struct Uploaded {
    /// What it was made of stays, or another file could get its id.
    model: Model,
    gpu: GpuAsset,
    instances: Instances,
    output: Output,
}

/// Entities of one file in one buffer of one layout, with the tangents of one mesh.
type Group = (AssetId, MeshSlabId, VertexLayout, Option<usize>);

/// The address of an entity's tangents.
fn address(tangents: &Arc<Tangents>) -> usize {
    Arc::as_ptr(tangents) as usize
}

/// Whether a device runs what deforms: WebGL 2 does not.
fn is_able(device: &RenderDevice) -> bool {
    let limits = device.limits();
    limits.max_compute_workgroups_per_dimension > 0
        && limits.max_storage_buffers_per_shader_stage > 4
}

/// Lets compute passes write to vertex buffers, before Bevy makes any.
pub(crate) fn allow_writes(device: Res<RenderDevice>, mut settings: ResMut<MeshAllocatorSettings>) {
    if is_able(&device) {
        settings.extra_buffer_usages |= wgpu::BufferUsages::STORAGE;
    }
}

/// Makes what is needed on a new device.
pub(crate) fn start(
    mut commands: Commands,
    mut bodies: ResMut<Bodies>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    for body in bodies.0.values_mut() {
        body.is_stale = true;
    }
    if !is_able(&device) {
        commands.remove_resource::<Deformer>();
        error!("meshes are drawn undeformed: the device has no compute shaders");
        return;
    }
    match Skinner::new(device.wgpu_device(), &queue) {
        Ok(skinner) => commands.insert_resource(Deformer {
            skinner,
            writer: Writer::new(device.wgpu_device()),
            uploaded: HashMap::new(),
            tangents: HashMap::new(),
            told: Kinds::default(),
        }),
        Err(why) => {
            commands.remove_resource::<Deformer>();
            error!("meshes are drawn undeformed: {why}");
        }
    }
}

/// After meshes were allocated, before anything is drawn.
pub(crate) fn deform(
    deformer: Option<ResMut<Deformer>>,
    mut bodies: ResMut<Bodies>,
    meshes: Res<RenderAssets<RenderMesh>>,
    allocator: Res<MeshAllocator>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let Some(mut deformer) = deformer else {
        return;
    };
    let used: HashSet<AssetId> = bodies.0.values().map(|b| b.model.asset().id()).collect();
    deformer.uploaded.retain(|id, _| used.contains(id));
    let all = bodies.0.values().filter_map(|b| b.tangents.as_ref());
    let used: HashSet<usize> = all.map(address).collect();
    deformer.tangents.retain(|at, _| used.contains(at));

    let mut groups: HashMap<Group, Vec<(Range<u64>, &mut Body)>> = HashMap::new();
    for body in bodies.0.values_mut().filter(|body| body.is_stale) {
        // Later, where the mesh is not there yet.
        let Some(mesh) = meshes.get(body.mesh) else {
            continue;
        };
        let (Some(slabs), Some(slice)) = (
            allocator.mesh_slabs(&body.mesh),
            allocator.mesh_vertex_slice(&body.mesh),
        ) else {
            continue;
        };
        body.is_stale = false;
        let Some(layout) = layout(mesh) else {
            continue;
        };
        let tangents = match (&body.tangents, layout.tangent) {
            (Some(tangents), Some(_)) => deformer.upload(tangents, &device),
            _ => None,
        };
        let stride = 4 * u64::from(layout.stride);
        let bytes = stride * u64::from(slice.range.start)..stride * u64::from(slice.range.end);
        let group = (
            body.model.asset().id(),
            slabs.vertex_slab_id,
            layout,
            tangents,
        );
        groups.entry(group).or_default().push((bytes, body));
    }
    for ((id, slab, layout, tangents), mut group) in groups {
        let Some(buffer) = allocator.buffer_for_slab(slab) else {
            continue;
        };
        group.sort_unstable_by_key(|(bytes, _)| bytes.start);
        let Deformer {
            skinner,
            writer,
            uploaded,
            tangents: all_tangents,
            told,
        } = &mut *deformer;
        let uploaded = uploaded
            .entry(id)
            .or_insert_with(|| Uploaded::new(skinner, &group[0].1.model));
        let Some(uploaded) = uploaded else {
            continue;
        };
        let target = Buffer {
            buffer,
            layout,
            tangents: tangents.and_then(|at| Some(&all_tangents.get(&at)?.words)),
        };
        for batch in group.chunks_mut(batch_len(&uploaded.gpu)) {
            let done = uploaded.batch(skinner, writer, &device, &queue, target, batch);
            if let Err(why) = done {
                let words = why.to_string();
                if told.is_new(&words) {
                    error!("meshes are drawn undeformed: {words}");
                }
            }
        }
    }
}

/// Where the vertices of a group lie.
#[derive(Clone, Copy)]
struct Buffer<'b> {
    buffer: &'b wgpu::Buffer,
    layout: VertexLayout,
    tangents: Option<&'b wgpu::Buffer>,
}

impl Deformer {
    /// Brings tangents to the device, once. Their address; `None` of what the device cannot bind.
    fn upload(&mut self, tangents: &Arc<Tangents>, device: &RenderDevice) -> Option<usize> {
        let bytes = 4 * tangents.words.len() as u64;
        let limit = device.limits().max_storage_buffer_binding_size;
        if bytes > limit {
            let words = format!(
                "tangents stay undeformed: those of a mesh take {bytes} bytes, the device allows {limit}"
            );
            if self.told.is_new(&words) {
                error!("{words}");
            }
            return None;
        }
        let at = address(tangents);
        self.tangents.entry(at).or_insert_with(|| {
            let bytes: Vec<u8> = (tangents.words.iter())
                .flat_map(|word| word.to_le_bytes())
                .collect();
            let words =
                device
                    .wgpu_device()
                    .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                        label: Some("bdtree tangents"),
                        contents: &bytes,
                        usage: wgpu::BufferUsages::STORAGE,
                    });
            UploadedTangents {
                _kept: tangents.clone(),
                words,
            }
        });
        Some(at)
    }
}

impl Uploaded {
    fn new(skinner: &Skinner, model: &Model) -> Option<Self> {
        let made = skinner
            .upload(model.asset(), Normals::Exact)
            .and_then(|gpu| {
                Ok(Self {
                    model: model.clone(),
                    instances: skinner.instances(&gpu, 1)?,
                    output: skinner.output(&gpu, 1)?,
                    gpu,
                })
            });
        made.inspect_err(|why| error!("a mesh is drawn undeformed: {why}"))
            .ok()
    }

    /// Makes room for so many entities.
    fn reserve(&mut self, skinner: &Skinner, count: usize) -> Result<(), GpuError> {
        if (self.instances.capacity() as usize) < count {
            let capacity = count.next_power_of_two().min(batch_len(&self.gpu));
            self.instances = skinner.instances(&self.gpu, capacity as u32)?;
            self.output = skinner.output(&self.gpu, capacity as u32)?;
        }
        Ok(())
    }

    /// Deforms and writes some entities, their vertices in ascending order.
    fn batch(
        &mut self,
        skinner: &Skinner,
        writer: &Writer,
        device: &RenderDevice,
        queue: &RenderQueue,
        target: Buffer<'_>,
        batch: &[(Range<u64>, &mut Body)],
    ) -> Result<(), GpuError> {
        self.reserve(skinner, batch.len())?;
        let asset = self.model.asset();
        // The space of the entity.
        self.instances.clear([0.0; 3]);
        let mut places = Vec::with_capacity(batch.len());
        for (bytes, body) in batch {
            let bones = match body.joints.as_slice() {
                [] => BoneMatrices::Rest,
                joints => BoneMatrices::Joints(joints),
            };
            let at = Transform::IDENTITY;
            // `update_instances` reports a pose that is refused; the last one stays.
            let pushed = self.instances.push_with_bones(asset, &body.q, bones, at);
            if pushed.is_ok() {
                places.push(bytes.clone());
            }
        }
        self.instances.write();
        let mut encoder =
            device
                .wgpu_device()
                .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                    label: Some("bdtree"),
                });
        skinner.record(&mut encoder, &self.gpu, &self.instances, &self.output)?;
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size;
        let align = u64::from(limits.min_storage_buffer_offset_alignment);
        let windows = match windows(&places, limit, align) {
            Ok(windows) => windows,
            Err(at) => {
                let bytes = places[at].end - places[at].start;
                return Err(GpuError::AssetTooLarge {
                    what: "vertices of a mesh",
                    bytes,
                    limit,
                });
            }
        };
        for window in windows {
            let first = window.items.start as u32;
            let of_window = &places[window.items];
            let job = Target {
                buffer: target.buffer,
                start: window.start,
                len: window.len,
                layout: target.layout,
                tangents: target.tangents,
                places: of_window
                    .iter()
                    .map(|bytes| ((bytes.start - window.start) / 4) as u32)
                    .collect(),
                first_instance: first,
                vertex_count: self.gpu.vertex_count(),
            };
            writer.record(&mut encoder, &self.output, &job);
        }
        queue.submit([encoder.finish()]);
        Ok(())
    }
}

/// Entities of this file that are deformed at a time.
fn batch_len(gpu: &GpuAsset) -> usize {
    let bytes = 24 * u64::from(gpu.vertex_count()).max(1);
    (BATCH_BYTES / bytes).clamp(1, BATCH) as usize
}

/// Where vertices have what is written; `None` for those that cannot be written, which [`super::surface`] does not make.
fn layout(mesh: &RenderMesh) -> Option<VertexLayout> {
    let mesh = &mesh.layout.0;
    let word = |attribute: bevy_mesh::MeshVertexAttribute, format: VertexFormat| {
        let place = mesh
            .attribute_ids()
            .iter()
            .position(|id| *id == attribute.id)?;
        let found = mesh.layout().attributes.get(place)?;
        (found.format == format).then_some(found.offset as u32 / 4)
    };
    Some(VertexLayout {
        stride: mesh.layout().array_stride as u32 / 4,
        position: word(Mesh::ATTRIBUTE_POSITION, VertexFormat::Float32x3)?,
        normal: word(Mesh::ATTRIBUTE_NORMAL, VertexFormat::Float32x3)?,
        tangent: word(Mesh::ATTRIBUTE_TANGENT, VertexFormat::Float32x4),
    })
}
