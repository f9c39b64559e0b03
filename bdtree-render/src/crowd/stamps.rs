//! When the device began and ended a picture, where it can tell.

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Features, MapMode};
use wgpu::{QuerySet, QuerySetDescriptor, QueryType};

use crate::gpu::Gpu;

#[derive(Debug)]
pub(super) struct Stamps {
    set: QuerySet,
    resolved: Buffer,
    read: Buffer,
}

impl Stamps {
    /// Nothing without timestamps.
    pub(super) fn new(gpu: &Gpu) -> Option<Self> {
        let needed = Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let buffer = |usage| {
            gpu.device.create_buffer(&BufferDescriptor {
                label: Some("timestamps"),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        gpu.device.features().contains(needed).then(|| Self {
            set: gpu.device.create_query_set(&QuerySetDescriptor {
                label: Some("timestamps"),
                ty: QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            read: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        })
    }

    pub(super) fn begin(&self, encoder: &mut CommandEncoder) {
        encoder.write_timestamp(&self.set, 0);
    }

    pub(super) fn end(&self, encoder: &mut CommandEncoder) {
        encoder.write_timestamp(&self.set, 1);
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, 16);
    }

    /// Seconds between the two, once the work is done; nothing if the device says nothing.
    pub(super) fn seconds(&self, gpu: &Gpu) -> Option<f64> {
        self.read.slice(..).map_async(MapMode::Read, |_| ());
        gpu.finish().ok()?;
        let view = self.read.slice(..).get_mapped_range().ok()?;
        let (words, _) = view.as_chunks::<8>();
        let ticks = match words {
            [first, last] => u64::from_le_bytes(*last).checked_sub(u64::from_le_bytes(*first)),
            _ => None,
        };
        drop(view);
        self.read.unmap();
        Some(ticks? as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9)
    }
}
