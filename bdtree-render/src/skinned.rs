//! A mesh that the runtime deforms on the device.

use bdtree_gpu::{GpuAsset, Instances, Normals, Output, Skinner};
use bdtree_runtime::{Asset, BoneMatrices, Pose, Transform};

use crate::error::RenderError;
use crate::gpu::Gpu;
use crate::renderer::{Mesh, Renderer};
use crate::shading::smoothness;

/// An asset on the device with room for one pose of it.
#[derive(Debug)]
pub struct SkinnedMesh {
    skinner: Skinner,
    asset: GpuAsset,
    instances: Instances,
    output: Output,
    /// What to draw.
    pub mesh: Mesh,
}

impl SkinnedMesh {
    /// Copies an asset to the device, for `renderer` to draw.
    ///
    /// # Errors
    /// More than the device takes, a corrupt asset.
    pub fn new(gpu: &Gpu, renderer: &Renderer, asset: &Asset<'_>) -> Result<Self, RenderError> {
        let skinner = Skinner::new(&gpu.device, &gpu.queue)?;
        let triangles: Vec<_> = asset.triangles().iter().map(|t| t.corners).collect();
        let smoothness = smoothness(asset.positions(), &triangles);
        let asset = skinner.upload(asset, Normals::Exact)?;
        let instances = skinner.instances(&asset, 1)?;
        let output = skinner.output(&asset, 1)?;
        // They were asked for.
        let normals = output.normals().unwrap_or(output.positions());
        let buffers = [output.positions(), normals, asset.indices()];
        let triangles = asset.triangle_count();
        let mesh = renderer.mesh_of_buffers(&gpu.device, buffers, &smoothness, triangles)?;
        gpu.check()?;
        Ok(Self {
            skinner,
            asset,
            instances,
            output,
            mesh,
        })
    }

    /// Deforms it: from now on pictures show it in a pose, bones included. Coordinates of the picture are the world of the
    /// pose's placement.
    ///
    /// # Errors
    /// A pose of another asset, a lost device.
    pub fn pose(&mut self, gpu: &Gpu, pose: &Pose<'_>) -> Result<(), RenderError> {
        self.instances.clear([0.0; 3]);
        self.instances.push(pose)?;
        self.deform(gpu)
    }

    /// The same without a pose: q, bones and a placement.
    ///
    /// # Errors
    /// Those of [`SkinnedMesh::pose`]; q, matrices or a placement that the asset refuses.
    pub fn pose_with_bones(
        &mut self,
        gpu: &Gpu,
        asset: &Asset<'_>,
        q: &[f32],
        bones: BoneMatrices<'_>,
        transform: Transform,
    ) -> Result<(), RenderError> {
        self.instances.clear([0.0; 3]);
        self.instances.push_with_bones(asset, q, bones, transform)?;
        self.deform(gpu)
    }

    /// Deforms the one instance on the device.
    fn deform(&mut self, gpu: &Gpu) -> Result<(), RenderError> {
        self.instances.write();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.skinner
            .record(&mut encoder, &self.asset, &self.instances, &self.output)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.check()
    }

    /// The same, to give it a colour.
    pub fn mesh_mut(&mut self) -> &mut Mesh {
        &mut self.mesh
    }
}
