//! `info` for people.

use std::fmt::Write;
use std::path::Path;

use super::report::Info;
use crate::output::{Shortest, printable, table};
use crate::q::counted;

/// The facts as aligned lines.
pub(super) fn text(path: &Path, info: &Info) -> String {
    let mut text = String::new();
    let mut fact = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<12} {value}");
    };
    let unknown = || "unknown".to_string();
    fact("file", path.display().to_string());
    fact("format", format!("{}, {} bytes", info.version, info.bytes));
    fact(
        "mesh",
        format!(
            "{} {}, {}",
            info.vertices,
            if info.vertices == 1 {
                "vertex"
            } else {
                "vertices"
            },
            counted(info.triangles, "triangle")
        ),
    );
    let basis = info.basis.as_deref().map_or_else(unknown, printable);
    fact("basis", format!("{basis}, {}", counted(info.modes, "mode")));
    if let Some(error) = &info.basis_error_rel {
        let places = [("frame", error.frame), ("vertex", error.vertex)];
        let place: Vec<String> = places
            .iter()
            .filter_map(|(what, place)| Some(format!("{what} {}", (*place)?)))
            .collect();
        let place = match place.as_slice() {
            [] => String::new(),
            place => format!(" ({})", place.join(", ")),
        };
        fact(
            "basis error",
            format!(
                "largest {}{place}, rms {}, over the diagonal",
                Shortest(error.max),
                Shortest(error.rms)
            ),
        );
    }
    if let Some(highest) = info.highest_frequency_hz {
        fact("basis ends", format!("at {} Hz", Shortest(highest)));
    }
    if let Some(frames) = info.frames {
        let time = match info.duration_s {
            Some(seconds) => format!("{} s", Shortest(seconds)),
            None => "times unknown".to_string(),
        };
        fact("animation", format!("{}, {time}", counted(frames, "frame")));
    }
    fact(
        "tree",
        format!(
            "{}, {}, at most {} a leaf lane",
            counted(info.nodes, "node"),
            counted(info.depth, "level"),
            counted(info.leaf_triangles_max as usize, "triangle")
        ),
    );
    fact(
        "origin",
        info.origin.map(|x| Shortest(x).to_string()).join(" "),
    );
    fact("unit", format!("{} mesh units", Shortest(info.unit)));
    fact(
        "source",
        info.source.name.as_deref().map_or_else(unknown, printable),
    );
    fact("sha-256", info.source.hash.clone().unwrap_or_else(unknown));
    fact(
        "builder",
        info.builder.as_deref().map_or_else(unknown, printable),
    );
    let count = |kind: &str| info.groups.iter().filter(|g| g.kind == kind).count();
    fact(
        "groups",
        format!(
            "{} ({}, {}, {})",
            info.groups.len(),
            counted(count("object"), "object"),
            counted(count("group"), "group"),
            counted(count("material"), "material")
        ),
    );
    modes(&mut text, info);
    places(&mut text, info);
    for (name, value) in info.settings.iter().flatten() {
        let (name, value) = (printable(name), printable(value));
        let _ = writeln!(text, "setting      {name} = {value}");
    }
    for warning in info.warnings.iter().flatten() {
        let _ = writeln!(text, "warning      {}", printable(warning));
    }
    text
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_string).to_vec()
}

fn modes(text: &mut String, info: &Info) {
    if info.modes == 0 {
        return;
    }
    let optional = |x: Option<f64>| x.map_or("-".to_string(), |x| Shortest(x).to_string());
    let mut rows = vec![row([
        "mode",
        "name",
        "frequency [Hz]",
        "modal mass [kg]",
        "default q",
        "q_range",
        "q_limit",
    ])];
    for (j, mode) in info.mode_info.iter().enumerate() {
        rows.push(vec![
            j.to_string(),
            mode.name.as_deref().map_or("-".to_string(), printable),
            optional(mode.frequency_hz),
            optional(mode.modal_mass_kg),
            optional(mode.default_q),
            info.q_range[j].to_string(),
            info.q_limit[j].to_string(),
        ]);
    }
    text.push_str("modes\n");
    text.push_str(&table(&rows));
}

fn places(text: &mut String, info: &Info) {
    let mut rows = vec![row(["kind", "offset", "bytes"])];
    for section in &info.sections {
        rows.push(vec![
            section.kind.clone(),
            section.offset.to_string(),
            section.bytes.to_string(),
        ]);
    }
    text.push_str("sections\n");
    text.push_str(&table(&rows));
    let mut rows = vec![row(["level", "spheres", "mean radius", "largest radius"])];
    let radius = |x: Option<f64>| x.map_or("-".to_string(), |x| format!("{x:.6e}"));
    for level in &info.levels {
        rows.push(vec![
            level.level.to_string(),
            level.spheres.to_string(),
            radius(level.radius_mean),
            radius(level.radius_max),
        ]);
    }
    text.push_str("levels\n");
    text.push_str(&table(&rows));
}
