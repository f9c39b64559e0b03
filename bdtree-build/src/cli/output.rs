//! The summary that people read, or the JSON object that machines read.

use std::io::{ErrorKind, StdoutLock, Write};
use std::path::Path;
use std::process::ExitCode;

use bdtree_build::report::BakeReport;
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
    if let Some(e) = &r.elastic {
        writeln!(
            out,
            "elastic: {} of {:.4} ({} along the longest side), {}, {:.4} kg",
            counted(e.cells, "cell"),
            e.cell_size,
            e.resolution,
            counted(e.dofs, "unknown"),
            e.mass_kg
        )?;
    }
    if let Some(v) = &r.volume {
        writeln!(
            out,
            "volume: {} on {}, {}, {:.4} kg",
            counted(v.elements, "element"),
            counted(v.nodes, "node"),
            counted(v.dofs, "unknown"),
            v.mass_kg
        )?;
    }
    if let Some(hz) = &r.frequencies_hz {
        let text: Vec<String> = hz.iter().map(|f| format!("{f:.4}")).collect();
        writeln!(out, "frequencies (Hz): {}", text.join(" "))?;
        let end = hz.iter().fold(0.0, |m: f64, f| m.max(*f));
        writeln!(
            out,
            "the basis ends at {end:.4} Hz: faster motion is left out"
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
