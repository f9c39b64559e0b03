//! The viewer's state as what a window shows.

use bdtree_render::{Gpu, RenderError};
use egui::{TextureId, Ui};
use wgpu::{CommandEncoder, Texture};

use crate::app::App;
use crate::content::Content;
use crate::layout::lay_out;
use crate::panel::Status;
use crate::picture::Picture;

impl Content for App<'_> {
    type Picture = Picture;

    fn title(&self) -> String {
        let name = self.file.path().file_name().unwrap_or_default();
        let name = name.to_string_lossy().replace(char::is_control, "");
        format!("{name} – bdtree")
    }

    fn subject(&self) -> String {
        self.file.path().display().to_string()
    }

    fn picture(&self, gpu: &Gpu) -> Result<Picture, RenderError> {
        Picture::new(gpu, self)
    }

    fn texture(picture: &Picture) -> &Texture {
        &picture.texture
    }

    fn problem(&self, picture: &Picture) -> Option<String> {
        picture.problem.clone()
    }

    fn advance(&mut self, dt_s: f64) {
        self.advance(dt_s);
    }

    fn lay_out(
        &mut self,
        ui: &mut Ui,
        status: &Status,
        picture: TextureId,
    ) -> Result<[u32; 2], String> {
        lay_out(ui, self, status, picture)
    }

    fn refresh(&mut self) -> bool {
        self.refresh()
    }

    fn draw(
        &mut self,
        picture: &mut Picture,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        size: [u32; 2],
    ) -> Result<bool, RenderError> {
        picture.draw(gpu, encoder, self, size)
    }

    fn is_moving(&self) -> bool {
        self.is_playing()
    }
}
