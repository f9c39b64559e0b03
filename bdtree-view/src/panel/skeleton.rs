//! Clips and bones.

use egui::{ComboBox, RichText, Slider, Ui};

use super::{clock, style};
use crate::app::App;

const REST: &str = "at rest";

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    if !app.clips.names.is_empty() || app.has_given_joints() {
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
    let is_given = app.has_given_joints();
    let chosen = app.clips.chosen.and_then(|clip| app.clips.names.get(clip));
    let text = match chosen {
        Some(clip) => &clip.name,
        None if is_given => "joints as given",
        None => REST,
    };
    let text = text.to_string();
    // Given joints are none of what can be chosen: they cannot be had back.
    let now = (!is_given).then_some(app.clips.chosen);
    let mut choice = now;
    ComboBox::from_id_salt("clip")
        .width(ui.available_width() - 16.0)
        .truncate()
        .selected_text(text)
        .show_ui(ui, |ui| {
            ui.selectable_value(&mut choice, Some(None), REST);
            for (i, clip) in app.clips.names.iter().enumerate() {
                let text = format!("{} · {:.2} s", clip.name, clip.duration_s);
                ui.selectable_value(&mut choice, Some(Some(i)), text);
            }
        });
    if let Some(choice) = choice.filter(|_| choice != now) {
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
