//! The command: arguments → input → basis → bake → file → what people or machines read of it.

mod advise;
mod arguments;
mod output;
mod progress;
mod sources;

pub(crate) use arguments::Arguments;

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use bdtree_build::basis::elastic::ElasticReport;
use bdtree_build::basis::volume::VolumeReport;
use bdtree_build::error::{BakeError, Problem};
use bdtree_build::pipeline::{
    BakeSettings, bake, check_writable, default_leaf_size, write_atomically,
};
use bdtree_build::progress::Progress;
use bdtree_build::report::BakeReport;
use bdtree_format::MAGIC;

/// Exit codes: 0 done, 1 bad input, 2 usage.
pub(crate) fn run(arguments: &Arguments) -> ExitCode {
    if let Err(message) = arguments.check() {
        eprintln!("bdtree-build: {message}");
        return ExitCode::from(2);
    }
    if arguments.main_file().is_none() {
        eprintln!(
            "bdtree-build: no INPUT: name a mesh (.obj, .obj.gz, .gltf, .glb); --help shows all \
             options"
        );
        return ExitCode::from(2);
    }
    let progress = progress::Bar::new(arguments.quiet || arguments.json);
    let done = if arguments.advise {
        advise::run(arguments, &progress).map(|advised| {
            progress.clear();
            advised.print(arguments.json)
        })
    } else {
        bake_file(arguments, &progress).map(|done| {
            progress.clear();
            output::print(&done, arguments.json, arguments.quiet)
        })
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            progress.clear();
            for problem in &error.problems {
                eprintln!("bdtree-build: {}", of_file(problem, arguments));
            }
            ExitCode::from(1)
        }
    }
}

/// A problem with the name of the main file before it where its place is one in a mesh, of which later
/// stages do not know where it came from.
fn of_file<'p>(problem: &'p Problem, arguments: &Arguments) -> Cow<'p, Problem> {
    let parts = ["vertex ", "triangle ", "mode ", "frame "];
    let in_mesh = parts.iter().any(|part| problem.place.starts_with(part));
    match arguments.main_file() {
        Some(file) if in_mesh => Cow::Owned(Problem {
            place: format!("{}: {}", file.display(), problem.place),
            ..problem.clone()
        }),
        _ => Cow::Borrowed(problem),
    }
}

/// What a finished bake has to tell.
struct Done {
    output: PathBuf,
    report: BakeReport,
    elastic: Option<ElasticReport>,
    volume: Option<VolumeReport>,
}

fn bake_file(arguments: &Arguments, progress: &dyn Progress) -> Result<Done, BakeError> {
    let input = arguments.main_file().unwrap_or(Path::new(""));
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(input));
    check_output(arguments, &output)?;
    let source = sources::read(arguments, progress)?;
    let settings = settings(arguments, &source);
    let mut baked = bake(
        &source.mesh,
        &source.basis,
        &settings,
        &source.warnings,
        progress,
    )?;

    progress.stage("file", None);
    let begin = Instant::now();
    write_atomically(&output, &baked.bytes)?;
    let stages = &mut baked.report.stages;
    stages.extend(source.seconds);
    stages.insert("file".into(), begin.elapsed().as_secs_f64());
    Ok(Done {
        output,
        report: baked.report,
        elastic: source.elastic,
        volume: source.volume,
    })
}

/// How the arguments have a source baked.
fn settings(arguments: &Arguments, source: &sources::Source) -> BakeSettings {
    let mut settings = BakeSettings {
        leaf_size: arguments.leaf_size.map(usize::from),
        split: arguments.split,
        nested: arguments.nested,
        threads: arguments
            .threads
            .map_or_else(available_threads, usize::from),
        basis_kind: source.kind.to_string(),
        basis_error: source.error,
        metadata: source.settings.clone(),
    };
    let leaf_size = settings
        .leaf_size
        .unwrap_or_else(|| default_leaf_size(source.mesh.triangles.len()));
    let shown = [
        ("leaf-size", leaf_size.to_string()),
        ("split", arguments.split.to_string()),
    ];
    for (name, value) in shown {
        settings.metadata.insert(name.to_string(), value);
    }
    if arguments.nested {
        let (name, value) = ("nested".to_string(), "true".to_string());
        settings.metadata.insert(name, value);
    }
    settings
}

/// Refuses an output that would overwrite what the bake reads, or what is no `.bdt` file, and one
/// that cannot be written.
fn check_output(arguments: &Arguments, output: &Path) -> Result<(), BakeError> {
    let refuse = |message: &str| {
        let place = output.display().to_string();
        Err(BakeError::one("file", place, message))
    };
    let same = |path: &Path| {
        let both = (path.canonicalize(), output.canonicalize());
        matches!(both, (Ok(from), Ok(to)) if from == to)
    };
    if arguments.inputs().into_iter().any(same) {
        return refuse("is an input: it would be overwritten");
    }
    let has = |extension: &str| {
        let own = output.extension();
        own.is_some_and(|own| own.eq_ignore_ascii_case(extension))
    };
    if has("bdt") {
        return check_writable(output);
    }
    // Buffers of a glTF file, frames, lists of vertices: whatever lies there is not ours.
    let mut start = [0; MAGIC.len()];
    if std::fs::metadata(output).is_ok_and(|meta| meta.is_file() && meta.len() > 0)
        && let Ok(mut file) = File::open(output)
        && (file.read_exact(&mut start).is_err() || start != MAGIC)
    {
        return refuse("is there already and no .bdt file: it would be overwritten");
    }
    if has("obj") && arguments.animation.as_deref().is_some_and(Path::is_dir) {
        return refuse("would become a frame: name the output .bdt");
    }
    check_writable(output)
}

fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// The main file's name with its extension (and `.gz` before it) replaced by `.bdt`; a folder's
/// name with `.bdt` behind it.
fn default_output(input: &Path) -> PathBuf {
    if input.is_dir() {
        let mut name = input.file_name().unwrap_or("frames".as_ref()).to_owned();
        name.push(".bdt");
        return input.with_file_name(name);
    }
    let without_gz = if input
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("gz"))
    {
        input.with_extension("")
    } else {
        input.to_path_buf()
    };
    without_gz.with_extension("bdt")
}
