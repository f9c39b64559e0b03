//! Where controls and picture are, and what mouse and keyboard do there.

use egui::{CentralPanel, Frame, Margin, Panel, Sense, TextureId, Ui};

use crate::app::{App, Grab};
use crate::orbit::WHEEL;
use crate::panel::{self, Side, Status, Wish};
use crate::picture::BACKGROUND;

/// Controls and picture; returns the picture's size in pixels, or what has failed.
pub(crate) fn lay_out(
    ui: &mut Ui,
    app: &mut App<'_>,
    status: &Status,
    picture: TextureId,
) -> Result<[u32; 2], String> {
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
        .show(ui, |ui| panel::show(ui, app, status))
        .inner;
    let [r, g, b, _] = BACKGROUND;
    let frame = Frame::new().fill(egui::Color32::from_rgb(r, g, b));
    let shown = CentralPanel::no_frame()
        .frame(frame)
        .show(ui, |ui| show_picture(ui, app, wish, picture));
    let is_typing = ui.ctx().egui_wants_keyboard_input();
    if !is_typing && ui.input(|input| input.key_pressed(egui::Key::Space)) {
        app.toggle();
    }
    shown.inner
}

/// The picture, and the mouse on it.
fn show_picture(
    ui: &mut Ui,
    app: &mut App<'_>,
    wish: Wish,
    picture: TextureId,
) -> Result<[u32; 2], String> {
    let area = ui.available_rect_before_wrap();
    let per_point = ui.ctx().pixels_per_point();
    let size = [area.width(), area.height()].map(|n| (n * per_point).round().max(0.0) as u32);
    let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    ui.painter()
        .image(picture, area, whole, egui::Color32::WHITE);
    let response = ui.allocate_rect(area, Sense::click_and_drag());
    if app.view.camera.is_none() || wish.fit {
        let aspect = area.width().max(1.0) / area.height().max(1.0);
        app.fit(aspect).map_err(|error| error.to_string())?;
    }
    let place = app.place;
    let pixels = |v: egui::Vec2| [v.x * per_point, v.y * per_point];
    if response.drag_started()
        && let Some(at) = ui.input(|input| input.pointer.press_origin())
    {
        let moves = response.drag_started_by(egui::PointerButton::Primary);
        let is_pan = !moves || ui.input(|input| input.modifiers.shift);
        app.grab = Some(match is_pan {
            true => Grab::Pan,
            false => app.view.grab(&place, pixels(at - area.min), size),
        });
    }
    if response.dragged()
        && let Some(grab) = app.grab
    {
        // Where the pointer moves within the frame of the press, a drag begins a frame later.
        let moved = match response.drag_started() {
            true => response.total_drag_delta().unwrap_or_default(),
            false => response.drag_delta(),
        };
        app.view.drag(&place, grab, pixels(moved), size);
    }
    if response.drag_stopped() {
        app.grab = None;
    }
    if response.hovered() {
        let wheel = ui.input(|input| input.smooth_scroll_delta().y);
        if wheel != 0.0 {
            app.view.zoom(wheel / WHEEL);
        }
    }
    Ok(size)
}

#[cfg(test)]
mod tests;
