//! The summary that people read, or the JSON object that machines read.

use std::collections::BTreeMap;
use std::io::{ErrorKind, StdoutLock, Write};
use std::path::Path;
use std::process::ExitCode;

use bdtree_build::figures::{counted, digits};
use bdtree_build::mass::MassSource;
use bdtree_build::recipe::Source;
use bdtree_build::report::{BakeReport, LevelTightness};
use serde::Serialize;

/// Warnings shown to people; `--json` and the file's metadata have all.
const WARNINGS_SHOWN: usize = 10;

/// Frequencies shown to people.
const FREQUENCIES_SHOWN: usize = 20;

/// Share of the diagonal below which a mesh is flat for people.
const FLAT: f64 = 1e-9;

/// The stages of a bake in their order.
const STAGES: [&str; 8] = [
    "input", "basis", "store", "tree", "wrap", "encode", "report", "file",
];

/// The report's fields, and where the file is.
#[derive(Serialize)]
struct Json<'d> {
    output: String,
    #[serde(flatten)]
    report: &'d BakeReport,
}

/// The first warnings, on stderr.
pub(super) fn print_warnings(warnings: &[String], source: &Source) {
    for warning in warnings.iter().take(WARNINGS_SHOWN) {
        let warning = with_folder(warning, source);
        eprintln!("bdtree-build: warning: {warning}");
    }
    let more = warnings.len().saturating_sub(WARNINGS_SHOWN);
    if more > 0 {
        let more = counted(more, "more warning");
        eprintln!("bdtree-build: {more} (--json shows all)");
    }
}

/// The warning with the file that it begins with as it was given: the report and the file's metadata have names without
/// folders.
fn with_folder(warning: &str, source: &Source) -> String {
    let begins = |path: &&Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let rest = warning.strip_prefix(&*name);
        !name.is_empty() && rest.is_some_and(|rest| rest.starts_with([':', '/']))
    };
    match source.files().into_iter().find(begins) {
        Some(path) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let full = path.display().to_string();
            format!("{}{}", full.trim_end_matches('/'), &warning[name.len()..])
        }
        None => warning.to_string(),
    }
}

/// Prints the summary or the object.
pub(super) fn print(
    output: &Path,
    report: &BakeReport,
    source: &Source,
    (json, quiet): (bool, bool),
) -> ExitCode {
    if !quiet && !json {
        print_warnings(&report.warnings, source);
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

/// Four significant digits at most.
fn short(x: f64) -> String {
    digits(x, 4)
}

/// A share in per cent, three digits at most.
fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share, 3))
}

/// What the tightness of all levels means for queries.
fn verdict(levels: &[LevelTightness], has_bones: bool) -> String {
    let mean = levels.iter().map(|level| level.mean).sum::<f64>() / levels.len() as f64;
    let meaning = match mean {
        m if m <= 1.5 => "tight",
        m if m <= 3.0 => "fair",
        _ => "loose: queries visit many nodes; use fewer modes or a smaller --range-rel",
    };
    // A bake does not try poses; `bdtree report` does.
    let pose = if has_bones { " in the bind pose" } else { "" };
    format!(
        "bounds: spheres are {mean:.2} times as large as the smallest possible ones at q_range{pose}, {meaning}"
    )
}

