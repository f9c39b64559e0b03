//! The summary that people read, or the JSON object that machines read.

use std::io::{ErrorKind, StdoutLock, Write};
use std::path::Path;
use std::process::ExitCode;

use bdtree_build::report::{BakeReport, LevelTightness};
use serde::Serialize;

/// Warnings shown to people; `--json` and the file's metadata have all.
const WARNINGS_SHOWN: usize = 10;

/// The report's fields, and where the file is.
#[derive(Serialize)]
struct Json<'d> {
    output: String,
    #[serde(flatten)]
    report: &'d BakeReport,
}

/// The first warnings, on stderr.
pub(super) fn print_warnings(warnings: &[String]) {
    for warning in warnings.iter().take(WARNINGS_SHOWN) {
        eprintln!("bdtree-build: warning: {warning}");
    }
    let more = warnings.len().saturating_sub(WARNINGS_SHOWN);
    if more > 0 {
        let more = counted(more, "more warning");
        eprintln!("bdtree-build: {more} (--json shows all)");
    }
}

/// `1 node`, `2 nodes`.
fn counted(n: usize, what: &str) -> String {
    match (n, what) {
        (1, _) => format!("1 {what}"),
        (_, "vertex") => format!("{n} vertices"),
        _ => format!("{n} {what}s"),
    }
}

/// Prints the summary or the object.
pub(super) fn print(output: &Path, report: &BakeReport, json: bool, quiet: bool) -> ExitCode {
    if !quiet && !json {
        print_warnings(&report.warnings);
    }
    to_stdout(|out| {
        if json {
            let output = output.display().to_string();
            writeln!(out, "{}", serde_json::to_string(&Json { output, report })?)
        } else if quiet {
            Ok(())
        } else {
            summary(output, report, out)
        }
    })
}

/// Prints to standard output. A reader that closes the pipe is no error; a full disk is one, though what was to be done
/// is done.
pub(super) fn to_stdout(
    write: impl FnOnce(&mut StdoutLock<'_>) -> std::io::Result<()>,
) -> ExitCode {
    let mut out = std::io::stdout().lock();
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("bdtree-build: standard output: {error}");
            ExitCode::from(1)
        }
        _ => ExitCode::SUCCESS,
    }
}

/// At most four significant digits.
fn digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 | 1e-4..1e7 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// What the tightness of all levels means for queries.
fn verdict(levels: &[LevelTightness]) -> String {
    let mean = levels.iter().map(|level| level.mean).sum::<f64>() / levels.len() as f64;
    let meaning = match mean {
        m if m <= 1.5 => "tight",
        m if m <= 3.0 => "fair",
        _ => "loose: queries visit many nodes; use fewer modes or a smaller --range-rel",
    };
    format!(
        "bounds: spheres are {mean:.2} times as large as the smallest possible ones at q_range, {meaning}"
    )
}

fn summary(output: &Path, r: &BakeReport, out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "{}: {}, {}, {}; {} in {}; {} bytes",
        output.display(),
        counted(r.vertices, "vertex"),
        counted(r.triangles, "triangle"),
        counted(r.modes, "mode"),
        counted(r.nodes, "node"),
        counted(r.depth, "level"),
        r.bytes
    )?;
    let size = [0, 1, 2].map(|k| r.bounds[1][k] - r.bounds[0][k]);
    let diagonal = size.iter().map(|x| x * x).sum::<f64>().sqrt();
    writeln!(
        out,
        "size: {} x {} x {} mesh units, diagonal {}{}",
        digits(size[0]),
        digits(size[1]),
        digits(size[2]),
        digits(diagonal),
        r.scale_m.map_or(String::new(), |scale| format!(
            "; 1 mesh unit = {scale} m (--scale)"
        ))
    )?;
    if let Some(e) = &r.elastic {
        writeln!(
            out,
            "elastic: {} of {} ({} along the longest side), {}, {} kg",
            counted(e.cells, "cell"),
            digits(e.cell_size),
            e.resolution,
            counted(e.dofs, "unknown"),
            digits(e.mass_kg)
        )?;
    }
    if let Some(v) = &r.volume {
        writeln!(
            out,
            "volume: {} on {}, {}, {} kg",
            counted(v.elements, "element"),
            counted(v.nodes, "node"),
            counted(v.dofs, "unknown"),
            digits(v.mass_kg)
        )?;
    }
    if let Some(hz) = &r.frequencies_hz {
        let text: Vec<String> = hz.iter().map(|f| digits(*f)).collect();
        writeln!(out, "frequencies (Hz): {}", text.join(" "))?;
        let end = hz.iter().fold(0.0, |m: f64, f| m.max(*f));
        writeln!(
            out,
            "the basis ends at {} Hz: faster motion is left out",
            digits(end)
        )?;
    }
    if let (Some(joints), Some(bones), Some(most), Some(clips)) =
        (r.joints, r.bones, r.influences_max, r.clips)
    {
        writeln!(
            out,
            "skin: {}, {}, at most {} of a vertex, {}",
            counted(joints, "joint"),
            counted(bones, "bone"),
            counted(most, "influence"),
            counted(clips, "clip")
        )?;
    }
    if let Some(frames) = r.frames {
        writeln!(out, "animation: {}", counted(frames, "frame"))?;
    }
    if let Some(e) = &r.basis_error_rel {
        let frame = e.frame.map_or(String::new(), |t| format!(" in frame {t}"));
        writeln!(
            out,
            "error of the basis over the box diagonal: at most {:.3e} (vertex {}{frame}), rms {:.3e}",
            e.max_rel, e.vertex, e.rms_rel
        )?;
    }
    if !r.tightness.is_empty() {
        let text: Vec<String> = r
            .tightness
            .iter()
            .map(|t| format!("{:.3}", t.mean))
            .collect();
        writeln!(out, "tightness R'/R_opt per level: {}", text.join(" "))?;
        writeln!(out, "{}", verdict(&r.tightness))?;
    }
    let mut stages: Vec<(&String, &f64)> = r.stages.iter().collect();
    stages.sort_by(|a, b| b.1.total_cmp(a.1));
    let text: Vec<String> = stages
        .iter()
        .map(|(name, seconds)| format!("{name} {seconds:.2}"))
        .collect();
    writeln!(
        out,
        "seconds: {} (total {:.2})",
        text.join(", "),
        r.stages.values().sum::<f64>()
    )
}
