//! A placed, deformed asset to draw.

use bdtree_render::NodeSphere;
use bdtree_runtime::{Asset, FormatError, Pose, Transform};

use super::sound;
use crate::AssetFile;
use crate::deform::deformed;
use crate::error::ToolError;

/// q and a place.
#[derive(Debug, Clone)]
pub(super) struct Posture {
    pub(super) q: Vec<f32>,
    pub(super) transform: Transform,
}

/// An asset in a posture.
pub(super) struct Body<'a> {
    pub(super) file: &'a AssetFile,
    pub(super) asset: Asset<'a>,
    pub(super) posture: Posture,
    /// The deformed vertices (world).
    pub(super) positions: Vec<[f64; 3]>,
    /// Box of those that belong to a triangle.
    pub(super) bounds: [[f64; 3]; 2],
}

impl<'a> Body<'a> {
    pub(super) fn new(
        file: &'a AssetFile,
        asset: Asset<'a>,
        posture: Posture,
    ) -> Result<Self, ToolError> {
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = Pose::new(&asset, &posture.q, posture.transform, &mut memory)
            .map_err(|error| ToolError::input(file.path().display(), error))?;
        let positions = deformed(file, &asset, &pose)?;
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for v in asset.triangles().iter().flat_map(|record| record.corners) {
            if let Some(p) = positions.get(v as usize) {
                bounds = around(bounds, *p, 0.0);
            }
        }
        Ok(Self {
            file,
            asset,
            posture,
            positions,
            bounds,
        })
    }

    /// Spheres of its tree, those left out that bound nothing.
    pub(super) fn spheres(
        &self,
        of: impl FnOnce(&Asset<'a>, &Pose<'_>) -> Result<Vec<NodeSphere>, FormatError>,
    ) -> Result<Vec<NodeSphere>, ToolError> {
        let mut memory = vec![0.0; self.asset.pose_len()];
        let Posture { q, transform } = &self.posture;
        let pose = Pose::new(&self.asset, q, *transform, &mut memory)
            .map_err(|error| ToolError::input(self.file.path().display(), error))?;
        let spheres = of(&self.asset, &pose);
        spheres.map(sound).map_err(|error| self.file.error(error))
    }
}

/// A box that holds another one and a ball.
pub(super) fn around(
    [mut low, mut high]: [[f64; 3]; 2],
    centre: [f64; 3],
    radius: f64,
) -> [[f64; 3]; 2] {
    for k in 0..3 {
        low[k] = low[k].min(centre[k] - radius);
        high[k] = high[k].max(centre[k] + radius);
    }
    [low, high]
}
