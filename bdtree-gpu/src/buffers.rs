//! Buffers and bind groups.

use crate::error::GpuError;
use crate::skinner::Skinner;

/// Bytes that are copied to the device before the next part: what is on its way is kept in memory twice.
const PART: usize = 64 << 20;

impl Skinner {
    pub(crate) fn buffer(
        &self,
        label: &'static str,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            // Nothing of size 0 can be bound.
            size: size.max(16),
            usage,
            mapped_at_creation: false,
        })
    }

    /// A buffer of these runs of bytes, one behind the other. All but one are of whole words; what that one lacks to a
    /// word is zero.
    pub(crate) fn filled(
        &self,
        label: &'static str,
        usage: wgpu::BufferUsages,
        runs: &[&[u8]],
    ) -> Result<wgpu::Buffer, GpuError> {
        let bytes = runs.iter().map(|run| run.len() as u64).sum::<u64>();
        let limit = self.device.limits().max_buffer_size;
        if bytes > limit {
            let what = label;
            return Err(GpuError::AssetTooLarge { what, bytes, limit });
        }
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(label, bytes.next_multiple_of(4), usage);
        let mut offset = 0;
        for run in runs {
            let (words, rest) = run.split_at(run.len() & !3);
            for part in words.chunks(PART) {
                self.queue.write_buffer(&buffer, offset, part);
                if part.len() == PART {
                    self.queue.submit(None);
                }
                offset += part.len() as u64;
            }
            if !rest.is_empty() {
                let mut word = [0; 4];
                word[..rest.len()].copy_from_slice(rest);
                self.queue.write_buffer(&buffer, offset, &word);
                offset += 4;
            }
        }
        Ok(buffer)
    }

    /// A bind group of whole buffers at bindings 0, 1, 2, ….
    pub(crate) fn bind(
        &self,
        layout: &wgpu::BindGroupLayout,
        buffers: &[&wgpu::Buffer],
    ) -> wgpu::BindGroup {
        let entries = (0..).zip(buffers).map(|(binding, buffer)| {
            let resource = buffer.as_entire_binding();
            wgpu::BindGroupEntry { binding, resource }
        });
        let entries: Vec<_> = entries.collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("bdtree"),
            layout,
            entries: &entries,
        })
    }
}
