//! Buffers made of bytes as they lie in memory.

use crate::error::GpuError;

/// Bytes that are copied to the device before the next part: what is on its way is kept in memory twice.
const PART: usize = 64 << 20;

/// A buffer of these runs of bytes, one behind the other. All but the last are of whole words; what
/// the last lacks to a word is zero.
pub(crate) fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &'static str,
    usage: wgpu::BufferUsages,
    runs: &[&[u8]],
) -> Result<wgpu::Buffer, GpuError> {
    let bytes = runs.iter().map(|run| run.len() as u64).sum::<u64>();
    let limit = device.limits().max_buffer_size;
    if bytes > limit {
        return Err(GpuError::AssetTooLarge {
            what: label,
            bytes,
            limit,
        });
    }
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        // Nothing of size 0 can be bound.
        size: bytes.next_multiple_of(4).max(16),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut offset = 0;
    for run in runs {
        let (words, rest) = run.split_at(run.len() & !3);
        for part in words.chunks(PART) {
            queue.write_buffer(&buffer, offset, part);
            if part.len() == PART {
                queue.submit(None);
            }
            offset += part.len() as u64;
        }
        if !rest.is_empty() {
            let mut word = [0; 4];
            word[..rest.len()].copy_from_slice(rest);
            queue.write_buffer(&buffer, offset, &word);
            offset += 4;
        }
    }
    Ok(buffer)
}
