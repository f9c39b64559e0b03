//! The text of `docs/results.md`.

use std::fmt::Write;

use bdtree_baselines::machine;
use serde_json::Value;

use super::measured::Measured;
use super::rows::{Built, SECTIONS};
use crate::report::{Report, commit, digits};

/// The command of the page.
const COMMAND: &str = "cargo run --release -p bdtree-scenes --bin results";

/// The file of a picture below `images/`.
pub(super) fn picture(report: &Report, key: &str) -> String {
    let dash = if key.is_empty() { "" } else { "-" };
    format!("{}{dash}{key}.svg", report.name)
}

/// What the project set itself to reach in these experiments, and whether it does.
fn goals(measured: &Measured) -> String {
    let mut text = "\n## Goals\n\n".to_string();
    let mut says = |goal: &str, failures: &[String]| {
        let verdict = match failures {
            [] => "reached".to_string(),
            all => format!("**not reached**: {}", all.join("; ")),
        };
        let _ = writeln!(text, "* {goal}: {verdict}.");
    };
    let meshes: Vec<&Value> = measured
        .meshes()
        .iter()
        .filter_map(|n| measured.mesh(n))
        .collect();
    let name = |mesh: &Value| mesh["mesh"].as_str().unwrap_or("?").to_string();
    let chair = measured
        .mesh("chair")
        .map_or(&Value::Null, |mesh| &mesh["decay"]["paper"]);
    let rises = if chair["falls"] == true {
        vec![]
    } else {
        vec!["it rises".to_string()]
    };
    says("the chair's ‖ΔR‖ falls from level to level", &rises);
    let over = chair["level_10_over_the_papers"]
        .as_f64()
        .unwrap_or(f64::NAN);
    let far = if (1.0 / 3.0..3.0).contains(&over) {
        vec![]
    } else {
        vec![digits(over)]
    };
    says("at level 10 it is within three times the paper's", &far);
    let small = meshes.iter().filter_map(|mesh| {
        let least = mesh["ratios"]["least_layered_over_wrapped_of_inner_levels"].as_f64()?;
        (!(least > 1.0)).then(|| format!("{} {}", name(mesh), digits(least)))
    });
    says(
        "layered spheres are larger than wrapped ones on every inner level, in the mean",
        &small.collect::<Vec<_>>(),
    );
    let mut loose = Vec::new();
    for mesh in &meshes {
        let cases = mesh["ratios"]["levels"][6]["ratios"].as_array();
        for case in cases.into_iter().flatten() {
            let [layered, ours] = ["layered", "ours"].map(|who| case[who]["mean"].as_f64());
            if ours >= layered {
                let share = case["amplitude"].as_f64().map_or(f64::NAN, |a| 100.0 * a);
                let way = case["deformation"].as_str().unwrap_or("?");
                let [layered, ours] = [layered, ours].map(|x| x.map_or("?".to_string(), digits));
                loose.push(format!(
                    "{}, {way}, {share} %: {ours} beside {layered}",
                    name(mesh)
                ));
            }
        }
    }
    says(
        "our spheres are smaller than layered ones at every amplitude up to 20 %, in the mean of figure 6's level",
        &loose,
    );
    let exponent = measured
        .number("/growth/size/exponent_nodes")
        .unwrap_or(f64::NAN);
    let steep = if exponent < 0.3 {
        vec![]
    } else {
        vec![digits(exponent)]
    };
    says(
        "visited nodes grow with less than the power 0.3 of the triangles",
        &steep,
    );
    let frame = measured
        .contender("ours", "/times/ms_per_frame")
        .unwrap_or(f64::NAN);
    let slow = if frame < 0.022 {
        vec![]
    } else {
        vec![digits(frame)]
    };
    says(
        "ball and curtain take less than the paper's 0.022 ms a frame",
        &slow,
    );
    let rest = measured
        .number("/pile/times/at_rest_over_rigid")
        .unwrap_or(f64::NAN);
    let much = if rest < 1.2 {
        vec![]
    } else {
        vec![digits(rest)]
    };
    says("updates that change nothing cost less than 20 %", &much);
    text
}

/// The page.
pub(super) fn page(measured: &Measured, reports: &[Report]) -> String {
    let all = || SECTIONS.iter().flat_map(|(_, rows)| rows.iter());
    let count = |built: Built| all().filter(|row| row.built == built).count();
    let missing: Vec<&str> = all()
        .filter(|r| r.built == Built::Not)
        .map(|r| r.id)
        .collect();
    let mut text = format!(
        "# The paper's figures and ours\n\n\
         D. L. James and D. K. Pai, *BD-Tree: Output-Sensitive Collision Detection for Reduced Deformable \
         Models*, SIGGRAPH 2004, row by row. Written by\n\n    {COMMAND}\n\n\
         on {}, at commit `{}`. Counts and radii are the same in every run; times are medians, and of a machine \
         that does other work. A program named in the last column is `cargo run --release -p bdtree-scenes --bin NAME`, \
         with its own `--help`; a test is checked to exist when this page is written.\n\n\
         {} rows are shown, {} in part, {} not built yet: {}.\n",
        machine::processor(),
        commit(),
        count(Built::Whole),
        count(Built::Part),
        missing.len(),
        missing.join(", "),
    );
    text += &goals(measured);
    for (section, rows) in SECTIONS {
        let _ = write!(
            text,
            "\n## {section}\n\n| row | what | the paper | ours | shown by |\n|---|---|---|---|---|\n"
        );
        for row in rows {
            let shown: Vec<String> = row.shown.iter().map(|s| s.markdown()).collect();
            let shown = match row.built {
                Built::Not => "not built yet".to_string(),
                Built::Part => format!("in part: {}", shown.join(", ")),
                Built::Whole => shown.join(", "),
            };
            let ours = (row.ours)(measured).replace('|', "\\|");
            let what = row.what.replace('|', "\\|");
            let _ = writeln!(
                text,
                "| {} | {what} | {} | {ours} | {shown} |",
                row.id, row.paper
            );
        }
    }
    for report in reports {
        let _ = write!(
            text,
            "\n## What `{}` prints\n\n{}",
            report.name,
            report.markdown()
        );
        for (key, _) in &report.pictures {
            let file = picture(report, key);
            let _ = write!(text, "\n![Curves of {}](images/{file})\n", report.name);
        }
    }
    text
}
