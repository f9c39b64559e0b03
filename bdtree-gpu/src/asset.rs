//! An asset on the device.

use bdtree_runtime::{Asset, AssetId};
use zerocopy::IntoBytes;

use crate::device::checked;
use crate::error::GpuError;
use crate::influences::Influences;
use crate::normal_fields::NormalFields;
use crate::ranges::{BoundRange, FieldSet};
use crate::skinner::Skinner;
use crate::vertex_triangles::{VertexTriangles, triangles};

/// Where the normals of a deformed mesh come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Normals {
    /// There are none.
    None,
    /// Two tangents per vertex that move with q like positions do ([`NormalFields`]): near the exact ones
    /// where the triangles around a vertex deform alike. Vertices where they are not are found at upload, and
    /// compute passes do as `Exact` does there (figures: docs/reference/gpu-deformation.md). Computed here, 24 bytes per vertex and
    /// mode. Bones carry the tangents as they carry their vertex, its weights taken for those of all around it.
    Fields,
    /// The triangles around each vertex as deformed, weighted by area: what a mesh's normals are
    /// without tricks, from the positions that were written, so in compute passes only.
    Exact,
}

/// An asset on the device: rest positions, displacements, triangles, and what its normals need.
#[derive(Debug)]
pub struct GpuAsset {
    pub(crate) asset: AssetId,
    pub(crate) listed: bool,
    pub(crate) points: Vec<BoundRange>,
    /// Of [`Normals::Fields`].
    pub(crate) tangents: Vec<BoundRange>,
    /// Of [`Normals::Exact`], and of the vertices that [`Normals::Fields`] marks.
    pub(crate) exact: Vec<BoundRange>,
    indices: wgpu::Buffer,
    vertex_count: u32,
    triangle_count: u32,
    mode_count: usize,
    /// Where bones carry the vertices.
    bone_count: Option<usize>,
    normals: Normals,
}

impl GpuAsset {
    pub(crate) fn new(
        skinner: &Skinner,
        asset: &Asset<'_>,
        normals: Normals,
    ) -> Result<Self, GpuError> {
        asset.check_mesh()?;
        let set = field_set(asset);
        let skin = Influences::of(asset);
        let triangles = triangles(asset)?;
        let fields = match normals {
            Normals::Fields => Some(NormalFields::new(asset)?),
            _ => None,
        };
        let of_all = match normals {
            Normals::Exact => Some(VertexTriangles::new(asset.vertex_count(), &triangles)?),
            _ => None,
        };
        checked(&skinner.device, || {
            let usage = wgpu::BufferUsages::INDEX
                | wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_SRC;
            let indices = skinner.filled("triangles", usage, &[triangles.as_bytes()])?;
            let (mut tangents, mut exact) = (Vec::new(), Vec::new());
            if let Some(fields) = &fields {
                tangents = fields
                    .set()
                    .upload(skinner, "normal fields", skin.as_ref())?;
            }
            let marked = fields.as_ref().map(NormalFields::marked_triangles);
            if let Some(around) = of_all.as_ref().or(marked) {
                exact = around.upload(skinner, set.mode_count)?;
            }
            Ok(Self {
                asset: asset.id(),
                listed: set.listed(),
                points: set.upload(skinner, "displacements", skin.as_ref())?,
                tangents,
                exact,
                indices,
                vertex_count: asset.vertex_count() as u32,
                triangle_count: asset.triangle_count() as u32,
                mode_count: set.mode_count,
                bone_count: skin.map(|skin| skin.bone_count),
                normals,
            })
        })
    }

    /// Three vertex indices (u32) per triangle, in the order of triangle ids, so that a
    /// [`bdtree_runtime::Group`] is a run of indices.
    pub fn indices(&self) -> &wgpu::Buffer {
        &self.indices
    }

    /// Number of vertices N of each instance.
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Number of triangles F.
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// Number of modes M.
    pub fn mode_count(&self) -> usize {
        self.mode_count
    }

    /// Number of bones; 0 without a skin.
    pub fn bone_count(&self) -> usize {
        self.bone_count.unwrap_or(0)
    }

    /// Whether bones carry the vertices.
    pub fn has_skin(&self) -> bool {
        self.bone_count.is_some()
    }

    /// Into how many ranges of vertices the device's limits split the largest of its buffers: a dispatch
    /// each.
    pub fn range_count(&self) -> usize {
        let others = self.tangents.len().max(self.exact.len());
        self.points.len().max(others)
    }

    /// Bytes of its buffers on the device.
    pub fn bytes(&self) -> u64 {
        let ranges = [&self.points, &self.tangents, &self.exact];
        let buffers = ranges.into_iter().flatten().flat_map(|r| &r.buffers);
        self.indices.size() + buffers.map(wgpu::Buffer::size).sum::<u64>()
    }

    /// Where its normals come from.
    pub fn normals(&self) -> Normals {
        self.normals
    }
}

/// Positions and displacements as they lie in the file. Shaders follow its records, so
/// [`Asset::check_mesh`] comes first.
pub(crate) fn field_set<'a>(asset: &Asset<'a>) -> FieldSet<'a> {
    FieldSet {
        mode_count: asset.mode_count(),
        sides: 1,
        rest: asset.positions(),
        fields: asset.displacement_fields(),
        records: asset.vertex_modes(),
        lists: asset.mode_list_entries(),
    }
}