/// The sides of a box and its diagonal.
fn size(bounds: &[[f64; 3]; 2]) -> (String, String) {
    let size = [0, 1, 2].map(|k| bounds[1][k] - bounds[0][k]);
    let diagonal = size.iter().map(|x| x * x).sum::<f64>().sqrt();
    // What rounding leaves of a flat mesh is no size.
    let size = size.map(|x| if x > FLAT * diagonal { x } else { 0.0 });
    (size.map(short).join(" x "), short(diagonal))
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
    let scale = r.scale_m.map_or(String::new(), |scale| {
        format!("; 1 mesh unit = {scale} m (--scale)")
    });
    let (size, diagonal) = size(&r.bounds);
    match &r.bounds_at_rest {
        None => writeln!(out, "size: {size} mesh units, diagonal {diagonal}{scale}")?,
        // Queries meet the mesh as its bones carry it, which may be a hundredth of the bind pose.
        Some(at_rest) => {
            let (at_rest, diagonal_at_rest) = self::size(at_rest);
            writeln!(
                out,
                "size: {at_rest} mesh units with the bones at rest, diagonal {diagonal_at_rest}; {size} in the bind \
                 pose, before bones{scale}"
            )?;
        }
    }
    if let Some(m) = &r.mass {
        let center = m.center_of_mass.map(short).join(" ");
        let of = match m.source {
            MassSource::Surface => "of what the mesh encloses",
            MassSource::Lattice => "of the lattice's cells",
            MassSource::Elements => "of the elements",
        };
        writeln!(
            out,
            "mass: {} kg {of}, {} kg/m³, center {center}",
            short(m.mass_kg),
            short(m.density_kg_m3)
        )?;
    }
    if let Some(e) = &r.elastic {
        writeln!(
            out,
            "elastic: {} of {} ({} along the longest side), {}, {} kg",
            counted(e.cells, "cell"),
            short(e.cell_size),
            e.resolution,
            counted(e.dofs, "unknown"),
            short(e.mass_kg)
        )?;
    }
    if let Some(v) = &r.volume {
        writeln!(
            out,
            "volume: {} on {}, {}, {} kg",
            counted(v.elements, "element"),
            counted(v.nodes, "node"),
            counted(v.dofs, "unknown"),
            short(v.mass_kg)
        )?;
    }
    if let Some(hz) = &r.frequencies_hz {
        let shown = hz.iter().take(FREQUENCIES_SHOWN).map(|f| short(*f));
        let text: Vec<String> = shown.collect();
        let more = match hz.len() > FREQUENCIES_SHOWN {
            true => " … (--json shows all)",
            false => "",
        };
        writeln!(out, "frequencies (Hz): {}{more}", text.join(" "))?;
        let end = hz.iter().fold(0.0, |m: f64, f| m.max(*f));
        writeln!(
            out,
            "highest mode: {} Hz. Motion above it is not represented.",
            short(end)
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
        let times = match r.duration_s {
            Some(seconds) => format!("{} s", short(seconds)),
            None => "times unknown (give --fps)".to_string(),
        };
        writeln!(out, "animation: {}, {times}", counted(frames, "frame"))?;
    }
    if r.basis_error_rel.as_ref().is_some_and(|e| e.max_rel == 0.0) {
        writeln!(out, "error of the basis: none")?;
    } else if let Some(e) = &r.basis_error_rel {
        let frame = e.frame.map_or(String::new(), |t| format!(" in frame {t}"));
        writeln!(
            out,
            "error of the basis: at most {} of the diagonal (vertex {}{frame}), rms {}",
            percent(e.max_rel),
            e.vertex,
            percent(e.rms_rel)
        )?;
    }
    if r.modes == 0 {
        let still = if r.bones.is_some() {
            "spheres grow with the bones only: there are no modes"
        } else {
            "rigid: spheres do not grow"
        };
        writeln!(out, "{still}")?;
    } else if !r.tightness.is_empty() {
        let levels = r.tightness.iter();
        let text: Vec<String> = levels.map(|t| format!("{:.2}", t.mean)).collect();
        let text = text.join(" ");
        writeln!(
            out,
            "sphere radius over the smallest possible, per level: {text}"
        )?;
        writeln!(out, "{}", verdict(&r.tightness, r.bones.is_some()))?;
    }
    writeln!(out, "seconds: {}", seconds(&r.stages))
}

/// The stages in the order of the bake, those that take no hundredth of a second left out, and their sum.
fn seconds(stages: &BTreeMap<String, f64>) -> String {
    let place = |name: &str| STAGES.iter().position(|stage| *stage == name);
    let mut shown: Vec<(&String, &f64)> = stages
        .iter()
        .filter(|(_, seconds)| **seconds >= 0.005)
        .collect();
    shown.sort_by_key(|(name, _)| place(name).unwrap_or(STAGES.len()));
    let text = shown
        .iter()
        .map(|(name, seconds)| format!("{name} {seconds:.2}"));
    let text: Vec<String> = text.collect();
    // An empty sum would be −0.
    let total = format!("total {:.2}", stages.values().fold(0.0, |a, b| a + b));
    match text.is_empty() {
        true => total,
        false => format!("{} ({total})", text.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_come_in_the_order_of_the_bake() {
        let stages = [
            ("basis", 6.5),
            ("tree", 0.25),
            ("file", 0.001),
            ("input", 0.1),
        ];
        let stages = stages.map(|(name, seconds)| (name.to_string(), seconds));
        let text = seconds(&BTreeMap::from(stages));
        assert_eq!(text, "input 0.10, basis 6.50, tree 0.25 (total 6.85)");
        assert_eq!(seconds(&BTreeMap::new()), "total 0.00");
    }

    #[test]
    fn warnings_name_files_as_they_were_given() {
        let recipe =
            bdtree_build::Recipe::of_surface("in/a.obj", bdtree_build::recipe::Motion::Rigid);
        let told = |warning: &str| with_folder(warning, &recipe.source);
        assert_eq!(told("a.obj:3: odd"), "in/a.obj:3: odd");
        assert_eq!(told("a.obj: odd"), "in/a.obj: odd");
        assert_eq!(told("a.objx: odd"), "a.objx: odd");
        assert_eq!(told("1 of 2 pieces"), "1 of 2 pieces");
    }

    #[test]
    fn shares_are_told_in_percent() {
        assert_eq!(percent(9.168e-3), "0.917 %");
        assert_eq!(percent(7.1e-4), "0.071 %");
        assert_eq!(percent(2.076e-7), "2.08e-5 %");
    }
}
