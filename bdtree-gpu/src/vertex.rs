//! Skinning inside a vertex shader of the caller's.

use crate::asset::{GpuAsset, Normals};
use crate::device::checked;
use crate::error::GpuError;
use crate::instances::Instances;
use crate::layouts::{Access, layout};
use crate::skinner::Skinner;

/// WGSL that defines `bdtree_vertex(vertex: u32, instance: u32) -> BdtreeVertex`, with fields
/// `position` and `normal`, to be put before an engine's own shader; all its names begin with `bdtree_` or `Bdtree`. Bindings
/// 0 to 7 of bind group `group` are its own. Normals are from fields alone, also at marked vertices.
///
/// # Errors
/// [`Normals::Exact`], which no vertex shader can compute from one vertex.
pub fn vertex_source(asset: &GpuAsset, group: u32) -> Result<String, GpuError> {
    let sums = match asset.listed {
        true => include_str!("shaders/vertex_listed.wgsl"),
        false => include_str!("shaders/vertex_all.wgsl"),
    };
    let sum = |name: &str, sides: &str, fields: &str, lists: &str| {
        sums.replace("NAME", name)
            .replace("SIDES", sides)
            .replace("FIELDS", fields)
            .replace("LISTS", lists)
    };
    let group = format!("{group}u");
    let head = include_str!("shaders/vertex.wgsl").replace("BDTREE_GROUP", &group);
    let moved = sum("moved_by", "1u", "bdtree_fields", "bdtree_lists");
    let (bones, spanned) = match asset.has_skin() {
        true => (
            include_str!("shaders/vertex_bones.wgsl"),
            "cross(bdtree_unit(bdtree_along(a)), bdtree_unit(bdtree_along(b)))",
        ),
        false => (include_str!("shaders/vertex_no_bones.wgsl"), "cross(a, b)"),
    };
    let points = include_str!("shaders/vertex_points.wgsl");
    let normals = match asset.normals() {
        Normals::None => include_str!("shaders/vertex_no_normals.wgsl").into(),
        Normals::Fields => {
            let fields = "bdtree_tangent_fields";
            sum("turned_by", "2u", fields, "bdtree_tangent_lists")
                + &include_str!("shaders/vertex_normals.wgsl").replace("BDTREE_SPANNED", spanned)
        }
        Normals::Exact => return Err(exact()),
    };
    Ok(format!("{head}\n{moved}\n{bones}\n{points}\n{normals}\n"))
}

/// The layout of the bind group that [`vertex_source`] declares, for a pipeline layout; visible to
/// vertex and compute shaders.
pub fn vertex_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let mut accesses = [Access::Read; 8];
    accesses[0] = Access::Uniform;
    let stages = wgpu::ShaderStages::VERTEX | wgpu::ShaderStages::COMPUTE;
    layout(device, stages, &accesses)
}

impl Skinner {
    /// The bind group of an asset and its instances, of the layout `layout` that [`vertex_layout`]
    /// made. It stays valid when the instances change.
    ///
    /// # Errors
    /// Instances of another asset; [`Normals::Exact`]; an asset that had to be split, since a vertex
    /// shader sees all of it at once; what the device refuses.
    pub fn vertex_group(
        &self,
        layout: &wgpu::BindGroupLayout,
        asset: &GpuAsset,
        instances: &Instances,
    ) -> Result<wgpu::BindGroup, GpuError> {
        if instances.asset != asset.asset {
            return Err(GpuError::Mismatch("the instances were"));
        }
        let [points] = &asset.points[..] else {
            return Err(GpuError::Unsupported(
                "the asset is split into ranges of vertices: a vertex shader needs it whole",
            ));
        };
        let [numbers, rest, fields, lists] = &points.buffers;
        let [tangents, tangent_fields, tangent_lists] = match (&asset.tangents[..], asset.normals())
        {
            ([range], _) => [&range.buffers[1], &range.buffers[2], &range.buffers[3]],
            // Not read.
            (_, Normals::None) => [rest, fields, lists],
            (_, Normals::Exact) => return Err(exact()),
            _ => {
                return Err(GpuError::Unsupported(
                    "the normal fields are split into ranges of vertices: a vertex shader needs them whole",
                ));
            }
        };
        let positions = [numbers, rest, fields, lists];
        let normals = [tangents, tangent_fields, tangent_lists];
        let buffers = [&positions[..], &normals, &[instances.buffer()]].concat();
        checked(&self.device, || Ok(self.bind(layout, &buffers)))
    }
}

fn exact() -> GpuError {
    GpuError::Unsupported("exact normals need the positions around a vertex: use compute passes")
}
