//! The command: arguments → recipe → bake → file → what people or machines read of it.

mod advise;
mod arguments;
mod output;
mod progress;
mod recipe;

pub(crate) use arguments::Arguments;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use bdtree_build::bake;
use bdtree_build::error::BakeError;
use bdtree_build::progress::Progress;
use bdtree_build::recipe::Recipe;
use bdtree_build::report::BakeReport;
use bdtree_format::MAGIC;
use bdtree_output::check_writable;

/// Exit codes: 0 done, 1 bad input, 2 usage.
pub(crate) fn run(arguments: &Arguments) -> ExitCode {
    if let Err(message) = arguments.check() {
        eprintln!("bdtree-build: {message}");
        return ExitCode::from(2);
    }
    let progress = progress::Bar::new(arguments.quiet || arguments.json);
    let done = recipe::of(arguments).and_then(|recipe| {
        if arguments.advise {
            advise::run(arguments, &recipe, &progress).map(|advised| {
                progress.clear();
                advised.print(&recipe.source, arguments.json)
            })
        } else {
            bake_file(arguments, &recipe, &progress).map(|(output, report)| {
                progress.clear();
                let how = (arguments.json, arguments.quiet);
                output::print(&output, &report, &recipe.source, how)
            })
        }
    });
    done.unwrap_or_else(|error| {
        progress.clear();
        for problem in &error.problems {
            eprintln!("bdtree-build: {problem}");
        }
        ExitCode::from(1)
    })
}

/// Where the file is, and what was made.
fn bake_file(
    arguments: &Arguments,
    recipe: &Recipe,
    progress: &dyn Progress,
) -> Result<(PathBuf, BakeReport), BakeError> {
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(recipe.source.main_file()));
    check_output(recipe, &output)?;
    let mut baked = bake(recipe, progress)?;
    progress.stage("file", None);
    let begin = Instant::now();
    baked.write(&output)?;
    let seconds = begin.elapsed().as_secs_f64();
    baked.report.stages.insert("file".into(), seconds);
    Ok((output, baked.report))
}

/// Extensions of meshes, which a baked file must not have: programs would try to read it.
const MESHES: [&str; 8] = ["obj", "ply", "stl", "gltf", "glb", "veg", "vtk", "msh"];

/// Refuses an output that would overwrite what the bake reads, or what is no `.bdt` file, and one
/// that cannot be written.
fn check_output(recipe: &Recipe, output: &Path) -> Result<(), BakeError> {
    let refuse = |message: &str| Err(BakeError::one("file", output, message));
    let same = |path: &Path| {
        let both = (path.canonicalize(), output.canonicalize());
        matches!(both, (Ok(from), Ok(to)) if from == to)
    };
    let has = |extension: &str| {
        let own = output.extension();
        own.is_some_and(|own| own.eq_ignore_ascii_case(extension))
    };
    if recipe.files().into_iter().any(same) {
        return refuse(match has("bdt") {
            true => "is a baked file already: `bdtree info` tells what it holds",
            false => "is an input: it would be overwritten",
        });
    }
    if output.as_os_str() == "-" {
        return refuse("standard output is no place for a bake: name a file");
    }
    if has("bdt") {
        return Ok(check_writable(output)?);
    }
    // Buffers of a glTF file, frames, lists of vertices: whatever lies there is not ours.
    let mut start = [0; MAGIC.len()];
    if std::fs::metadata(output).is_ok_and(|meta| meta.is_file() && meta.len() > 0)
        && let Ok(mut file) = File::open(output)
        && (file.read_exact(&mut start).is_err() || start != MAGIC)
    {
        return refuse("is there already and no .bdt file: it would be overwritten");
    }
    if MESHES.into_iter().any(has) {
        return refuse("would look like a mesh: name the output .bdt");
    }
    Ok(check_writable(output)?)
}

/// The main file's name with its extension (and `.gz` before it) replaced by `.bdt`; a folder's
/// name with `.bdt` behind it, beside the folder also where that is given as `.`: in it, the file would lie among
/// the frames of the next bake.
fn default_output(input: &Path) -> PathBuf {
    if input.is_dir() {
        let named = match input.file_name() {
            Some(_) => input.to_path_buf(),
            None => std::fs::canonicalize(input).unwrap_or_else(|_| input.to_path_buf()),
        };
        let mut name = named.file_name().unwrap_or("frames".as_ref()).to_owned();
        name.push(".bdt");
        return named.with_file_name(name);
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
