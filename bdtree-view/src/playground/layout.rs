//! Where controls and picture are, and what mouse and keyboard do there.

use bdtree_render::{Gpu, RenderError};
use egui::{
    CentralPanel, Color32, Frame, Key, Margin, Panel, PointerButton, Rect, RichText, Sense,
    TextureId, Ui, Vec2, pos2,
};
use wgpu::{CommandEncoder, Texture};

use super::panel::{self, Wish};
use super::picture::{BACKGROUND, Picture};
use super::play::{Hold, Playground};
use crate::content::Content;
use crate::orbit::WHEEL;
use crate::panel::{Side, Status, style};

/// Keys that choose the first files.
const NUMBERS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

impl Content for Playground {
    type Picture = Picture;

    fn title(&self) -> String {
        "Playground – bdtree".to_string()
    }

    fn subject(&self) -> String {
        "playground".to_string()
    }

    fn picture(&self, gpu: &Gpu) -> Result<Picture, RenderError> {
        Picture::new(gpu, self)
    }

    fn texture(picture: &Picture) -> &Texture {
        &picture.texture
    }

    fn problem(&self, _: &Picture) -> Option<String> {
        self.problem.as_ref().map(|problem| problem.text.clone())
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
        Ok(lay_out(ui, self, status, picture))
    }

    fn refresh(&mut self) -> bool {
        false
    }

    fn draw(
        &mut self,
        picture: &mut Picture,
        _: &Gpu,
        _: &mut CommandEncoder,
        size: [u32; 2],
    ) -> Result<bool, RenderError> {
        picture.draw(self, size)
    }

    fn is_moving(&self) -> bool {
        self.is_moving()
    }
}

/// Controls and picture; returns the picture's size in pixels.
fn lay_out(ui: &mut Ui, play: &mut Playground, status: &Status, picture: TextureId) -> [u32; 2] {
    let frame = Frame::new()
        .fill(ui.visuals().panel_fill)
        .inner_margin(Margin::symmetric(12, 10));
    let controls = match Side::of(ui.available_size()) {
        Side::Left(width) => Panel::left("controls").exact_size(width),
        Side::Below(height) => Panel::bottom("controls below").exact_size(height),
    };
    let wish = controls
        .resizable(false)
        .frame(frame)
        .show(ui, |ui| panel::show(ui, play, status))
        .inner;
    if let Some(problem) = play.problem.clone() {
        let frame = frame.inner_margin(Margin::symmetric(10, 6));
        Panel::bottom("problem")
            .resizable(false)
            .frame(frame)
            .show(ui, |ui| {
                ui.label(RichText::new(&problem.text).color(style::WRONG));
                ui.horizontal_wrapped(|ui| {
                    let count = problem.bodies.len();
                    let remove = match count {
                        1 => "Remove this body".to_string(),
                        _ => format!("Remove these {count} bodies"),
                    };
                    if count > 0 && style::button(ui, "Slow down").clicked() {
                        play.slow_down(&problem);
                    }
                    if count > 0 && style::button(ui, remove).clicked() {
                        play.remove(&problem.bodies);
                    }
                    if style::button(ui, "Close").clicked() {
                        play.problem = None;
                    }
                });
            });
    }
    let [r, g, b, _] = BACKGROUND;
    let frame = Frame::new().fill(Color32::from_rgb(r, g, b));
    CentralPanel::no_frame()
        .frame(frame)
        .show(ui, |ui| show_picture(ui, play, wish, picture))
        .inner
}

/// The picture, and the mouse on it.
fn show_picture(ui: &mut Ui, play: &mut Playground, wish: Wish, picture: TextureId) -> [u32; 2] {
    let area = ui.available_rect_before_wrap();
    let per_point = ui.ctx().pixels_per_point();
    let size = [area.width(), area.height()].map(|n| (n * per_point).round().max(0.0) as u32);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(picture, area, whole, Color32::WHITE);
    let response = ui.allocate_rect(area, Sense::click_and_drag());
    if play.camera.is_none() || wish.fits {
        play.fit(area.width().max(1.0) / area.height().max(1.0));
    }
    let pixels = |v: Vec2| [v.x * per_point, v.y * per_point];
    if response.drag_started()
        && let Some(at) = ui.input(|input| input.pointer.press_origin())
    {
        let is_primary = response.drag_started_by(PointerButton::Primary);
        match is_primary && !ui.input(|input| input.modifiers.shift) {
            true => play.grab(pixels(at - area.min), size),
            false => play.hold = Some(Hold::Pan),
        }
    }
    if response.dragged()
        && let Some(at) = response.interact_pointer_pos()
    {
        // Where the pointer moves within the frame of the press, a drag begins a frame later.
        let moved = match response.drag_started() {
            true => response.total_drag_delta().unwrap_or_default(),
            false => response.drag_delta(),
        };
        play.drag(pixels(moved), pixels(at - area.min), size);
    }
    if response.drag_stopped() {
        play.let_go();
    }
    if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        play.drop_at(pixels(at - area.min), size);
    }
    if response.contains_pointer() {
        let wheel = ui.input(|input| input.smooth_scroll_delta().y);
        if wheel != 0.0 {
            play.wheel(wheel / WHEEL);
        }
    }
    let middle = pixels(0.5 * area.size());
    let pointer = response.hover_pos().map(|at| pixels(at - area.min));
    if wish.drops {
        play.drop_at(middle, size);
    }
    if wish.throws {
        play.throw_at(middle, size);
    }
    if !ui.ctx().egui_wants_keyboard_input() {
        keys(ui, play, pointer, middle, size);
    }
    size
}

/// Keys, at the pointer where that is on the picture; drops and throws else at the middle.
fn keys(
    ui: &Ui,
    play: &mut Playground,
    pointer: Option<[f32; 2]>,
    middle: [f32; 2],
    size: [u32; 2],
) {
    let pressed = |key| ui.input(|input| input.key_pressed(key));
    if pressed(Key::Space) {
        play.pace.toggle();
    }
    if pressed(Key::Period) {
        play.pace.step_once();
    }
    if pressed(Key::R) {
        play.reset();
    }
    if pressed(Key::D) {
        play.drop_at(pointer.unwrap_or(middle), size);
    }
    if pressed(Key::T) {
        play.throw_at(pointer.unwrap_or(middle), size);
    }
    if let Some(at) = pointer {
        if pressed(Key::P) {
            play.poke_at(at, size);
        }
        if pressed(Key::Delete) || pressed(Key::X) {
            play.remove_at(at, size);
        }
    }
    for (kind, key) in NUMBERS.into_iter().enumerate() {
        if pressed(key) {
            play.choose(kind);
        }
    }
}

#[cfg(test)]
mod tests;
