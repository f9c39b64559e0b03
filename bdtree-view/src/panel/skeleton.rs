//! Clips and bones.

use egui::{ComboBox, RichText, Slider, Ui};

use super::{clock, style};
use crate::app::App;

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    if !app.clips.names.is_empty() {
        choice(ui, app);
    }
    if app.clips.chosen.is_some() {
        moment(ui, app);
    }
    let joints = app.asset().joint_count();
    ui.checkbox(&mut app.view.has_bones, format!("bones ({joints} joints)"));
    if let Some(problem) = &app.clips.problem {
        ui.colored_label(style::WRONG, problem);
    }
}

/// Which clip.
fn choice(ui: &mut Ui, app: &mut App<'_>) {
    let rest = "at rest".to_string();
    let chosen = app.clips.chosen.and_then(|clip| app.clips.names.get(clip));
    let text = chosen.map_or(rest.clone(), |clip| clip.name.clone());
    let mut choice = app.clips.chosen;
    ComboBox::from_id_salt("clip")
        .width(ui.available_width() - 16.0)
        .truncate()
        .selected_text(text)
        .show_ui(ui, |ui| {
            ui.selectable_value(&mut choice, None, rest);
            for (i, clip) in app.clips.names.iter().enumerate() {
                let text = format!("{} · {:.2} s", clip.name, clip.duration_s);
                ui.selectable_value(&mut choice, Some(i), text);
            }
        });
    if choice != app.clips.chosen {
        app.clips.choose(choice);
        app.show_clip();
    }
}

/// When.
fn moment(ui: &mut Ui, app: &mut App<'_>) {
    let duration = app.clips.duration_s();
    clock::show(ui, &mut app.clips.clock, ["Play clip", "Pause clip"]);
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = ui.available_width() - 110.0;
        let mut time_s = app.clips.clock.time_s;
        let slider = Slider::new(&mut time_s, 0.0..=duration).show_value(false);
        if ui.add(slider).changed() {
            app.clips.clock.is_playing = false;
            app.clips.clock.time_s = time_s;
            app.show_clip();
        }
        let text = format!("{:.3} / {duration:.3} s", app.clips.clock.time_s);
        ui.label(RichText::new(text).small().weak());
    });
}
