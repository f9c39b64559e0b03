//! The scale of tightness.

use bdtree_render::tightness::{GROWTH_RED, Scale};
use egui::{Align2, Color32, FontId, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};

/// Points.
const BAR: f32 = 12.0;
const NUMBERS: f32 = 17.0;
/// Rectangles that the bar is made of.
const STEPS: usize = 110;

pub(super) fn show(ui: &mut Ui, scale: Scale) {
    ui.label(
        RichText::new("growth: radius over that at rest")
            .small()
            .weak(),
    );
    let width = (ui.available_width() - 8.0).max(60.0);
    let (area, _) = ui.allocate_exact_size(vec2(width, BAR + NUMBERS), Sense::hover());
    // Numbers at both ends stick out.
    let (left, right) = (area.left() + 10.0, area.right() - 16.0);
    let painter = ui.painter();
    let at = |share: f64| left + (right - left) * share as f32;
    for step in 0..STEPS {
        let share = |k: f64| (step as f64 + k) / STEPS as f64;
        let [r, g, b] = scale.colour(1.0 + share(0.5) * (GROWTH_RED - 1.0));
        let from = pos2(at(share(0.0)), area.top());
        let to = pos2(at(share(1.0)) + 0.5, area.top() + BAR);
        painter.rect_filled(
            Rect::from_min_max(from, to),
            0.0,
            Color32::from_rgb(r, g, b),
        );
    }
    let weak = ui.visuals().weak_text_color();
    for (k, number) in ["1.00", "1.11", "1.22", "1.33", "1.44+"]
        .into_iter()
        .enumerate()
    {
        let x = at(k as f64 / 4.0);
        let bottom = area.top() + BAR;
        painter.line_segment(
            [pos2(x, bottom), pos2(x, bottom + 3.0)],
            Stroke::new(1.0, weak),
        );
        let font = FontId::proportional(10.0);
        painter.text(
            pos2(x, bottom + 3.0),
            Align2::CENTER_TOP,
            number,
            font,
            weak,
        );
    }
}
