//! The probe and what it found.

use egui::{DragValue, Grid, RichText, Ui};

use super::{grouped, style};
use crate::app::App;
use crate::shapes::{CONTACT, ENDS, PROBE};

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    let size = app.place.size;
    let view = &mut app.view;
    ui.horizontal(|ui| {
        style::swatch(ui, PROBE);
        ui.checkbox(&mut view.has_probe, "ball");
        ui.add_enabled_ui(view.has_probe, |ui| {
            style::swatch(ui, ENDS);
            ui.checkbox(&mut view.has_ends, "where the query ended");
        });
    });
    if !view.has_probe {
        return;
    }
    let decimals = decimals(size);
    ui.horizontal_wrapped(|ui| {
        for (k, name) in ["x ", "y ", "z "].into_iter().enumerate() {
            ui.add(length(&mut view.probe.center[k], size).prefix(name));
        }
        ui.add(
            length(&mut view.probe.radius, size)
                .prefix("r ")
                .range(0.0..=10.0 * size),
        );
    });
    let nodes = app.asset().node_count() as u64;
    match &app.answer {
        Some(Ok(answer)) => {
            let depth = answer.depth();
            let depth = depth.map_or("–".to_string(), |depth| format!("{depth:.decimals$}"));
            let lines = [
                ("contacts", grouped(answer.contacts.len() as u64)),
                ("deepest", depth),
                (
                    "nodes visited",
                    format!("{} of {}", grouped(answer.nodes_visited), grouped(nodes)),
                ),
                (
                    "query",
                    format!("{:.1} µs", 1e6 * answer.time.as_secs_f64()),
                ),
            ];
            Grid::new("answer")
                .num_columns(2)
                .spacing([10.0, 1.0])
                .show(ui, |ui| {
                    for (k, (name, value)) in lines.into_iter().enumerate() {
                        ui.label(RichText::new(name).weak());
                        ui.horizontal(|ui| {
                            ui.label(value);
                            if k == 0 {
                                style::swatch(ui, CONTACT);
                            }
                        });
                        ui.end_row();
                    }
                });
        }
        Some(Err(problem)) => {
            ui.colored_label(style::WRONG, problem);
        }
        None => {}
    }
}

/// A number to drag that a mouse moves as fast as an object of this size needs.
fn length(x: &mut f64, size: f64) -> DragValue<'_> {
    DragValue::new(x)
        .speed(0.005 * size)
        .max_decimals(decimals(size))
}

/// Decimals that lengths of an object of this size need.
fn decimals(size: f64) -> usize {
    (3.0 - size.log10().floor()).clamp(0.0, 12.0) as usize
}
