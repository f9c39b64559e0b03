//! A placed, deformed asset to draw.

use bdtree_render::NodeSphere;
use bdtree_runtime::{Asset, CacheSize, FormatError, Instance, Pose};

use crate::AssetFile;
use crate::deform::deformed;
use crate::error::ToolError;
use crate::posture::Posture;

/// A posed asset.
pub(super) struct Body<'a> {
    pub(super) file: &'a AssetFile,
    pub(super) instance: Instance,
    /// The deformed vertices (world).
    pub(super) positions: Vec<[f64; 3]>,
    /// Box of those that belong to a triangle.
    pub(super) bounds: [[f64; 3]; 2],
}

/// A body and its spheres.
pub(super) struct Content<'a> {
    pub(super) body: Body<'a>,
    pub(super) spheres: Vec<NodeSphere>,
    /// It is the file that the picture is of, not one that stands beside it.
    pub(super) is_file: bool,
}

impl<'a> Body<'a> {
    /// Of an instance of the file.
    pub(super) fn new(file: &'a AssetFile, instance: Instance) -> Result<Self, ToolError> {
        let positions = deformed(file, &instance.pose())?;
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let triangles = file.asset().triangles().iter();
        for v in triangles.flat_map(|record| record.corners) {
            if let Some(p) = positions.get(v as usize) {
                for k in 0..3 {
                    bounds[0][k] = bounds[0][k].min(p[k]);
                    bounds[1][k] = bounds[1][k].max(p[k]);
                }
            }
        }
        Ok(Self {
            file,
            instance,
            positions,
            bounds,
        })
    }

    /// Of the file in a posture.
    pub(super) fn posed(file: &'a AssetFile, posture: &Posture) -> Result<Self, ToolError> {
        let posed = Instance::with_cache(file.model(), CacheSize::NONE).and_then(|mut instance| {
            instance.set_pose_with_bones(&posture.q, posture.bones(), posture.transform)?;
            Ok(instance)
        });
        let refused = |error| ToolError::input(file.path().display(), error);
        Self::new(file, posed.map_err(refused)?)
    }

    /// The asset.
    pub(super) fn asset(&self) -> &'a Asset<'a> {
        self.file.asset()
    }

    /// Spheres of its tree, those left out that bound nothing.
    pub(super) fn spheres(
        &self,
        of: impl FnOnce(&Pose<'_>) -> Result<Vec<NodeSphere>, FormatError>,
    ) -> Result<Vec<NodeSphere>, ToolError> {
        let mut spheres = of(&self.instance.pose()).map_err(|error| self.file.error(error))?;
        // Others say nothing, and every query looks below them.
        spheres.retain(|s| s.radius.is_finite() && s.center.iter().all(|x| x.is_finite()));
        Ok(spheres)
    }
}
