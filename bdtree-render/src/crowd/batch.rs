//! An asset of a crowd, and the memory that some of its bodies are deformed in.

use std::ops::Range;

use bdtree_gpu::{GpuAsset, Instances, Normals, Output, Skinner};
use bdtree_runtime::Model;
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Queue};
use zerocopy::IntoBytes;

use super::Shot;
use super::detail::details;
use super::view::Drawn;
use crate::error::RenderError;
use crate::gpu::Gpu;
use crate::renderer::{BodyBuffers, filled};
use crate::shading::smoothness;

/// An asset on the device.
#[derive(Debug)]
pub(super) struct Member {
    model: Model,
    asset: GpuAsset,
    smoothness: Buffer,
    /// Corners of triangles: all, then those of coarser and coarser levels.
    indices: Buffer,
    /// How far corners of each level have moved (mesh units), and where it is among the corners.
    levels: Vec<(f64, Range<u32>)>,
    /// Bodies that the memory for deformed vertices allows.
    room_max: usize,
    batch: Option<Batch>,
}

/// Bodies and their deformed vertices.
#[derive(Debug)]
struct Batch {
    instances: Instances,
    output: Output,
    colours: Buffer,
    /// Which corners of the asset are drawn of each body.
    corners: Vec<Range<u32>>,
}

impl Member {
    pub(super) fn new(
        gpu: &Gpu,
        skinner: &Skinner,
        model: &Model,
        batch_bytes: u64,
    ) -> Result<Self, RenderError> {
        let asset = model.asset();
        let triangles: Vec<_> = asset.triangles().iter().map(|t| t.corners).collect();
        let smoothness = smoothness(asset.positions(), &triangles);
        let what = "smoothness of vertices";
        let usage = BufferUsages::VERTEX;
        let smoothness = filled(&gpu.device, what, smoothness.as_bytes(), usage)?;
        let coarser = details(asset.positions(), &triangles);
        let mut levels = vec![(0.0, 0..3 * triangles.len() as u32)];
        let mut corners = triangles;
        for detail in coarser {
            let first = 3 * corners.len() as u32;
            corners.extend(&detail.triangles);
            levels.push((detail.moved * asset.unit(), first..3 * corners.len() as u32));
        }
        let what = "corners of triangles";
        let indices = filled(&gpu.device, what, corners.as_bytes(), BufferUsages::INDEX)?;
        let asset = skinner.upload(asset, Normals::Exact)?;
        let limits = gpu.device.limits();
        let binding = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let points = 12 * u64::from(asset.vertex_count()).max(1);
        // Its matrix, q and bones, eight bodies side by side, and its colour.
        let numbers = 12 + asset.mode_count() + 12 * asset.bone_count();
        let own = 4 * numbers as u64;
        // What eight bodies take, of which the last block may have one.
        let spare = 8 * own + 64;
        let within = batch_bytes.saturating_sub(spare) / (2 * points + own + 4);
        let allowed = (binding / points).min(binding.saturating_sub(spare) / own);
        let room_max = within.min(allowed).clamp(1, 1 << 20) as usize;
        Ok(Self {
            model: model.clone(),
            asset,
            smoothness,
            indices,
            levels,
            room_max,
            batch: None,
        })
    }

    pub(super) fn model(&self) -> &Model {
        &self.model
    }

    pub(super) fn asset_bytes(&self) -> u64 {
        self.asset.bytes() + self.smoothness.size() + self.indices.size()
    }

    pub(super) fn batch_bytes(&self) -> u64 {
        self.batch.as_ref().map_or(0, |batch| {
            let output = &batch.output;
            let normals = output.normals().map_or(0, Buffer::size);
            let deformed = output.positions().size() + normals;
            deformed + batch.instances.buffer().size() + batch.colours.size()
        })
    }

    /// Bodies that there is room for.
    pub(super) fn room(&self) -> usize {
        let batch = self.batch.as_ref();
        batch.map_or(0, |batch| batch.output.capacity() as usize)
    }

    /// Makes room for so many bodies, or as many as may be.
    pub(super) fn make_room(
        &mut self,
        gpu: &Gpu,
        skinner: &Skinner,
        count: usize,
    ) -> Result<(), RenderError> {
        if self.room() >= count.min(self.room_max) {
            return Ok(());
        }
        // A little more, since the next picture may show a little more.
        let room = (count + count / 4).min(self.room_max) as u32;
        // First what there was: both would not keep to the limit.
        self.batch = None;
        let batch = Batch {
            instances: skinner.instances(&self.asset, room)?,
            output: skinner.output(&self.asset, room)?,
            colours: gpu.device.create_buffer(&BufferDescriptor {
                label: Some("colours of bodies"),
                size: 4 * u64::from(room),
                usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            corners: Vec::new(),
        };
        gpu.check()?;
        self.batch = Some(batch);
        Ok(())
    }

    /// Writes these bodies and records their deformation; there is room for them. Corners may be moved by `coarser_by`
    /// at a unit's distance.
    pub(super) fn deform(
        &mut self,
        (skinner, queue, encoder): (&Skinner, &Queue, &mut CommandEncoder),
        shot: &Shot<'_>,
        drawn: &[Drawn],
        coarser_by: f64,
    ) -> Result<(), RenderError> {
        let Some(batch) = &mut self.batch else {
            return Ok(());
        };
        batch.instances.clear(shot.origin);
        batch.corners.clear();
        let mut colours = Vec::with_capacity(drawn.len());
        for Drawn { number, away, .. } in drawn {
            let body = &shot.bodies[*number];
            let asset = self.model.asset();
            batch
                .instances
                .push_with_bones(asset, body.q, body.bones, body.placement)
                .map_err(|error| RenderError::Body {
                    body: *number,
                    reason: error.to_string(),
                })?;
            let [r, g, b] = body.colour;
            colours.push([r, g, b, 255]);
            let is_allowed =
                |level: &&(f64, Range<u32>)| level.0 * body.placement.scale <= coarser_by * away;
            let level = self.levels.iter().rfind(is_allowed);
            // All of it, whose corners have not moved.
            let level = level.or(self.levels.first());
            batch.corners.extend(level.map(|level| level.1.clone()));
        }
        batch.instances.write();
        queue.write_buffer(&batch.colours, 0, colours.as_bytes());
        Ok(skinner.record(encoder, &self.asset, &batch.instances, &batch.output)?)
    }

    /// Triangles of the bodies that were deformed last.
    pub(super) fn triangles(&self) -> u64 {
        let corners = self.batch.iter().flat_map(|batch| &batch.corners);
        corners.map(|range| (range.len() / 3) as u64).sum()
    }

    /// What is to be drawn of the bodies that were deformed last.
    pub(super) fn buffers(&self) -> Option<BodyBuffers<'_>> {
        let batch = self.batch.as_ref()?;
        Some(BodyBuffers {
            positions: batch.output.positions(),
            normals: batch.output.normals()?,
            smoothness: &self.smoothness,
            indices: &self.indices,
            colours: &batch.colours,
            vertex_count: self.asset.vertex_count(),
            corners: &batch.corners,
        })
    }
}
