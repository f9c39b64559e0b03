//! What the shaders compute, on the processor: the same operations in the same order. A device may round and
//! fuse otherwise, so results agree within bounds (docs/reference/gpu-deformation.md), not to the bit.

use bdtree_runtime::{Asset, VertexId};
use glam::Vec3;

use crate::asset::field_set;
use crate::error::GpuError;
use crate::instances::Instances;
use crate::normal_fields::NormalFields;
use crate::ranges::FieldSet;
use crate::vertex_triangles::{VertexTriangles, triangles};

/// Positions of all vertices of an instance, as `skin.wgsl` and `vertex.wgsl` compute them.
///
/// # Errors
/// Records that break the format's rules; no such instance, or one of another asset.
pub fn positions(
    asset: &Asset<'_>,
    instances: &Instances,
    instance: u32,
) -> Result<Vec<[f32; 3]>, GpuError> {
    check(asset, instances, instance)?;
    asset.check_mesh()?;
    let set = field_set(asset);
    let one = |vertex| {
        let p = moved(&set, instances, instance, vertex, 0);
        let p = match blended(asset, instances, instance, vertex)? {
            Some(m) => along(&m, p) + Vec3::from_array(m.map(|row| row[3])),
            None => p,
        };
        let offset = Vec3::from_array([3, 7, 11].map(|row| instances.row(instance, row)));
        Ok((turned(instances, instance, p) + offset).to_array())
    };
    (0..set.rest.len()).map(one).collect()
}

/// Normals of all vertices of an instance as compute passes of [`Normals::Fields`](crate::Normals::Fields) leave
/// them: from fields, but of marked vertices from `positions`, those of the instance.
///
/// # Errors
/// Those of [`field_normals`] and [`exact_normals`].
pub fn normals(
    asset: &Asset<'_>,
    fields: &NormalFields,
    instances: &Instances,
    instance: u32,
    positions: &[[f32; 3]],
) -> Result<Vec<[f32; 3]>, GpuError> {
    let mut all = field_normals(asset, fields, instances, instance)?;
    if positions.len() < asset.vertex_count() {
        return Err(GpuError::Mismatch("the positions were"));
    }
    let marked = fields.marked_triangles();
    for (place, vertex) in marked.vertices.iter().enumerate() {
        let vertex = *vertex as usize;
        all[vertex] = exact(positions, positions[vertex], marked.around(place));
    }
    Ok(all)
}

/// Normals of all vertices of an instance from fields alone, as `finish_normals.wgsl` and
/// `vertex_normals.wgsl` compute them.
///
/// # Errors
/// No such instance, or one of another asset.
pub fn field_normals(
    asset: &Asset<'_>,
    fields: &NormalFields,
    instances: &Instances,
    instance: u32,
) -> Result<Vec<[f32; 3]>, GpuError> {
    check(asset, instances, instance)?;
    if asset.has_skin() {
        asset.check_mesh()?;
    }
    let set = fields.set();
    if set.rest.len() != 2 * asset.vertex_count() || set.mode_count != asset.mode_count() {
        return Err(GpuError::Mismatch("the normal fields were"));
    }
    let one = |vertex| {
        let [mut a, mut b] = [0, 1].map(|side| moved(&set, instances, instance, vertex, side));
        if let Some(m) = blended(asset, instances, instance, vertex)? {
            [a, b] = [a, b].map(|side| Vec3::from_array(normalized(along(&m, side))));
        }
        Ok(normalized(turned(instances, instance, a.cross(b))))
    };
    (0..asset.vertex_count()).map(one).collect()
}

/// Normals of the triangles around each vertex, weighted by area, as `exact.wgsl` computes them from
/// positions.
///
/// # Errors
/// Records that break the format's rules; fewer positions than the asset has vertices.
pub fn exact_normals(asset: &Asset<'_>, positions: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, GpuError> {
    asset.check_mesh()?;
    let n = asset.vertex_count();
    if positions.len() < n {
        return Err(GpuError::Mismatch("the positions were"));
    }
    let of_all = VertexTriangles::new(n, &triangles(asset)?)?;
    let one = |vertex: usize| exact(positions, positions[vertex], of_all.around(vertex));
    Ok((0..n).map(one).collect())
}

/// The normal at p of the triangles around it.
fn exact(positions: &[[f32; 3]], p: [f32; 3], around: &[[u32; 2]]) -> [f32; 3] {
    let sum = around.iter().fold(Vec3::ZERO, |sum, others| {
        let [e, f] = others.map(|v| Vec3::from_array(positions[v as usize]) - Vec3::from_array(p));
        sum + e.cross(f)
    });
    normalized(sum)
}

fn check(asset: &Asset<'_>, instances: &Instances, instance: u32) -> Result<(), GpuError> {
    if instances.asset != asset.id() {
        return Err(GpuError::Mismatch("the instances were"));
    }
    if instance >= instances.len() {
        return Err(GpuError::Unsupported("there is no instance of that number"));
    }
    Ok(())
}

/// A vector of a vertex and what the modes add to it.
fn moved(
    set: &FieldSet<'_>,
    instances: &Instances,
    instance: u32,
    vertex: usize,
    side: usize,
) -> Vec3 {
    let fields = set.of(vertex, side);
    let sum = fields.fold(Vec3::ZERO, |sum, (mode, u)| {
        sum + Vec3::from_array(u) * instances.q(instance, mode)
    });
    Vec3::from_array(set.rest[set.sides * vertex + side]) + sum
}

/// M of a vertex, if bones carry it.
fn blended(
    asset: &Asset<'_>,
    instances: &Instances,
    instance: u32,
    vertex: usize,
) -> Result<Option<[[f32; 4]; 3]>, GpuError> {
    if !asset.has_skin() {
        return Ok(None);
    }
    let mut m = [[0.0; 4]; 3];
    for influence in asset.influences(VertexId(vertex as u32))? {
        for (r, row) in m.iter_mut().enumerate() {
            let own = instances.bone_row(instance, usize::from(influence.bone), r);
            for (sum, own) in row.iter_mut().zip(own) {
                *sum += influence.weight * own;
            }
        }
    }
    Ok(Some(m))
}

/// M's linear part times a vector.
fn along(m: &[[f32; 4]; 3], v: Vec3) -> Vec3 {
    Vec3::from_array(m.map(|[x, y, z, _]| Vec3::new(x, y, z).dot(v)))
}

fn turned(instances: &Instances, instance: u32, v: Vec3) -> Vec3 {
    let row = |first: usize| [0, 1, 2].map(|k| instances.row(instance, first + k));
    Vec3::from_array([0, 4, 8].map(|first| Vec3::from_array(row(first)).dot(v)))
}

/// `unit_factors` of common.wgsl.
fn normalized(v: Vec3) -> [f32; 3] {
    const LARGEST: f32 = (1_u128 << 125) as f32;
    let [x, y, z] = v.abs().to_array();
    let largest = x.max(y).max(z);
    if !(f32::MIN_POSITIVE..=LARGEST).contains(&largest) {
        return [0.0; 3];
    }
    let scaled = v * (1.0 / largest);
    (scaled * (1.0 / scaled.length())).to_array()
}
