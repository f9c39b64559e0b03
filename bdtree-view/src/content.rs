//! What a window shows, whichever program it is of.

use bdtree_render::{Gpu, RenderError};
use egui::{TextureId, Ui};
use wgpu::{CommandEncoder, Texture};

use crate::panel::Status;

/// A state with its controls and its picture.
pub(crate) trait Content {
    /// What the picture needs on the device.
    type Picture;

    /// The window's title.
    fn title(&self) -> String;

    /// What errors of the window are about: their lines begin with it.
    fn subject(&self) -> String;

    /// Gets the device ready.
    ///
    /// # Errors
    /// More than the device takes, a corrupt asset.
    fn picture(&self, gpu: &Gpu) -> Result<Self::Picture, RenderError>;

    /// Where the picture is; another one after [`Content::draw`] where that says so.
    fn texture(picture: &Self::Picture) -> &Texture;

    /// What is wrong with the picture.
    fn problem(&self, picture: &Self::Picture) -> Option<String>;

    /// Lets time pass.
    fn advance(&mut self, dt_s: f64);

    /// Controls and picture; returns the picture's size in pixels.
    ///
    /// # Errors
    /// In words, what has failed.
    fn lay_out(
        &mut self,
        ui: &mut Ui,
        status: &Status,
        picture: TextureId,
    ) -> Result<[u32; 2], String>;

    /// Finds what has changed, and returns whether anything has that controls are to show in another frame.
    fn refresh(&mut self) -> bool;

    /// Makes the picture show the state, at `size` pixels, and returns whether its texture is another one.
    ///
    /// # Errors
    /// More than the device takes, a lost device.
    fn draw(
        &mut self,
        picture: &mut Self::Picture,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        size: [u32; 2],
    ) -> Result<bool, RenderError>;

    /// Whether something moves by itself, so that frame has to follow frame.
    fn is_moving(&self) -> bool;
}
