//! Instances: q and a placement each, on the device.

use alloc::vec;
use alloc::vec::Vec;

use zerocopy::IntoBytes;

use super::error::GpuError;
use crate::math::norm;
use crate::placement::Placement;
use crate::pose::{Pose, checked_q, identity};
use crate::rounding::U32;
use crate::transform::Transform;
use crate::view::Asset;

/// Instances side by side in one block.
pub(crate) const BLOCK: usize = 8;
/// Rows of a block before those of q: a matrix of 3 × 4.
const MATRIX_ROWS: usize = 12;
/// Counts are exact in f32.
pub(crate) const CAPACITY_MAX: u32 = 1 << 24;
/// Nothing reaches farther, so that no f32 number overflows.
const FAR: f64 = (1_u128 << 120) as f64;

/// q and placements of many instances of one asset, in a buffer of the device.
///
/// Coordinates on the device are world coordinates relative to an origin, which
/// [`Instances::clear`] sets: near the camera f32 numbers suffice wherever in the world that is.
#[derive(Debug)]
pub struct Instances {
    pub(crate) group: wgpu::BindGroup,
    buffer: wgpu::Buffer,
    queue: wgpu::Queue,
    pub(crate) asset: (usize, u32),
    mode_count: usize,
    capacity: u32,
    count: u32,
    origin: [f64; 3],
    /// A row with the count, then blocks: of each matrix entry and mode the numbers of eight instances.
    rows: Vec<[f32; BLOCK]>,
}

impl Instances {
    /// Bytes of the buffer for so many instances.
    pub(crate) fn bytes(mode_count: usize, capacity: u32) -> u64 {
        let blocks = (capacity as usize).div_ceil(BLOCK) as u64;
        32 * (1 + blocks * (MATRIX_ROWS + mode_count) as u64)
    }

    pub(crate) fn new(
        asset: (usize, u32),
        mode_count: usize,
        capacity: u32,
        buffer: wgpu::Buffer,
        group: wgpu::BindGroup,
        queue: wgpu::Queue,
    ) -> Self {
        Self {
            group,
            buffer,
            queue,
            asset,
            mode_count,
            capacity,
            count: 0,
            origin: [0.0; 3],
            rows: vec![[0.0; BLOCK]],
        }
    }

    /// Forgets all instances. Those that follow are placed relative to `origin` (world units).
    pub fn clear(&mut self, origin: [f64; 3]) {
        self.count = 0;
        self.origin = origin;
        self.rows.truncate(1);
    }

    /// Number of instances.
    pub fn len(&self) -> u32 {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Number of instances that there is room for.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// What positions on the device are relative to (world units).
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The buffer that the shaders read.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Adds an instance of a pose. Returns how far any of its vertices on the device may be from
    /// [`Asset::deformed`] less the origin (world units; docs/skinning.md derives it).
    ///
    /// # Errors
    /// A pose of another asset; no room; farther from the origin than f32 numbers reach.
    pub fn push(&mut self, asset: &Asset<'_>, pose: &Pose<'_>) -> Result<f64, GpuError> {
        if !pose.belongs_to(asset) {
            return Err(GpuError::Mismatch("the pose was"));
        }
        let sum = pose.reach - f64::from(asset.header().position_norm_max.get());
        self.add(asset, &pose.placement, sum, pose.q.iter().copied())
    }

    /// Adds an instance without a pose, which costs less. Returns what [`Instances::push`] does.
    ///
    /// # Errors
    /// What [`Pose::new`] refuses of q and placement; those of [`Instances::push`].
    pub fn push_at(
        &mut self,
        asset: &Asset<'_>,
        q: &[f32],
        transform: Transform,
    ) -> Result<f64, GpuError> {
        let modes = asset.modes();
        if q.len() != modes.len() {
            return Err(crate::PoseError::ModeCount {
                expected: modes.len(),
                found: q.len(),
            }
            .into());
        }
        let mut sum = 0.0;
        for (mode, (q, record)) in q.iter().zip(modes).enumerate() {
            let q = checked_q(mode, *q, record)?;
            sum += f64::from(record.field_norm_max.get()) * f64::from(q.abs());
        }
        let frame = Placement::new(asset, &transform.checked()?);
        let flushed = |q: &f32| if q.abs() < f32::MIN_POSITIVE { 0.0 } else { *q };
        self.add(asset, &frame, sum, q.iter().map(flushed))
    }

    /// `sum` is S(q) = Σ `W_j` |q_j|.
    fn add(
        &mut self,
        asset: &Asset<'_>,
        frame: &Placement,
        sum: f64,
        q: impl Iterator<Item = f32>,
    ) -> Result<f64, GpuError> {
        if identity(asset) != self.asset {
            return Err(GpuError::Mismatch("the instances were"));
        }
        if self.count == self.capacity {
            return Err(GpuError::Full {
                capacity: self.capacity,
            });
        }
        let (linear, offset) = frame.matrix(self.origin);
        let p = f64::from(asset.header().position_norm_max.get());
        let per_stored = frame.world_per_stored();
        let away = norm(offset);
        // √3: the matrix of magnitudes.
        let reach = 2.0 * per_stored * (p + sum) + away;
        if !(reach <= FAR) {
            return Err(GpuError::TooFar {
                instance: self.count,
            });
        }
        let (block, lane) = (self.count as usize / BLOCK, self.count as usize % BLOCK);
        let stride = MATRIX_ROWS + self.mode_count;
        if lane == 0 {
            self.rows.resize(1 + (block + 1) * stride, [0.0; BLOCK]);
        }
        let (matrix, of_q) = self.rows[1 + block * stride..].split_at_mut(MATRIX_ROWS);
        for k in 0..3 {
            for axis in 0..3 {
                matrix[4 * k + axis][lane] = linear[k][axis] as f32;
            }
            matrix[4 * k + 3][lane] = offset[k] as f32;
        }
        for (row, q) in of_q.iter_mut().zip(q) {
            row[lane] = q;
        }
        self.count += 1;
        let m = self.mode_count as f64;
        let flushed = (m + 8.0) / (1_u128 << 125) as f64 * (1.0 + per_stored + p + sum);
        Ok(3.0 * U32 * per_stored * (p + (m + 2.0) * sum)
            + 16.0 * U32 * reach
            + frame.error(0.0, p + sum) * per_stored
            + flushed)
    }

    /// Row `row` of an instance as the shaders see it: twelve of its matrix, then q.
    pub(crate) fn row(&self, instance: u32, row: usize) -> f32 {
        let (block, lane) = (instance as usize / BLOCK, instance as usize % BLOCK);
        self.rows[1 + block * (MATRIX_ROWS + self.mode_count) + row][lane]
    }

    pub(crate) fn q(&self, instance: u32, mode: usize) -> f32 {
        self.row(instance, MATRIX_ROWS + mode)
    }

    /// Copies all instances to the device: before the next submission, as `queue.write_buffer` does.
    pub fn write(&mut self) {
        self.rows[0][0] = self.count as f32; // exact: see CAPACITY_MAX
        self.queue
            .write_buffer(&self.buffer, 0, self.rows.as_bytes());
    }
}
