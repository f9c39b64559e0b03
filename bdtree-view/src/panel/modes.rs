//! Sliders for q.

use egui::{Align, Layout, RichText, ScrollArea, Slider, SliderClamping, Ui, vec2};

use crate::app::{App, Reach};

/// Rows that are seen at once; of more, as many as are seen are made.
const ROWS: usize = 8;
/// Points for a mode's name and frequency.
const LABEL: f32 = 106.0;
/// Over `slider_end`, below that sliders to the limit count as 0.
const SMALLEST: f64 = 1e-6;

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    ui.horizontal(|ui| {
        if ui.button("Zero all").clicked() {
            app.zero();
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.selectable_value(&mut app.reach, Reach::Limit, "limit")
                .on_hover_text("sliders go to what the file allows (logarithmic)");
            ui.selectable_value(&mut app.reach, Reach::Range, "range")
                .on_hover_text("sliders go to what is typical");
        });
    });
    let height = ui.spacing().interact_size.y;
    let count = app.view.q.len();
    ScrollArea::vertical()
        .id_salt("modes")
        .max_height(ROWS as f32 * (height + ui.spacing().item_spacing.y))
        .auto_shrink([false, true])
        .show_rows(ui, height, count, |ui, rows| {
            for mode in rows {
                row(ui, app, mode, height);
            }
        });
}

fn row(ui: &mut Ui, app: &mut App<'_>, mode: usize, height: f32) {
    let (name, about) = describe(app, mode);
    let end = f64::from(app.slider_end(mode));
    ui.horizontal(|ui| {
        ui.allocate_ui_with_layout(
            vec2(LABEL, height),
            Layout::left_to_right(Align::Center),
            |ui| {
                ui.set_min_width(LABEL);
                ui.add(egui::Label::new(RichText::new(name).small()).truncate())
                    .on_hover_text(about);
            },
        );
        let Some(q) = app.view.q.get_mut(mode) else {
            return;
        };
        let mut slider = Slider::new(q, -end as f32..=end as f32)
            // A frame may have more than is typical: it is shown, not changed.
            .clamping(SliderClamping::Edits)
            .custom_formatter(|x, _| short(x));
        if app.reach == Reach::Limit {
            slider = slider.logarithmic(true).smallest_positive(end * SMALLEST);
        }
        let is_moved = ui.add(slider).changed();
        let is_zeroed = ui.small_button("0").on_hover_text("zero").clicked();
        if is_zeroed {
            *q = 0.0;
        }
        if is_moved || is_zeroed {
            app.playback.is_playing = false;
        }
    });
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
