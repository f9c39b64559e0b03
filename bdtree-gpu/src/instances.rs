//! Instances: q and a placement each, on the device.

use bdtree_runtime::{Asset, AssetId, BoneMap, BoneMatrices, Pose, StoredToWorld, Transform};
use glam::DVec3;
use zerocopy::IntoBytes;

use crate::bound::Reach;
use crate::error::GpuError;

/// Instances side by side in one block.
pub(crate) const BLOCK: usize = 8;
/// Rows of a block before those of q: a matrix of 3 × 4.
const MATRIX_ROWS: usize = 12;
/// Counts are exact in f32.
pub(crate) const CAPACITY_MAX: u32 = 1 << 24;
/// Rows of each bone behind those of q: its map, 3 × 4.
const BONE_ROWS: usize = 12;
/// Nothing reaches farther, so that no f32 number overflows.
const FAR: f64 = (1_u128 << 120) as f64;

/// The rows of a block of instances.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowLayout {
    pub(crate) mode_count: usize,
    pub(crate) bone_count: usize,
}

impl RowLayout {
    pub(crate) fn rows(self) -> usize {
        MATRIX_ROWS + self.mode_count + BONE_ROWS * self.bone_count
    }

    /// Bytes of the buffer for so many instances.
    pub(crate) fn bytes(self, capacity: u32) -> u64 {
        let blocks = (capacity as usize).div_ceil(BLOCK) as u64;
        32 * (1 + blocks * self.rows() as u64)
    }
}

/// q, bones and placements of many instances of one asset, in a buffer of the device.
///
/// Coordinates on the device are world coordinates relative to an origin, which
/// [`Instances::clear`] sets: near the camera f32 numbers suffice wherever in the world that is.
#[derive(Debug)]
pub struct Instances {
    pub(crate) group: wgpu::BindGroup,
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) queue: wgpu::Queue,
    pub(crate) asset: AssetId,
    pub(crate) layout: RowLayout,
    pub(crate) capacity: u32,
    pub(crate) count: u32,
    pub(crate) origin: [f64; 3],
    /// A row with the count, then blocks: of each matrix entry, mode and entry of a bone's map the numbers of eight
    /// instances.
    pub(crate) rows: Vec<[f32; BLOCK]>,
    /// Of the pose of a skinned instance that is added without one.
    pub(crate) memory: Vec<f32>,
}

impl Instances {
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
        let map = pose.stored_to_world();
        self.add(pose.asset(), &map, pose.q(), pose.bone_maps())
    }

    /// Adds an instance without a pose, its bones at rest; without a skin that costs less. Returns what
    /// [`Instances::push`] does.
    ///
    /// # Errors
    /// What [`Asset::pose`] refuses of q and placement; those of [`Instances::push`].
    pub fn push_at(
        &mut self,
        asset: &Asset<'_>,
        q: &[f32],
        transform: Transform,
    ) -> Result<f64, GpuError> {
        self.push_with_bones(asset, q, BoneMatrices::Rest, transform)
    }

    /// Adds an instance without a pose, its bones where `bones` puts them. Returns what [`Instances::push`] does.
    ///
    /// # Errors
    /// What [`Asset::pose_with_bones`] refuses; those of [`Instances::push`].
    pub fn push_with_bones(
        &mut self,
        asset: &Asset<'_>,
        q: &[f32],
        bones: BoneMatrices<'_>,
        transform: Transform,
    ) -> Result<f64, GpuError> {
        if let (false, BoneMatrices::Rest) = (asset.has_skin(), bones) {
            asset.check_q(q)?;
            return self.add(asset, &asset.stored_to_world(transform)?, q, &[]);
        }
        let mut memory = std::mem::take(&mut self.memory);
        memory.resize(asset.pose_len(), 0.0);
        let pushed = match asset.pose_with_bones(q, bones, transform, &mut memory) {
            Ok(pose) => self.push(&pose),
            Err(error) => Err(error.into()),
        };
        self.memory = memory;
        pushed
    }

    /// `q` is one that [`Asset::check_q`] passes, `bones` are a pose's.
    fn add(
        &mut self,
        asset: &Asset<'_>,
        map: &StoredToWorld,
        q: &[f32],
        bones: &[BoneMap],
    ) -> Result<f64, GpuError> {
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
        let reach = Reach::of(asset, q, bones);
        let (per_stored, away) = (map.scale(), offset.length());
        // √3: the matrix of magnitudes.
        if !(2.0 * per_stored * reach.carried() + away <= FAR) {
            return Err(GpuError::TooFar {
                instance: self.count,
            });
        }
        let (block, lane) = (self.count as usize / BLOCK, self.count as usize % BLOCK);
        let stride = self.layout.rows();
        if lane == 0 {
            self.rows.resize(1 + (block + 1) * stride, [0.0; BLOCK]);
        }
        let (matrix, rest) = self.rows[1 + block * stride..].split_at_mut(MATRIX_ROWS);
        for k in 0..3 {
            for axis in 0..3 {
                matrix[4 * k + axis][lane] = linear[k][axis] as f32;
            }
            matrix[4 * k + 3][lane] = offset[k] as f32;
        }
        let (of_q, of_bones) = rest.split_at_mut(self.layout.mode_count);
        for (row, q) in of_q.iter_mut().zip(q) {
            // Subnormal entries are 0, as in a pose.
            row[lane] = if q.abs() < f32::MIN_POSITIVE { 0.0 } else { *q };
        }
        let entries = bones.iter().flat_map(|bone| bone.rows().as_flattened());
        for (row, entry) in of_bones.iter_mut().zip(entries) {
            row[lane] = *entry;
        }
        self.count += 1;
        Ok(reach.error(map, away))
    }

    /// Row `row` of an instance as the shaders see it: twelve of its matrix, then q, then twelve of each bone.
    pub(crate) fn row(&self, instance: u32, row: usize) -> f32 {
        let (block, lane) = (instance as usize / BLOCK, instance as usize % BLOCK);
        self.rows[1 + block * self.layout.rows() + row][lane]
    }

    pub(crate) fn q(&self, instance: u32, mode: usize) -> f32 {
        self.row(instance, MATRIX_ROWS + mode)
    }

    /// Row r of a bone's map.
    pub(crate) fn bone_row(&self, instance: u32, bone: usize, r: usize) -> [f32; 4] {
        let first = MATRIX_ROWS + self.layout.mode_count + BONE_ROWS * bone + 4 * r;
        [0, 1, 2, 3].map(|c| self.row(instance, first + c))
    }

    /// Copies all instances to the device: before the next submission, as `queue.write_buffer` does.
    pub fn write(&mut self) {
        self.rows[0][0] = self.count as f32; // exact: see CAPACITY_MAX
        self.queue
            .write_buffer(&self.buffer, 0, self.rows.as_bytes());
    }
}
