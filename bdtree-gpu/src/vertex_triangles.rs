//! The triangles around each vertex.

use bdtree_runtime::{Asset, TriangleId};

use crate::error::GpuError;

/// Corners of all triangles by id, of an asset that [`Asset::check_mesh`] has passed.
pub(crate) fn triangles(asset: &Asset<'_>) -> Result<Vec<[u32; 3]>, GpuError> {
    let one = |id| Ok(asset.triangle(TriangleId(id))?.map(|v| v.0));
    (0..asset.triangle_count() as u32).map(one).collect()
}

/// Of each vertex the triangles that have it as a corner, by id; those that have a corner twice are
/// left out, as they have no area.
#[derive(Debug)]
pub(crate) struct VertexTriangles {
    /// Of the mesh.
    pub(crate) vertex_count: usize,
    /// Which vertices these are of; empty where of all, in their order.
    pub(crate) vertices: Vec<u32>,
    /// Where each vertex's begin in `corners`, and one more.
    pub(crate) starts: Vec<u32>,
    /// The two other corners of each, in the triangle's order.
    pub(crate) corners: Vec<[u32; 2]>,
}

impl VertexTriangles {
    pub(crate) fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self, GpuError> {
        let bytes = 24 * triangles.len() as u64;
        let limit = 8 * u64::from(u32::MAX / 2);
        if bytes > limit {
            let what = "triangles around vertices";
            return Err(GpuError::AssetTooLarge { what, bytes, limit });
        }
        let flat = |[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
        let mut starts = vec![0_u32; vertex_count + 1];
        for triangle in triangles.iter().filter(|t| !flat(t)) {
            for v in triangle {
                starts[*v as usize + 1] += 1;
            }
        }
        for i in 0..vertex_count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut corners = vec![[0; 2]; starts[vertex_count] as usize];
        for [a, b, c] in triangles.iter().filter(|t| !flat(t)).copied() {
            for [own, other, third] in [[a, b, c], [b, c, a], [c, a, b]] {
                let place = &mut next[own as usize];
                corners[*place as usize] = [other, third];
                *place += 1;
            }
        }
        Ok(Self {
            vertex_count,
            vertices: Vec::new(),
            starts,
            corners,
        })
    }

    /// Those of some vertices, of those of all.
    pub(crate) fn of(&self, vertices: Vec<u32>) -> Self {
        let mut starts = vec![0];
        let mut corners = Vec::new();
        for vertex in &vertices {
            corners.extend(self.around(*vertex as usize));
            starts.push(corners.len() as u32);
        }
        Self {
            vertex_count: self.vertex_count,
            vertices,
            starts,
            corners,
        }
    }

    /// The triangles around the vertex of that place.
    pub(crate) fn around(&self, place: usize) -> &[[u32; 2]] {
        &self.corners[self.starts[place] as usize..self.starts[place + 1] as usize]
    }
}
