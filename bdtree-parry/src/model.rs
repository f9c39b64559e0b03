//! A `.bdt` file as physics engines need it.

use std::collections::HashMap;
use std::sync::Arc;

use bdtree_runtime::{Asset, Model, PoseError, Transform, TriangleId};

use crate::error::ShapeError;

/// What meshes of one file and scale have in common: the file, the neighbors of each triangle, which tell on which side of a
/// surface a contact lies, and whether the surface is closed. Cheap to clone.
#[derive(Debug, Clone)]
pub struct DeformingModel {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    model: Model,
    scale: f64,
    /// Of each triangle, the one across the edge from each corner to the next; itself where there is none.
    neighbors: Vec<[u32; 3]>,
    /// Of each vertex, a triangle that it is a corner of.
    triangle_at: Vec<u32>,
    is_closed: bool,
    /// Corners run clockwise as seen from outside.
    is_inside_out: bool,
}

impl DeformingModel {
    /// A model at a scale: world units per mesh unit. Reads all triangles.
    ///
    /// # Errors
    /// A scale that [`Transform`] does not allow, a damaged asset.
    pub fn new(model: &Model, scale: f64) -> Result<Self, ShapeError> {
        let asset = model.asset();
        asset.check_mesh()?;
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(PoseError::Scale.into());
        }
        let corners = welded(asset)?;
        let (neighbors, is_closed) = neighbors(&corners);
        let mut triangle_at = vec![u32::MAX; asset.vertex_count()];
        for id in 0..asset.triangle_count() as u32 {
            for corner in asset.triangle(TriangleId(id))? {
                triangle_at[corner.0 as usize] = id;
            }
        }
        Ok(Self {
            shared: Arc::new(Shared {
                is_inside_out: is_closed && volume(asset, &corners) < 0.0,
                model: model.clone(),
                scale,
                neighbors,
                triangle_at,
                is_closed,
            }),
        })
    }

    /// The same model at another scale.
    ///
    /// # Errors
    /// A scale that is not positive and finite.
    pub fn scaled(&self, scale: f64) -> Result<Self, ShapeError> {
        Self::new(&self.shared.model, scale)
    }

    /// The file.
    pub fn model(&self) -> &Model {
        &self.shared.model
    }

    /// World units per mesh unit.
    pub fn scale(&self) -> f64 {
        self.shared.scale
    }

    /// Whether every edge belongs to two triangles that run along it in opposite directions. Contacts of a closed mesh push
    /// outwards, those of another one away from either side.
    pub fn is_closed(&self) -> bool {
        self.shared.is_closed
    }

    /// Where meshes stand in their own frame.
    pub(crate) fn placement(&self) -> Transform {
        Transform {
            scale: self.shared.scale,
            ..Transform::IDENTITY
        }
    }

    /// Of a triangle, the one across the edge from each corner to the next; itself where there is none.
    pub(crate) fn neighbors(&self, triangle: u32) -> [u32; 3] {
        let all = &self.shared.neighbors;
        all.get(triangle as usize).copied().unwrap_or([triangle; 3])
    }

    /// A triangle that a vertex is a corner of; `None` where it is one of none.
    pub(crate) fn triangle_at(&self, vertex: u32) -> Option<u32> {
        let id = self.shared.triangle_at.get(vertex as usize).copied();
        id.filter(|id| *id != u32::MAX)
    }

    /// 1, or −1 where corners run clockwise as seen from outside.
    pub(crate) fn outwards(&self) -> f64 {
        if self.shared.is_inside_out { -1.0 } else { 1.0 }
    }
}

/// The corners of all triangles, vertices at equal rest positions being one: seams of texture coordinates are no edges.
fn welded(asset: &Asset<'_>) -> Result<Vec<[u32; 3]>, ShapeError> {
    let mut first = HashMap::new();
    let one: Vec<u32> = (0..)
        .zip(asset.positions())
        .map(|(id, p)| {
            // Adding 0 makes one number of both zeros.
            let key = p.map(|x| (x + 0.0).to_bits());
            *first.entry(key).or_insert(id)
        })
        .collect();
    (0..asset.triangle_count() as u32)
        .map(|id| Ok(asset.triangle(TriangleId(id))?.map(|v| one[v.0 as usize])))
        .collect()
}

/// Neighbors across edges that two triangles run along in opposite directions, and whether all edges are such.
fn neighbors(corners: &[[u32; 3]]) -> (Vec<[u32; 3]>, bool) {
    // Of each directed edge the triangle that has it, and how many have.
    let mut edges: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
    for (id, [a, b, c]) in (0..).zip(corners) {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            let entry = edges.entry(edge).or_insert((id, 0));
            entry.1 += 1;
        }
    }
    let mut is_closed = !corners.is_empty();
    let all = (0..)
        .zip(corners)
        .map(|(id, [a, b, c])| {
            [(*a, *b), (*b, *c), (*c, *a)].map(|(from, to)| {
                let is_own = edges.get(&(from, to)).is_some_and(|own| own.1 == 1);
                match edges.get(&(to, from)) {
                    Some(&(other, 1)) if is_own => other,
                    _ => {
                        is_closed = false;
                        id
                    }
                }
            })
        })
        .collect();
    (all, is_closed)
}

/// The enclosed volume at rest, negative where corners run clockwise as seen from outside, stored units.
fn volume(asset: &Asset<'_>, corners: &[[u32; 3]]) -> f64 {
    let point = |v: u32| asset.positions()[v as usize].map(f64::from);
    let each = corners.iter().map(|corners| {
        let [a, b, c] = corners.map(point);
        let (u, v) = (
            [0, 1, 2].map(|k| b[k] - a[k]),
            [0, 1, 2].map(|k| c[k] - a[k]),
        );
        let normal = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        (0..3).map(|k| normal[k] * a[k]).sum::<f64>() / 6.0
    });
    each.sum()
}
