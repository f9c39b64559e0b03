//! The surface of a body, for contacts that thin parts need: its triangles, exactly deformed.

use alloc::vec::Vec;

use bdtree_runtime::{
    CacheSize, FormatError, Instance, Model, Ray, RayIntersection, TriangleId, VertexId, Workspace,
};
use nalgebra::{UnitQuaternion, Vector3};

use crate::error::DynamicsError;

/// Triangles of a body in its frame, world units.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    model: Model,
    scale: f64,
    center: Vector3<f64>,
    to_axes: UnitQuaternion<f64>,
    modes: usize,
    stride: usize,
    /// Of each mode, padded: what a unit of q moves any vertex by at most.
    norms: Vec<f64>,
    /// Largest distance of a vertex from the center of mass at rest.
    pub(crate) extent: f64,
}

/// The corners of a triangle, of the mesh: rest positions, and how far a unit of q of each mode moves them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Corners {
    rest: [Vector3<f64>; 3],
    fields: [Vec<[f64; 3]>; 3],
}

impl Surface {
    /// # Errors
    /// A damaged asset.
    pub(crate) fn new(
        model: &Model,
        scale: f64,
        center: Vector3<f64>,
        axes: UnitQuaternion<f64>,
        [modes, stride]: [usize; 2],
    ) -> Result<Self, FormatError> {
        let asset = model.asset();
        let records = asset.modes().iter().take(modes);
        let mut norms: Vec<f64> = records
            .map(|mode| f64::from(mode.field_norm_max.get()) * asset.unit() * scale * (1.0 + 1e-6))
            .collect();
        norms.resize(stride, 0.0);
        let mut extent = 0.0_f64;
        let mut fields = alloc::vec![[0.0; 3]; asset.mode_count()];
        for vertex in 0..asset.vertex_count() {
            let rest = asset.rest_vertex(VertexId(vertex as u32), &mut fields)?;
            extent = extent.max((Vector3::from(rest) - center).norm() * scale);
        }
        Ok(Self {
            model: model.clone(),
            scale,
            center,
            to_axes: axes.inverse(),
            modes,
            stride,
            norms,
            extent: extent * (1.0 + 1e-9),
        })
    }

    /// How far vertices move at most when q changes by `change`.
    pub(crate) fn moved(&self, change: &[f64]) -> f64 {
        let each = self.norms.iter().zip(change);
        each.map(|(norm, change)| norm * change.abs()).sum()
    }

    /// No vertex is farther from its place at rest for any q of length `size`.
    pub(crate) fn moved_within(&self, size: f64) -> f64 {
        let squared: f64 = self.norms.iter().map(|norm| norm * norm).sum();
        libm::sqrt(squared) * size
    }

    /// # Errors
    /// A damaged asset, a triangle that it does not have.
    pub(crate) fn corners(
        &self,
        triangle: TriangleId,
        corners: &mut Corners,
    ) -> Result<(), FormatError> {
        let asset = self.model.asset();
        let all = asset.triangle(triangle)?;
        for ((vertex, rest), fields) in
            (all.into_iter().zip(&mut corners.rest)).zip(&mut corners.fields)
        {
            fields.resize(asset.mode_count(), [0.0; 3]);
            *rest = Vector3::from(asset.rest_vertex(vertex, fields)?);
        }
        Ok(())
    }

    /// The corners in the body's frame at q.
    pub(crate) fn at(&self, corners: &Corners, q: &[f64]) -> [Vector3<f64>; 3] {
        let place = |k: usize| {
            let mut at = corners.rest[k] - self.center;
            for (field, q) in corners.fields[k][..self.modes].iter().zip(q) {
                at += Vector3::from(*field) * *q;
            }
            self.to_axes * (at * self.scale)
        };
        [place(0), place(1), place(2)]
    }

    /// Appends U of the point with these weights of the corners.
    pub(crate) fn field(&self, corners: &Corners, weights: [f64; 3], out: &mut Vec<f64>) {
        let start = out.len();
        out.resize(start + 3 * self.stride, 0.0);
        for mode in 0..self.modes {
            let mut sum = Vector3::zeros();
            for (fields, weight) in corners.fields.iter().zip(weights) {
                sum += Vector3::from(fields[mode]) * weight;
            }
            let own = self.to_axes * (sum * self.scale);
            for axis in 0..3 {
                out[start + axis * self.stride + mode] = own[axis];
            }
        }
    }
}

/// The shortest way from the middle of any triangle straight inwards to the surface behind it, at rest, mesh units.
///
/// # Errors
/// A triangle that has nothing behind it, or something at no distance; a damaged asset.
pub(crate) fn thinnest_wall(model: &Model) -> Result<f64, DynamicsError> {
    let asset = model.asset();
    let instance = Instance::with_cache(model, CacheSize::NONE)?;
    let pose = instance.pose();
    let mut workspace = Workspace::new();
    let mut unused = alloc::vec![[0.0; 3]; asset.mode_count()];
    let mut hits: Vec<RayIntersection> = Vec::new();
    let mut thinnest = f64::INFINITY;
    for triangle in 0..asset.triangle_count() {
        let mut corners = [Vector3::zeros(); 3];
        let vertices = asset.triangle(TriangleId(triangle as u32))?;
        for (corner, vertex) in corners.iter_mut().zip(vertices) {
            *corner = Vector3::from(asset.rest_vertex(vertex, &mut unused)?);
        }
        let [a, b, c] = corners;
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
            continue; // without area it has no inside
        };
        let middle: [f64; 3] = ((a + b + c) / 3.0).into();
        let inwards: [f64; 3] = (-normal).into();
        hits.clear();
        pose.query(&mut workspace)
            .cast_ray_all(&Ray::new(middle, inwards), &mut hits)?;
        let others = hits
            .iter()
            .filter(|hit| hit.triangle.0 as usize != triangle);
        let behind = others.map(|hit| hit.distance).fold(f64::INFINITY, f64::min);
        if !(behind > 0.0 && behind.is_finite()) {
            return Err(DynamicsError::NoInside { triangle });
        }
        thinnest = thinnest.min(behind);
    }
    Ok(thinnest)
}
