//! Levels and their tightness.

use bdtree_render::tightness::Scale;
use egui::{ComboBox, RichText, Slider, Ui};

use super::{grouped, legend, style};
use crate::app::App;

pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) {
    let depth = app.asset().depth();
    ui.horizontal(|ui| {
        let text = |level: Option<usize>| match level {
            Some(level) => format!("level {level}"),
            None => "off".to_string(),
        };
        ComboBox::from_id_salt("level")
            .width(84.0)
            .selected_text(text(app.view.level))
            .show_ui(ui, |ui| {
                for level in std::iter::once(None).chain((0..depth).map(Some)) {
                    ui.selectable_value(&mut app.view.level, level, text(level));
                }
            });
        ui.spacing_mut().slider_width = 90.0;
        ui.add(Slider::new(&mut app.view.opacity, 0.0..=1.0).show_value(false));
        ui.label(RichText::new("opacity").small().weak());
    });
    ui.horizontal(|ui| {
        ui.label(RichText::new("colors").small().weak());
        let scales = [(Scale::Paper, "paper"), (Scale::Viridis, "viridis")];
        for (scale, name) in scales {
            ui.selectable_value(&mut app.view.scale, scale, name);
        }
    });
    match (&app.spheres, app.view.level) {
        (Err(problem), _) => {
            ui.colored_label(style::WRONG, problem);
        }
        (Ok(found), Some(level)) => {
            let numbers = found.mean_and_max.map_or(String::new(), |[mean, max]| {
                format!("  ·  growth mean {mean:.3}, largest {max:.3}")
            });
            let above = found.spheres.iter().filter(|s| s.level < level).count();
            let of_level = grouped((found.spheres.len() - above) as u64);
            let leaves = match above {
                0 => String::new(),
                1 => " and 1 leaf above".to_string(),
                _ => format!(" and {} leaves above", grouped(above as u64)),
            };
            ui.label(format!("{of_level} spheres{leaves}{numbers}"));
        }
        (Ok(_), None) => {}
    }
    if app.view.level.is_some() {
        legend::show(ui, app.view.scale);
    }
}
