//! Figures of `docs/measured/results.md` that no program prints as they stand there: rows that go through all meshes or work
//! something out, and whether the goals that the project set itself are reached.

use serde_json::{Value, json};

use super::page::fill;
use crate::report::digits;

/// The level of figure 6.
const FIGURE: &str = "/ratios/levels/6/ratios";

/// The objects of a list; none where it was not measured.
fn list<'a>(value: &'a Value, pointer: &str) -> impl Iterator<Item = &'a Value> {
    let list = value.pointer(pointer).and_then(Value::as_array);
    list.into_iter().flatten()
}

/// Name and results of `tables` for each mesh.
fn meshes(measured: &Value) -> impl Iterator<Item = (&str, &Value)> {
    list(measured, "/tables/meshes").filter_map(|mesh| Some((mesh["mesh"].as_str()?, mesh)))
}

/// A text for each mesh behind its name.
fn each(measured: &Value, text: impl Fn(&Value) -> Option<String>) -> String {
    texts(meshes(measured), text)
}

/// The same, the bridge first: the paper has its figure 6 alone.
fn bridge_first(measured: &Value, text: impl Fn(&Value) -> Option<String>) -> String {
    let mut all: Vec<_> = meshes(measured).collect();
    all.sort_by_key(|(name, _)| *name != "bridge");
    texts(all.into_iter(), text)
}

fn texts<'a>(
    meshes: impl Iterator<Item = (&'a str, &'a Value)>,
    text: impl Fn(&Value) -> Option<String>,
) -> String {
    let all = meshes.map(|(name, mesh)| {
        let text = text(mesh).unwrap_or("?".to_string());
        format!("{name} {text}")
    });
    all.collect::<Vec<_>>().join(", ")
}

/// By number of the row.
pub(super) fn of_rows(measured: &Value) -> Value {
    let filled = |text: &str| each(measured, |mesh| Some(fill(text, mesh)));
    let as_figure = bridge_first(measured, |mesh| {
        let there = mesh.pointer("/crossings/0/paper_as_in_its_figure")?;
        let Some(share) = there["amplitude"].as_f64() else {
            return Some("at no amplitude measured".to_string());
        };
        let text = fill("layered {/layered}, ours {/ours}", there);
        Some(format!("{text} ({:.1} % of the diagonal)", 100.0 * share))
    });
    let largest = bridge_first(measured, |mesh| {
        let natural = list(mesh, FIGURE).filter(|case| case["deformation"] == "natural");
        let text = "layered {/layered/mean} / {/layered/max}, paper's bound {/paper/mean} / {/paper/max}, \
                    ours {/ours/mean} / {/ours/max}";
        Some(fill(text, natural.last()?))
    });
    let decay = each(measured, |mesh| {
        let falls = mesh["decay"]["paper"]["falls"] == true;
        let rises = if falls { "" } else { " (not on every level)" };
        Some(fill("{/decay/paper/by_level/10}", mesh) + rises)
    });
    let above_common = each(measured, |mesh| {
        let share = mesh["appendix_a"][0]["share_above_common"].as_f64()?;
        Some(format!("{} %", digits(100.0 * share)))
    });
    let sizes = list(measured, "/growth/size/rows");
    let sizes: Vec<String> = sizes
        .map(|row| fill("{/times/speedup} at {/triangles}", row))
        .collect();
    let number = |pointer: &str| measured.pointer(pointer).and_then(Value::as_f64);
    // 3601 chairs, 25 000 steps.
    let days = |ms: f64| ms * 3601.0 * 25_000.0 / 86_400_000.0;
    json!({
        "P04": filled("{/spheres}"),
        "P05": filled("{/levels} (ours, of eight: {/our_levels})"),
        "P08": filled("{/ratios/least_layered_over_wrapped_of_inner_levels}"),
        "P09": bridge_first(measured, |mesh| {
            let text = "{/ratios/levels/6/ratios/0/layered/mean} / {/ratios/levels/6/ratios/0/layered/max}";
            Some(fill(text, mesh))
        }),
        "P10": {"as_figure": as_figure, "largest": largest},
        "P21": decay,
        "P22": filled("{/appendix_a/0/largest} and {/appendix_a/1/largest}"),
        "P23": above_common,
        "P41": sizes.join(", "),
        "P47": number("/updates/times/layered_ms").map(days),
        "P50": filled("{/vertices} V / {/triangles} F, M = {/modes}"),
    })
}

