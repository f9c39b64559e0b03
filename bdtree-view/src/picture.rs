//! The three-dimensional part of the window, in a texture of its own.

use bdtree_gpu::GpuError;
use bdtree_render::{Gpu, RenderError, Renderer, Scene, SkinnedMesh};
use wgpu::{CommandEncoder, Texture, TextureFormat, TextureUsages};

use crate::app::{App, View};
use crate::shapes::Shapes;

/// What egui shows: numbers are sRGB.
const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
const SAMPLES: u32 = 4;
/// Behind everything.
pub(crate) const BACKGROUND: [u8; 4] = [252, 252, 253, 255];

/// The picture and what it shows.
pub(crate) struct Picture {
    renderer: Renderer,
    mesh: SkinnedMesh,
    /// What to show; another one after [`Picture::draw`] with another size.
    pub(crate) texture: Texture,
    drawn: Option<(View, [u32; 2])>,
    /// Why the mesh is not where it should be.
    pub problem: Option<String>,
}

impl Picture {
    /// Of one pixel, with the asset on the device.
    ///
    /// # Errors
    /// More than the device takes, a corrupt asset.
    pub(crate) fn new(gpu: &Gpu, app: &App<'_>) -> Result<Self, RenderError> {
        let renderer = Renderer::new(&gpu.device, FORMAT, SAMPLES);
        let mesh = SkinnedMesh::new(gpu, &renderer, app.asset())?;
        Ok(Self {
            renderer,
            mesh,
            texture: texture(gpu, [1, 1]),
            drawn: None,
            problem: None,
        })
    }

    /// Makes the picture show what `app` does, at `size` pixels, and returns whether its texture is
    /// another one.
    ///
    /// # Errors
    /// More than the device takes, a lost device.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        app: &App<'_>,
        size: [u32; 2],
    ) -> Result<bool, RenderError> {
        let Some(camera) = app.view.camera else {
            return Ok(false);
        };
        let is_drawn = |(view, of): &(View, [u32; 2])| *view == app.view && *of == size;
        if size.contains(&0) || self.drawn.as_ref().is_some_and(is_drawn) {
            return Ok(false);
        }
        allows(gpu, size)?;
        let drawn = self.drawn.as_ref();
        let is_posed = drawn.is_some_and(|(view, _)| view.is_posed_as(&app.view));
        if !is_posed {
            self.pose(gpu, app)?;
        }
        let has_grown = [self.texture.width(), self.texture.height()] != size;
        if has_grown {
            self.texture = texture(gpu, size);
        }
        let shapes = Shapes::of(app);
        let meshes = [&self.mesh.mesh];
        let view = self.texture.create_view(&Default::default());
        self.renderer.draw(
            &gpu.device,
            &gpu.queue,
            encoder,
            &view,
            size,
            &camera,
            &Scene {
                ground: None,
                background: BACKGROUND,
                meshes: if app.view.has_mesh { &meshes } else { &[] },
                spheres: &shapes.spheres,
                lines: &shapes.lines,
            },
        )?;
        self.drawn = Some((app.view.clone(), size));
        Ok(has_grown)
    }

    fn pose(&mut self, gpu: &Gpu, app: &App<'_>) -> Result<(), RenderError> {
        let view = &app.view;
        let transform = app.place.shown_transform(view.transform);
        let posed = self
            .mesh
            .pose_with_bones(gpu, app.asset(), &view.q, view.bones(), transform);
        self.problem = match posed {
            Ok(()) => None,
            // What this posture alone is to blame for.
            Err(RenderError::Skinning(
                error @ (GpuError::Pose(_) | GpuError::TooFar { .. } | GpuError::Corrupt(_)),
            )) => Some(error.to_string()),
            Err(error) => return Err(error),
        };
        Ok(())
    }
}

/// Checks that the device takes pictures of a size.
///
/// # Errors
/// When it does not.
pub(crate) fn allows(gpu: &Gpu, size: [u32; 2]) -> Result<(), RenderError> {
    let limit = u64::from(gpu.device.limits().max_texture_dimension_2d);
    let needed = u64::from(size[0].max(size[1]));
    if needed > limit {
        return Err(RenderError::TooLarge {
            what: "the window",
            needed,
            limit,
            unit: "pixels",
        });
    }
    Ok(())
}

fn texture(gpu: &Gpu, size: [u32; 2]) -> Texture {
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    bdtree_render::texture(&gpu.device, "scene", size, 1, FORMAT, usage)
}
