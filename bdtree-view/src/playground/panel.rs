//! The controls beside the picture.

use egui::{DragValue, Grid, Label, RichText, ScrollArea, Slider, Ui};

use super::picture::CONTACT;
use super::play::Playground;
use crate::panel::{Status, grouped, section, style};

/// What was asked for that needs to know where the picture's middle is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Wish {
    pub(super) drops: bool,
    pub(super) throws: bool,
    pub(super) fits: bool,
}

/// Shows all controls.
pub(super) fn show(ui: &mut Ui, play: &mut Playground, status: &Status) -> Wish {
    let mut wish = Wish::default();
    ui.label(RichText::new("Playground").size(17.0).strong());
    let height = (ui.available_height() - 62.0).max(60.0);
    ScrollArea::vertical()
        .max_height(height)
        .auto_shrink([false, false])
        .show(ui, |ui| {
            section(ui, "Bodies", |ui| bodies(ui, play, &mut wish));
            section(ui, "Time", |ui| time(ui, play));
            section(ui, "State", |ui| state(ui, play));
            section(ui, "Picture", |ui| {
                ui.horizontal_wrapped(|ui| {
                    wish.fits = style::button(ui, "Show all").clicked();
                    style::swatch(ui, CONTACT);
                    ui.checkbox(&mut play.has_contacts, "contacts");
                });
                weak(
                    ui,
                    "drag: turn  ·  right or shift drag: move  ·  wheel: zoom",
                );
            });
        });
    ui.separator();
    footer(ui, play, status);
    wish
}

fn weak(ui: &mut Ui, text: impl Into<String>) {
    ui.label(RichText::new(text).small().weak());
}

fn bodies(ui: &mut Ui, play: &mut Playground, wish: &mut Wish) {
    let mut chosen = play.chosen;
    for (k, kind) in play.simulation.kinds().iter().enumerate() {
        let text = match &kind.able {
            Ok(_) => RichText::new(&kind.name),
            Err(_) => RichText::new(&kind.name).color(style::WRONG),
        };
        let response = ui.radio(chosen == k, text);
        if response.clicked() {
            chosen = k;
        }
        match &kind.able {
            Ok(able) => response.on_hover_text(format!("reaches {:.3} m", able.reach)),
            Err(problem) => response.on_hover_text(problem),
        };
    }
    play.choose(chosen);
    if let Some(Err(problem)) = play.simulation.kinds().get(chosen).map(|k| &k.able) {
        let text = RichText::new(format!("cannot fall: {problem}"));
        ui.label(text.small().color(style::WRONG));
    }
    ui.horizontal_wrapped(|ui| {
        wish.drops = style::button(ui, "Drop")
            .on_hover_text("D, or a click")
            .clicked();
        wish.throws = style::button(ui, "Throw").on_hover_text("T").clicked();
        ui.add(
            DragValue::new(&mut play.speed)
                .range(0.1..=100.0)
                .speed(0.05)
                .suffix(" m/s")
                .max_decimals(1),
        );
    });
    weak(ui, "click: drop above  ·  drag a body: pull, let go: throw");
    weak(ui, "at the pointer  D drop  T throw  P poke  Del remove");
}

fn time(ui: &mut Ui, play: &mut Playground) {
    ui.horizontal_wrapped(|ui| {
        let label = if play.pace.is_running { "Pause" } else { "Run" };
        if style::button(ui, label).on_hover_text("space").clicked() {
            play.pace.toggle();
        }
        if style::button(ui, "Step").on_hover_text(".").clicked() {
            play.pace.step_once();
        }
        if style::button(ui, "Reset")
            .on_hover_text("R: the beginning")
            .clicked()
        {
            play.reset();
        }
        if style::button(ui, "Remove all").clicked() {
            play.clear();
        }
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = 90.0;
        ui.add(
            Slider::new(&mut play.pace.speed, 0.01..=1.0)
                .logarithmic(true)
                .suffix(" ×")
                .max_decimals(2),
        )
        .on_hover_text("slow motion: simulated seconds per second");
    });
    let reached = match play.pace.reached() {
        Some(reached) => format!(", {reached:.2} × the clock"),
        None => String::new(),
    };
    let world = play.simulation.world();
    let time_s = world.steps() as f64 * world.options().step_s;
    weak(
        ui,
        format!("{time_s:.2} s, step {}{reached}", world.steps()),
    );
}

fn state(ui: &mut Ui, play: &mut Playground) {
    let report = play.simulation.report();
    let energy = play.simulation.world().energy();
    let cells = [
        ("bodies", grouped(play.simulation.of().len() as u64)),
        ("contacts", grouped(report.events)),
        ("kinetic", joules(energy.kinetic)),
        ("potential", joules(energy.potential)),
        ("modes", joules(energy.modal)),
        ("in contacts", joules(report.contact_energy)),
    ];
    Grid::new("state")
        .num_columns(4)
        .min_col_width(0.0)
        .spacing([10.0, 1.0])
        .show(ui, |ui| {
            for pair in cells.chunks(2) {
                for (name, value) in pair {
                    ui.label(RichText::new(*name).weak());
                    ui.label(value);
                }
                ui.end_row();
            }
        });
    if play.checkpoint.is_some() && style::button(ui, "Save").clicked() {
        play.save();
    }
}

/// An energy in a few characters.
fn joules(x: f64) -> String {
    match x.abs() {
        m if m < 0.005 => "0 J".to_string(),
        m if m < 9.995 => format!("{x:.2} J"),
        m if m < 99.95 => format!("{x:.1} J"),
        m if m < 1e5 => format!("{x:.0} J"),
        _ => format!("{x:.1e} J"),
    }
}

/// How long frames take, and what draws.
fn footer(ui: &mut Ui, play: &Playground, status: &Status) {
    let ms = |mean: Option<f64>| mean.map_or("–".to_string(), |ms| format!("{ms:.1} ms"));
    let times = &play.times;
    let steps = times
        .steps
        .map_or(String::new(), |n| format!(" for {n:.1} steps"));
    let lines = [
        format!("simulation {}{steps}", ms(times.simulation)),
        format!(
            "drawing {}  ·  frame {}",
            ms(times.drawing),
            ms(status.frame_ms)
        ),
        status.adapter.clone(),
    ];
    ui.spacing_mut().item_spacing.y = 1.0;
    for line in lines {
        ui.add(Label::new(RichText::new(line).small().weak()).truncate());
    }
}

#[cfg(test)]
mod tests {
    use super::joules;

    #[test]
    fn energies_are_short() {
        let all = [0.0, 0.012, -3.456, 42.0, 1234.5, 2.5e7].map(joules);
        assert_eq!(
            all,
            ["0 J", "0.01 J", "-3.46 J", "42.0 J", "1234 J", "2.5e7 J"]
        );
    }
}