/// Of each goal whether it is reached, else what does not reach it.
pub(super) fn of_goals(measured: &Value) -> Vec<String> {
    let at = |pointer: &str, limit: f64| {
        let value = measured.pointer(pointer).and_then(Value::as_f64);
        below(value, limit)
    };
    let chair = meshes(measured).find(|(name, _)| *name == "chair");
    let over = chair.and_then(|(_, chair)| {
        let over = chair.pointer("/decay/paper/level_10_over_the_papers")?;
        over.as_f64()
    });
    let all = [
        rising(measured),
        below(over.map(|over| over.max(1.0 / over)), 3.0),
        tight_layered(measured),
        loose(measured, "/crossings", |crossing| {
            (String::new(), &crossing["paper_as_in_its_figure"])
        }),
        loose(measured, FIGURE, |case| {
            let share = case["amplitude"].as_f64().map_or(f64::NAN, |a| 100.0 * a);
            (format!(", {share} %"), case)
        }),
        at("/growth/size/exponent_nodes", 0.3),
        at("/curtain/contenders/0/times/ms_per_frame", 0.022),
    ];
    all.map(|failures| verdict(&failures)).into()
}

/// Whether a goal is reached, by what does not reach it.
fn verdict(failures: &[String]) -> String {
    match failures {
        [] => "reached".to_string(),
        all => format!("**not reached**: {}", all.join("; ")),
    }
}

/// Whether a figure is below its limit.
pub(super) fn reached(value: Option<f64>, limit: f64) -> String {
    verdict(&below(value, limit))
}

/// A figure that is not below its limit, or was not measured.
fn below(value: Option<f64>, limit: f64) -> Vec<String> {
    match value {
        Some(value) if value < limit => Vec::new(),
        value => vec![value.map_or("not measured".to_string(), digits)],
    }
}

/// Meshes where ‖ΔR‖ does not fall from level to level: ours, on the chair the paper's too.
fn rising(measured: &Value) -> Vec<String> {
    let rising = meshes(measured).filter_map(|(name, mesh)| {
        let who = if name == "chair" { "paper" } else { "ours" };
        let both = ["ours", who].map(|who| mesh["decay"][who]["falls"] == true);
        both.contains(&false).then(|| name.to_string())
    });
    rising.collect()
}

/// Meshes where layered spheres are no larger than wrapped ones.
fn tight_layered(measured: &Value) -> Vec<String> {
    let small = meshes(measured).filter_map(|(name, mesh)| {
        let least = mesh["ratios"]["least_layered_over_wrapped_of_inner_levels"].as_f64()?;
        (!(least > 1.0)).then(|| format!("{name} {}", digits(least)))
    });
    small.collect()
}

/// Ours beside layered, where they are not smaller, in a list of each mesh: `means` says how far an item is deformed and
/// where its means are.
fn loose<'a>(
    measured: &'a Value,
    items: &str,
    means: impl Fn(&'a Value) -> (String, &'a Value),
) -> Vec<String> {
    let mut loose = Vec::new();
    for (name, mesh) in meshes(measured) {
        for item in list(mesh, items) {
            let (share, value) = means(item);
            let mean = |who: &str| value[who]["mean"].as_f64().or(value[who].as_f64());
            if let (Some(layered), Some(ours)) = (mean("layered"), mean("ours"))
                && !(ours < layered)
            {
                let way = item["deformation"].as_str().unwrap_or("?");
                let (ours, layered) = (digits(ours), digits(layered));
                loose.push(format!("{name}, {way}{share}: {ours} beside {layered}"));
            }
        }
    }
    loose
}
