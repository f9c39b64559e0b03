//! Sliders for q.

use egui::{Align, Label, Layout, Rangef, RichText, ScrollArea, Slider, SliderClamping, Ui, vec2};

use super::style;
use crate::app::{App, Reach};

/// The part of the window's height that the sliders take at most, and how many are seen at once.
const SHARE: f32 = 0.3;
const ROWS: [f32; 2] = [3.0, 8.0];
/// Points of a row's first line, and beside a slider: for its number and "Zero".
const TEXT: f32 = 14.0;
const BESIDE: f32 = 124.0;
/// Over `slider_end`, below that sliders to the limit count as 0.
const SMALLEST: f64 = 1e-6;

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    ui.horizontal(|ui| {
        if style::button(ui, "Zero all").clicked() {
            app.zero();
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.selectable_value(&mut app.reach, Reach::Limit, "limit")
                .on_hover_text("sliders go to q_limit, what the file allows (logarithmic)");
            ui.selectable_value(&mut app.reach, Reach::Range, "range")
                .on_hover_text("sliders go to q_range, what is typical");
            ui.label(RichText::new("sliders go to").small().weak());
        });
    });
    let spacing = ui.spacing().item_spacing.y;
    let height = TEXT + ui.spacing().interact_size.y;
    let count = app.view.q.len();
    let room = SHARE * ui.ctx().content_rect().height() / (height + spacing);
    let rows = room.floor().clamp(ROWS[0], ROWS[1]);
    // Rows that are out of sight are not made.
    ScrollArea::vertical()
        .id_salt("modes")
        .max_height(rows * (height + spacing))
        .auto_shrink([false, true])
        .show_rows(ui, height, count, |ui, rows| {
            for mode in rows {
                row(ui, app, mode, height);
            }
        });
}

fn row(ui: &mut Ui, app: &mut App<'_>, mode: usize, height: f32) {
    let size = vec2(ui.available_width(), height);
    ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
        ui.set_min_size(size);
        ui.spacing_mut().item_spacing.y = 0.0;
        let line = vec2(size.x, TEXT);
        let from_right = Layout::right_to_left(Align::Center);
        ui.allocate_ui_with_layout(line, from_right, |ui| heading(ui, app, mode));
        controls(ui, app, mode);
    });
}

/// Name and frequency, range and limit.
fn heading(ui: &mut Ui, app: &App<'_>, mode: usize) {
    let (name, about) = describe(app, mode);
    if let Some(record) = app.asset().modes().get(mode) {
        let ends = [record.q_range.get(), record.q_limit.get()].map(|q| figures(f64::from(q)));
        let text = format!("range ±{}  ·  limit ±{}", ends[0], ends[1]);
        ui.label(RichText::new(text).small().weak());
    }
    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
        let label = Label::new(RichText::new(name).small()).truncate();
        ui.add(label).on_hover_text(about);
    });
}

/// Slider, number and "Zero".
fn controls(ui: &mut Ui, app: &mut App<'_>, mode: usize) {
    let end = f64::from(app.slider_end(mode));
    ui.horizontal(|ui| {
        let Some(q) = app.view.q.get_mut(mode) else {
            return;
        };
        ui.spacing_mut().slider_width = ui.available_width() - BESIDE;
        mark_middle(ui);
        let mut slider = Slider::new(q, -end as f32..=end as f32)
            // A frame may have more than is typical: it is shown, not changed.
            .clamping(SliderClamping::Edits)
            // A bar from the left end would tell of -range, not of 0.
            .trailing_fill(false)
            .custom_formatter(|x, _| short(x));
        if app.reach == Reach::Limit {
            slider = slider.logarithmic(true).smallest_positive(end * SMALLEST);
        }
        let is_moved = ui.add(slider).changed();
        let is_zeroed = style::button(ui, RichText::new("Zero").small()).clicked();
        if is_zeroed {
            *q = 0.0;
        }
        if is_moved || is_zeroed {
            app.playback.clock.is_playing = false;
        }
    });
}

/// A line where the slider that follows has 0.
fn mark_middle(ui: &Ui) {
    let place = ui.available_rect_before_wrap();
    let x = place.left() + 0.5 * ui.spacing().slider_width;
    let height = ui.spacing().interact_size.y;
    let line = Rangef::new(place.top() + 0.1 * height, place.top() + 0.9 * height);
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().vline(x, line, stroke);
}

/// Name and frequency of a mode, short and long.
fn describe(app: &App<'_>, mode: usize) -> (String, String) {
    let known = app.info.mode_info.get(mode);
    let name = known
        .and_then(|mode| mode.name.clone())
        .filter(|name| !name.is_empty());
    let hz = known.and_then(|mode| mode.frequency_hz);
    let short = match (&name, hz) {
        (Some(name), Some(hz)) => format!("{name} · {} Hz", figures(hz)),
        (Some(name), None) => name.clone(),
        (None, Some(hz)) => format!("q[{mode}] · {} Hz", figures(hz)),
        (None, None) => format!("q[{mode}]"),
    };
    let mut long = format!("q[{mode}]");
    if let Some(name) = &name {
        long += &format!(" {name}");
    }
    if let Some(hz) = hz {
        long += &format!("\n{hz} Hz");
    }
    if let Some(record) = app.asset().modes().get(mode) {
        let (range, limit) = (record.q_range.get(), record.q_limit.get());
        long += &format!("\nrange ±{range}, limit ±{limit}");
    }
    (short, long)
}

/// A number in a few characters.
fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_string(),
        m if (0.001..1.0).contains(&m) => format!("{x:.4}"),
        m if (1.0..1000.0).contains(&m) => format!("{x:.3}"),
        _ => format!("{x:.1e}"),
    }
}

/// A number with about three digits.
fn figures(x: f64) -> String {
    match x.abs() {
        m if (100.0..1e6).contains(&m) => format!("{x:.0}"),
        m if (1.0..100.0).contains(&m) => format!("{x:.1}"),
        _ => short(x),
    }
}

#[cfg(test)]
mod tests {
    use super::{figures, short};

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0177, "-0.0177"),
            (0.5, "0.5000"),
            (-64.0, "-64.000"),
            (2e-6, "2.0e-6"),
            (4e9, "4.0e9"),
        ] {
            assert_eq!(short(x), text);
        }
        for (x, text) in [
            (294.03, "294"),
            (1.98943, "2.0"),
            (0.25, "0.2500"),
            (3e7, "3.0e7"),
        ] {
            assert_eq!(figures(x), text);
        }
    }
}
