//! Colours and sizes.

use egui::{Color32, Context, Stroke, TextStyle, Theme, Visuals, vec2};

/// The panel.
pub(crate) const PANEL: Color32 = Color32::from_rgb(243, 244, 247);
/// What is chosen, handles of sliders.
const ACCENT: Color32 = Color32::from_rgb(44, 98, 190);
/// Text about what is wrong.
pub(crate) const WRONG: Color32 = Color32::from_rgb(190, 24, 40);

/// Gives a context the viewer's looks: light, as the pictures are.
pub(crate) fn dress(context: &Context) {
    context.set_theme(Theme::Light);
    context.style_mut_of(Theme::Light, |style| {
        style.visuals = Visuals::light();
        let visuals = &mut style.visuals;
        visuals.panel_fill = PANEL;
        visuals.override_text_color = Some(Color32::from_rgb(34, 38, 46));
        visuals.weak_text_color = Some(Color32::from_rgb(108, 114, 126));
        visuals.selection.bg_fill = ACCENT.gamma_multiply(0.55);
        visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(20, 50, 110));
        visuals.slider_trailing_fill = true;
        visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(214));
        visuals.widgets.inactive.bg_fill = Color32::from_rgb(218, 222, 230);
        visuals.widgets.inactive.weak_bg_fill = Color32::from_rgb(226, 229, 236);
        if let Some(font) = style.text_styles.get_mut(&TextStyle::Small) {
            font.size = 11.0;
        }
        // Numbers beside sliders are as wide with a sign as without.
        style.spacing.interact_size.x = 56.0;
        style.spacing.item_spacing = vec2(6.0, 4.0);
        style.spacing.slider_width = 94.0;
    });
}
