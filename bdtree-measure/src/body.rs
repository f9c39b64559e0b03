//! A mesh with its modes and bones, as contenders take them.

use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::input::RawMesh;
use bdtree_runtime::{Asset, FormatError, TriangleId, VertexId};

use crate::{BodySkin, MeasureError};

/// A mesh with its modes and bones, in the numbers that all contenders get.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// For tables and file names.
    pub name: &'static str,
    /// Rest positions, before bones.
    pub positions: Vec<[f32; 3]>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// U, mode after mode: `fields[j * N + i]` moves vertex `i`.
    pub fields: Vec<[f32; 3]>,
    /// Number of modes M.
    pub modes: usize,
    /// What carries the vertices after the modes have moved them.
    pub skin: Option<BodySkin>,
}

impl Body {
    /// The mesh as the builder takes it, without bones.
    pub fn mesh(&self) -> RawMesh {
        RawMesh {
            name: self.name.to_string(),
            positions: self.positions.iter().map(|p| p.map(f64::from)).collect(),
            triangles: self.triangles.clone(),
            ..RawMesh::default()
        }
    }

    /// The modes as the builder takes them, all of range 1.
    pub fn basis(&self) -> Basis {
        Basis {
            vertex_count: self.positions.len(),
            fields: self.fields.iter().map(|u| u.map(f64::from)).collect(),
            modes: vec![
                BasisMode {
                    q_range: Some(1.0),
                    ..BasisMode::default()
                };
                self.modes
            ],
            animation: None,
        }
    }

    /// The same mesh without modes and bones.
    pub fn rigid(&self) -> Body {
        Body {
            fields: Vec::new(),
            modes: 0,
            skin: None,
            ..self.clone()
        }
    }

    /// What an asset holds (stored units): the same numbers as its queries use.
    ///
    /// # Errors
    /// Records that break the format's rules.
    pub fn of_asset(asset: &Asset<'_>) -> Result<Self, MeasureError> {
        let vertices = 0..asset.vertex_count() as u32;
        let modes = asset.mode_count();
        let count = asset.vertex_count();
        let mut fields = vec![[0.0; 3]; modes * count];
        for i in vertices {
            for (j, u) in asset.displacements(VertexId(i))?.iter() {
                fields[j * count + i as usize] = u;
            }
        }
        let corners = |id| Ok(asset.triangle(TriangleId(id))?.map(|v| v.0));
        let triangles = (0..asset.triangle_count() as u32).map(corners);
        Ok(Self {
            name: "asset",
            positions: asset.positions().to_vec(),
            triangles: triangles.collect::<Result<_, FormatError>>()?,
            fields,
            modes,
            skin: BodySkin::of_asset(asset)?,
        })
    }

    /// Vertices where the source shows them without an animation: trees that are refitted are built there, since the
    /// bind spaces of several meshes may lie over each other.
    pub fn at_rest(&self) -> &[[f32; 3]] {
        self.skin
            .as_ref()
            .map_or(&self.positions, |skin| &skin.rest)
    }
}
