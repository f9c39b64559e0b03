//! Colours and sizes.

use egui::style::ScrollStyle;
use egui::{
    Button, Color32, Context, Response, RichText, Sense, Stroke, TextStyle, Theme, Ui, Visuals,
    vec2,
};

/// The panel.
pub(crate) const PANEL: Color32 = Color32::from_rgb(243, 244, 247);
/// What is chosen, handles of sliders.
const ACCENT: Color32 = Color32::from_rgb(44, 98, 190);
/// Buttons, which stand out from fields with numbers by a rim, too.
const BUTTON: Color32 = Color32::from_rgb(254, 254, 254);
const RIM: Color32 = Color32::from_rgb(150, 157, 170);
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
        style.spacing.interact_size.x = 62.0;
        style.spacing.item_spacing = vec2(6.0, 4.0);
        // Bars are seen before the pointer is there: they say that there is more.
        style.spacing.scroll = ScrollStyle::thin();
    });
}

/// A button that does something.
pub(crate) fn button(ui: &mut Ui, text: impl Into<RichText>) -> Response {
    ui.scope(|ui| {
        let idle = &mut ui.visuals_mut().widgets.inactive;
        idle.weak_bg_fill = BUTTON;
        idle.bg_stroke = Stroke::new(1.0, RIM);
        ui.add(Button::new(text.into()))
    })
    .inner
}

/// A dot of the color that something has in the picture.
pub(crate) fn swatch(ui: &mut Ui, [r, g, b, _]: [u8; 4]) {
    let (area, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
    let fill = Color32::from_rgb(r, g, b);
    ui.painter().circle_filled(area.center(), 5.0, fill);
}
