//! What plays and halts, and how fast it plays.

use egui::{DragValue, Ui};

use super::style;
use crate::app::Clock;

/// The button is called `play` while the clock halts, else `pause`.
pub(super) fn show(ui: &mut Ui, clock: &mut Clock, [play, pause]: [&str; 2]) {
    ui.horizontal(|ui| {
        let label = if clock.is_playing { pause } else { play };
        if style::button(ui, label).on_hover_text("space").clicked() {
            clock.is_playing = !clock.is_playing;
        }
        ui.add(
            DragValue::new(&mut clock.speed)
                .range(-10.0..=10.0)
                .speed(0.01)
                .prefix("speed ")
                .suffix(" ×")
                .max_decimals(2),
        );
    });
}
