//! Instances: q and a placement each, on the device.

use bdtree_runtime::{Asset, AssetId, Pose, StoredToWorld, Transform};
use glam::DVec3;
use zerocopy::IntoBytes;

use crate::error::GpuError;

/// Instances side by side in one block.
pub(crate) const BLOCK: usize = 8;
/// Rows of a block before those of q: a matrix of 3 × 4.
const MATRIX_ROWS: usize = 12;
/// Counts are exact in f32.
pub(crate) const CAPACITY_MAX: u32 = 1 << 24;
/// Unit roundoff of f32.
const U32: f64 = 1.0 / (1_u64 << 24) as f64;
/// Nothing reaches farther, so that no f32 number overflows.
const FAR: f64 = (1_u128 << 120) as f64;

/// q and placements of many instances of one asset, in a buffer of the device.
///
/// Coordinates on the device are world coordinates relative to an origin, which
/// [`Instances::clear`] sets: near the camera f32 numbers suffice wherever in the world that is.
#[derive(Debug)]
pub struct Instances {
    pub(crate) group: wgpu::BindGroup,
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) queue: wgpu::Queue,
    pub(crate) asset: AssetId,
    pub(crate) mode_count: usize,
    pub(crate) capacity: u32,
    pub(crate) count: u32,
    pub(crate) origin: [f64; 3],
    /// A row with the count, then blocks: of each matrix entry and mode the numbers of eight instances.
    pub(crate) rows: Vec<[f32; BLOCK]>,
}

impl Instances {
    /// Bytes of the buffer for so many instances.
    pub(crate) fn bytes(mode_count: usize, capacity: u32) -> u64 {
        let blocks = (capacity as usize).div_ceil(BLOCK) as u64;
        32 * (1 + blocks * (MATRIX_ROWS + mode_count) as u64)
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
    /// [`Pose::deformed`] less the origin (world units; docs/reference/gpu-deformation.md derives it).
    ///
    /// # Errors
    /// A pose of another asset; no room; farther from the origin than f32 numbers reach.
    pub fn push(&mut self, pose: &Pose<'_>) -> Result<f64, GpuError> {
        self.add(pose.asset(), &pose.stored_to_world(), pose.q())
    }

    /// Adds an instance without a pose, which costs less. Returns what [`Instances::push`] does.
    ///
    /// # Errors
    /// What [`Asset::pose`] refuses of q and placement; those of [`Instances::push`].
    pub fn push_at(
        &mut self,
        asset: &Asset<'_>,
        q: &[f32],
        transform: Transform,
    ) -> Result<f64, GpuError> {
        asset.check_q(q)?;
        self.add(asset, &asset.stored_to_world(transform)?, q)
    }

    /// `q` is one that [`Asset::check_q`] passes.
    fn add(&mut self, asset: &Asset<'_>, map: &StoredToWorld, q: &[f32]) -> Result<f64, GpuError> {
        if asset.id() != self.asset {
            return Err(GpuError::Mismatch("the instances were"));
        }
        if self.count == self.capacity {
            return Err(GpuError::Full {
                capacity: self.capacity,
            });
        }
        let linear = map.linear();
        let offset = DVec3::from_array(map.offset()) - DVec3::from_array(self.origin);
        // Subnormal entries are 0, as in a pose.
        let q = q
            .iter()
            .map(|q| if q.abs() < f32::MIN_POSITIVE { 0.0 } else { *q });
        // S(q) = Σ W_j |q_j|.
        let modes = asset.modes().iter();
        let weighted = modes
            .zip(q.clone())
            .map(|(m, q)| f64::from(m.field_norm_max.get()) * f64::from(q.abs()));
        let sum: f64 = weighted.sum();
        let p = f64::from(asset.header().position_norm_max.get());
        let per_stored = map.scale();
        let away = offset.length();
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
            + map.error(p + sum)
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
