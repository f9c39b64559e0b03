//! What the shaders compute, on the processor: the same operations in the same order. A device may round and
//! fuse otherwise, so results agree within bounds (docs/skinning.md), not to the bit.

use alloc::vec::Vec;

use super::asset::field_set;
use super::error::GpuError;
use super::instances::Instances;
use super::normal_fields::NormalFields;
use super::ranges::FieldSet;
use super::ring::{Ring, triangles};
use crate::math::sqrt_f32;
use crate::view::Asset;

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
    let set = field_set(asset)?;
    let one = |vertex| {
        let p = moved(&set, instances, instance, vertex, 0);
        let x = turned(instances, instance, p);
        [0, 1, 2].map(|k| x[k] + instances.row(instance, 4 * k + 3))
    };
    Ok((0..set.rest.len()).map(one).collect())
}

/// Normals of all vertices of an instance as compute passes of [`Normals::Fields`](super::Normals::Fields) leave
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
    let ring = fields.marked_ring();
    for (place, vertex) in ring.vertices.iter().enumerate() {
        let vertex = *vertex as usize;
        all[vertex] = exact(positions, positions[vertex], ring.around(place));
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
    let set = fields.set();
    if set.rest.len() != 2 * asset.vertex_count() || set.mode_count != asset.mode_count() {
        return Err(GpuError::Mismatch("the normal fields were"));
    }
    let one = |vertex| {
        let [a, b] = [0, 1].map(|side| moved(&set, instances, instance, vertex, side));
        normalized(turned(instances, instance, cross(a, b)))
    };
    Ok((0..asset.vertex_count()).map(one).collect())
}

/// Normals of the triangles around each vertex, weighted by area, as `exact.wgsl` computes them from
/// positions.
///
/// # Errors
/// Records that break the format's rules; fewer positions than the asset has vertices.
pub fn exact_normals(asset: &Asset<'_>, positions: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, GpuError> {
    let n = asset.vertex_count();
    if positions.len() < n {
        return Err(GpuError::Mismatch("the positions were"));
    }
    let ring = Ring::new(n, &triangles(asset)?)?;
    let one = |vertex: usize| exact(positions, positions[vertex], ring.around(vertex));
    Ok((0..n).map(one).collect())
}

/// The normal at p of the triangles around it.
fn exact(positions: &[[f32; 3]], p: [f32; 3], around: &[[u32; 2]]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for others in around {
        let [e, f] = others.map(|v| {
            let x = positions[v as usize];
            [x[0] - p[0], x[1] - p[1], x[2] - p[2]]
        });
        let area = cross(e, f);
        for k in 0..3 {
            sum[k] += area[k];
        }
    }
    normalized(sum)
}

fn check(asset: &Asset<'_>, instances: &Instances, instance: u32) -> Result<(), GpuError> {
    if instances.asset != crate::pose::identity(asset) {
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
) -> [f32; 3] {
    let mut sum = [0.0_f32; 3];
    for (mode, u) in set.of(vertex, side) {
        for k in 0..3 {
            sum[k] += u[k] * instances.q(instance, mode);
        }
    }
    let rest = set.rest[set.sides * vertex + side];
    [rest[0] + sum[0], rest[1] + sum[1], rest[2] + sum[2]]
}

fn turned(instances: &Instances, instance: u32, v: [f32; 3]) -> [f32; 3] {
    [0, 4, 8].map(|row| {
        let [a, b, c] = [0, 1, 2].map(|k| instances.row(instance, row + k));
        (a * v[0] + b * v[1]) + c * v[2]
    })
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `unit_factors` of common.wgsl.
fn normalized(v: [f32; 3]) -> [f32; 3] {
    const LARGEST: f32 = (1_u128 << 125) as f32;
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    if !(f32::MIN_POSITIVE..=LARGEST).contains(&largest) {
        return [0.0; 3];
    }
    let scale = 1.0 / largest;
    let [x, y, z] = v.map(|x| x * scale);
    let unit = 1.0 / sqrt_f32(x * x + y * y + z * z);
    [x * unit, y * unit, z * unit]
}
