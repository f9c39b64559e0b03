//! The controls beside the picture, or in narrow windows below it.

mod clock;
mod legend;
mod modes;
mod motion;
mod probe;
mod skeleton;
mod spheres;
pub(crate) mod style;

pub(crate) use style::dress;

use bdtree_tools::printable;
use egui::{CollapsingHeader, Grid, RichText, ScrollArea, Ui};

use crate::app::App;

/// Width in points, in windows that leave enough beside it.
pub const WIDTH: f32 = 332.0;
/// The least width, in small windows.
const WIDTH_MIN: f32 = 272.0;
/// The part of a small window that the panel takes.
const SHARE: f32 = 0.42;

/// Points that the panel takes of a window's height below the picture, at least and at most, and its part of it between.
const HEIGHT: [f32; 2] = [240.0, 460.0];
const SHARE_BELOW: f32 = 0.5;
/// What the picture above keeps of a low window.
const SHARE_LEFT: f32 = 0.3;

/// Where the panel is, with its width or height in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Side {
    /// Left of the picture.
    Left(f32),
    /// Below it, as wide as the window.
    Below(f32),
}

impl Side {
    /// In a window of a width and a height in points: beside the picture, unless that would leave a picture narrower
    /// than the panel.
    pub(crate) fn of(window: egui::Vec2) -> Self {
        if window.x < 2.0 * WIDTH_MIN {
            let height = (SHARE_BELOW * window.y).clamp(HEIGHT[0], HEIGHT[1]);
            Self::Below(height.min((1.0 - SHARE_LEFT) * window.y))
        } else {
            Self::Left((SHARE * window.x).clamp(WIDTH_MIN, WIDTH))
        }
    }
}

/// What the window knows and shows.
#[derive(Debug, Clone, Default)]
pub(crate) struct Status {
    /// Time from the beginning of a frame to its end, in milliseconds.
    pub frame_ms: Option<f64>,
    /// What draws.
    pub adapter: String,
    /// What is wrong.
    pub problem: Option<String>,
}

/// What was asked for that the state alone cannot do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Wish {
    /// The camera of the beginning.
    pub fit: bool,
}

/// Shows all controls.
pub(crate) fn show(ui: &mut Ui, app: &mut App<'_>, status: &Status) -> Wish {
    let mut wish = Wish::default();
    let name = app.file.path().file_name().unwrap_or_default();
    let name = printable(&name.to_string_lossy());
    ui.add(egui::Label::new(RichText::new(name).size(17.0).strong()).truncate());
    facts(ui, app);
    ui.add_space(2.0);
    let below = 42.0 + if status.problem.is_some() { 40.0 } else { 0.0 };
    let height = (ui.available_height() - below).max(60.0);
    ScrollArea::vertical()
        .max_height(height)
        .auto_shrink([false, false])
        .show(ui, |ui| {
            let count = app.view.q.len();
            if count > 0 {
                section(ui, &format!("Modes ({count})"), |ui| modes::show(ui, app));
            }
            if app.playback.frame_count() > 0 {
                section(ui, "Animation", |ui| motion::show(ui, app));
            }
            if app.asset().has_skin() {
                section(ui, "Skeleton", |ui| skeleton::show(ui, app));
            }
            section(ui, "Spheres", |ui| spheres::show(ui, app));
            section(ui, "Probe", |ui| probe::show(ui, app));
            section(ui, "Camera", |ui| {
                ui.horizontal(|ui| {
                    wish.fit = style::button(ui, "Show all").clicked();
                    ui.checkbox(&mut app.view.has_mesh, "mesh");
                });
                ui.label(
                    RichText::new("drag: turn  ·  right or shift drag: move  ·  wheel: zoom")
                        .small()
                        .weak(),
                );
            });
        });
    ui.separator();
    if let Some(problem) = &status.problem {
        ui.add(egui::Label::new(RichText::new(problem).color(style::WRONG).small()).truncate())
            .on_hover_text(problem);
    }
    let time = status
        .frame_ms
        .map_or("–".to_string(), |ms| format!("{ms:.1} ms"));
    ui.add(
        egui::Label::new(
            RichText::new(format!("frame {time}  ·  {}", status.adapter))
                .small()
                .weak(),
        )
        .truncate(),
    );
    wish
}

/// A part of the panel that can be folded.
pub(crate) fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    // The number of modes is part of the title, not of the section's name.
    let name = title.split(' ').next().unwrap_or(title).to_string();
    CollapsingHeader::new(RichText::new(title).strong())
        .id_salt(name)
        .default_open(true)
        .show_unindented(ui, |ui| {
            content(ui);
            ui.add_space(4.0);
        });
}

fn facts(ui: &mut Ui, app: &App<'_>) {
    let info = &app.info;
    let cells = [
        ("vertices", info.vertices),
        ("triangles", info.triangles),
        ("nodes", info.nodes),
        ("levels", info.depth),
    ];
    Grid::new("facts")
        .num_columns(4)
        // Columns of egui's own least width are together wider than the panel of a small window.
        .min_col_width(0.0)
        .spacing([10.0, 1.0])
        .show(ui, |ui| {
            for pair in cells.chunks(2) {
                for (name, number) in pair {
                    ui.label(RichText::new(*name).weak());
                    ui.label(grouped(*number as u64));
                }
                ui.end_row();
            }
        });
}

/// A number with its thousands apart: 12 345.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(c);
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_apart() {
        assert_eq!(super::grouped(7), "7");
        assert_eq!(super::grouped(123), "123");
        assert_eq!(super::grouped(1_234_567), "1\u{2009}234\u{2009}567");
    }
}
