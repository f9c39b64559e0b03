//! The summary that people read, or the JSON object that machines read.

use bdtree_build::basis::elastic::ElasticReport;
use bdtree_build::basis::volume::VolumeReport;
use serde::Serialize;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use super::Done;

/// Warnings shown to people; `--json` and the file's metadata have all.
const WARNINGS_SHOWN: usize = 10;

/// The report's fields, and what is beyond the contract.
#[derive(Serialize)]
struct Json<'d> {
    output: String,
    #[serde(flatten)]
    report: &'d bdtree_build::report::BakeReport,
    elastic: Option<ElasticJson>,
    volume: Option<VolumeJson>,
}

#[derive(Serialize)]
struct ElasticJson {
    resolution: u32,
    cells: usize,
    dofs: usize,
    components: usize,
    cell_size: f64,
    predicted_bytes: u64,
    mass_kg: f64,
    residual_max: f64,
    inertia_checked: bool,
    pieces_without_mode: Vec<PieceJson>,
}

#[derive(Serialize)]
struct PieceJson {
    first_triangle: u32,
    triangles: u32,
}

impl From<&ElasticReport> for ElasticJson {
    fn from(r: &ElasticReport) -> Self {
        Self {
            resolution: r.resolution,
            cells: r.cells,
            dofs: r.dofs,
            components: r.components,
            cell_size: r.cell_size,
            predicted_bytes: r.predicted_bytes,
            mass_kg: r.mass_kg,
            residual_max: r.residual_max,
            inertia_checked: r.inertia_checked,
            pieces_without_mode: r
                .pieces_without_mode
                .iter()
                .map(|piece| PieceJson {
                    first_triangle: piece.first_triangle,
                    triangles: piece.triangle_count,
                })
                .collect(),
        }
    }
}

#[derive(Serialize)]
struct VolumeJson {
    elements: usize,
    nodes: usize,
    dofs: usize,
    components: usize,
    predicted_bytes: u64,
    mass_kg: f64,
    residual_max: f64,
    inertia_checked: bool,
}

impl From<&VolumeReport> for VolumeJson {
    fn from(r: &VolumeReport) -> Self {
        Self {
            elements: r.elements,
            nodes: r.nodes,
            dofs: r.dofs,
            components: r.components,
            predicted_bytes: r.predicted_bytes,
            mass_kg: r.mass_kg,
            residual_max: r.residual_max,
            inertia_checked: r.inertia_checked,
        }
    }
}

/// The first warnings, on stderr.
pub(super) fn print_warnings(warnings: &[String]) {
    for warning in warnings.iter().take(WARNINGS_SHOWN) {
        eprintln!("bdtree-build: warning: {warning}");
    }
    let more = warnings.len().saturating_sub(WARNINGS_SHOWN);
    if more > 0 {
        eprintln!("bdtree-build: {more} more warnings (--json shows all)");
    }
}

/// Prints. A reader that closes the pipe is no error; a full disk is one, though the file is made.
pub(super) fn print(done: &Done, json: bool, quiet: bool) -> ExitCode {
    if !quiet && !json {
        print_warnings(&done.report.warnings);
    }
    let mut out = std::io::stdout().lock();
    let printed = if json {
        let object = Json {
            output: done.output.display().to_string(),
            report: &done.report,
            elastic: done.elastic.as_ref().map(ElasticJson::from),
            volume: done.volume.as_ref().map(VolumeJson::from),
        };
        serde_json::to_string(&object)
            .map_err(std::io::Error::other)
            .and_then(|text| writeln!(out, "{text}"))
    } else if quiet {
        Ok(())
    } else {
        summary(done, &mut out)
    };
    match printed.and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("bdtree-build: standard output: {error}");
            ExitCode::from(1)
        }
        _ => ExitCode::SUCCESS,
    }
}

fn summary(done: &Done, out: &mut impl Write) -> std::io::Result<()> {
    let r = &done.report;
    writeln!(
        out,
        "{}: {} vertices, {} triangles, {} modes; {} nodes in {} levels; {} bytes",
        done.output.display(),
        r.vertices,
        r.triangles,
        r.modes,
        r.nodes,
        r.depth,
        r.bytes
    )?;
    if let Some(e) = &done.elastic {
        writeln!(
            out,
            "elastic: {} cells of {:.4} ({} along the longest side), {} unknowns, {:.4} kg",
            e.cells, e.cell_size, e.resolution, e.dofs, e.mass_kg
        )?;
    }
    if let Some(v) = &done.volume {
        writeln!(
            out,
            "volume: {} elements on {} nodes, {} unknowns, {:.4} kg",
            v.elements, v.nodes, v.dofs, v.mass_kg
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
        writeln!(out, "animation: {frames} frames")?;
    }
    if let Some(e) = &r.basis_error_rel {
        let frame = e.frame.map_or(String::new(), |t| format!(" in frame {t}"));
        writeln!(
            out,
            "error of the basis over the box diagonal: at most {:.3e} (vertex {}{frame}), rms {:.3e}",
            e.max, e.vertex, e.rms
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
