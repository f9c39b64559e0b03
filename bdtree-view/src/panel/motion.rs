//! The animation's controls.

use egui::{RichText, Slider, Ui};

use super::clock;
use crate::app::App;

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    let count = app.playback.frame_count();
    clock::show(ui, &mut app.playback.clock, ["Play", "Pause"]);
    let (frame, share) = app.playback.position();
    let mut chosen = frame;
    ui.horizontal(|ui| {
        // What is left of it says which frame it is.
        ui.spacing_mut().slider_width = ui.available_width() - 90.0;
        let slider = Slider::new(&mut chosen, 0..=count - 1).show_value(false);
        if ui.add(slider).changed() {
            app.playback.clock.is_playing = false;
            app.playback.go_to(chosen);
            app.show_moment();
        }
        ui.label(match app.shows_moment() {
            true => format!("{:.1} / {}", frame as f64 + share, count - 1),
            false => format!("– / {}", count - 1),
        });
    });
    if !app.shows_moment() {
        let hint = "what is shown is q as set, not a frame";
        ui.label(RichText::new(hint).small().weak());
        return;
    }
    let time = format!(
        "{:.3} s of {:.3} s{}",
        app.playback.clock.time_s,
        app.playback.duration_s(),
        if app.playback.is_timed {
            ""
        } else {
            ", 30 frames a second assumed"
        },
    );
    ui.label(RichText::new(time).small().weak());
}
