//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::posture::PostureArguments;
#[cfg(feature = "render")]
use crate::render::Arguments as RenderArguments;
#[cfg(feature = "report")]
use crate::render::UprightArguments;

/// Looks into, checks, compares, deforms, queries and draws .bdt files.
///
/// Exit codes: 0 done, 1 bad input (every problem on standard error with its place), 2 usage (`diff`
/// has its own).
#[derive(Debug, Parser)]
#[command(name = "bdtree", version)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Info(InfoArguments),
    Verify(VerifyArguments),
    Diff(DiffArguments),
    Deform(DeformArguments),
    Query(QueryArguments),
    #[cfg(feature = "report")]
    Report(ReportArguments),
    /// Not compiled into this program; install with: cargo install --locked --path bdtree-tools --features report
    #[cfg(not(feature = "report"))]
    Report(LeftOut),
    #[cfg(feature = "render")]
    Render(RenderArguments),
    /// Not compiled into this program; install with: cargo install --locked --path bdtree-tools --features render
    #[cfg(not(feature = "render"))]
    Render(LeftOut),
    View(ViewArguments),
}

/// Prints what a file holds: counts, modes, sphere sizes per tree level.
///
/// Reads header, tables and tree and checks the header's checksum only; `verify` checks all.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// The .bdt file
    pub file: PathBuf,
    /// Print one JSON object (lengths in mesh units, unknown values null)
    #[arg(long)]
    pub json: bool,
    /// Also list the sections with their offsets and lengths in bytes (--json always has them)
    #[arg(long, conflicts_with = "json")]
    pub sections: bool,
}

/// Checks every rule of the format: checksums, padding, records and every stored bound.
///
/// Exit code 0 when the file is sound, else 1. At most 1000 broken rules are listed. The file is
/// read into memory, not mapped.
#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// The .bdt file
    pub file: PathBuf,
    /// Print one JSON object: ok, errors [{section, byte, rule, expected, found}] (expected: a number,
    /// or text such as "less than 98"); with --stress, unless a rule is broken, also stress {cases,
    /// seed, poses, vertices, kernels, violations, unbounded, tightest, rounding_slack_rel}
    #[arg(long)]
    pub json: bool,
    /// Also test the bounds at worst-case q: deformed vertices against the spheres above them, in exact
    /// arithmetic; prints the smallest margin
    #[arg(long)]
    pub stress: bool,
    /// Number of cases; a case is one node at one q
    #[arg(long, value_name = "N", default_value = "1000000", requires = "stress",
          value_parser = cases)]
    pub cases: u64,
    /// The same seed tries the same cases, on processors of the same kind
    #[arg(long, value_name = "S", default_value = "0", requires = "stress", value_parser = whole)]
    pub seed: u64,
}

/// Compares two files: structure exactly, numbers within a tolerance.
///
/// Structure is counts, sections, tree, triangles, groups, names and settings. A number's
/// difference is measured against the largest magnitude of its quantity in both files: positions
/// and sphere centers against the mesh's size, each mode's field against that mode's largest
/// displacement, and so on. The version of the builder and the names of the files that were baked do not count.
/// Where vertices differ, the farthest is shown, at rest and by each mode at its q_range.
///
/// Both files are verified first.
///
/// Exit code 0 when they are the same, 1 when they differ, 2 when one cannot be read or is damaged.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// A .bdt file
    pub a: PathBuf,
    /// Another
    pub b: PathBuf,
    /// Largest difference of numbers over the scale of their quantity, 0 or more (no unit);
    /// 0: numbers are equal to the last bit
    #[arg(long, value_name = "E", default_value = "0", value_parser = tolerance)]
    pub tolerance_rel: f64,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Writes the deformed mesh: origin + p + U q in f64, mesh units, in the source's order.
///
/// A frame's rigid motion, if one was taken out, is put back: R (origin + p + U q) + t. With a skin the bones then
/// carry the vertices, at rest unless --clip or --joints says otherwise.
///
/// The file's checksums are checked first. Do not change the file during the run: all commands except
/// verify map it into memory.
#[derive(Debug, Args)]
pub struct DeformArguments {
    /// The .bdt file
    pub file: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)] // clap would print it
    pub posture: PostureArguments,
    /// Output file: .obj, or .npy with shape (N, 3), f64 [default: OBJ on standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Do not check the checksums first
    #[arg(long)]
    pub no_verify: bool,
}

/// Answers a scene's queries: one JSON line each, in order.
///
/// The scene and the checksums of its assets are checked before the first line is printed. Do not change
/// the files during the run: all commands except verify map them into memory. Coordinates and lengths
/// are in world units, in and out.
#[derive(Debug, Args)]
pub struct QueryArguments {
    /// The scene as JSON, - for standard input; asset paths in it are relative to its folder
    /// (standard input: to the current one)
    #[arg(value_name = "SCENE.json")]
    pub scene: PathBuf,
    /// Add nodes_visited to each line: the number of nodes visited
    #[arg(long)]
    pub stats: bool,
    /// Do not check the assets' checksums first
    #[arg(long)]
    pub no_verify: bool,
}

/// Measures what each choice costs and buys for an asset, and gives advice: modes, depth,
/// tightness, times beside deform + refit, bytes.
///
/// A page of its own (plots inside, nothing fetched) or JSON with all its figures. Counts and errors are
/// the same in every run on processors of one kind, times are not. A report takes about 7 s for 18
/// thousand triangles and one to two minutes for half a million, on two idle cores. The file is
/// checked first. Do not change it during the run: all commands except verify map files into memory.
#[cfg(feature = "report")]
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// The .bdt file
    pub file: PathBuf,
    /// Output file: .html [default: beside FILE, with .html; with --json none]
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)] // clap would print it
    pub upright: UprightArguments,
    /// Print one JSON object: file, date, made, verdict, asset, machine, samples, missing, advice, modes,
    /// modes_over, depth_whole, depth, tightness, margin, refit, sections, unneeded, seconds (lengths in
    /// mesh units, unknown values null)
    #[arg(long)]
    pub json: bool,
    /// Do not check checksums and records first: a broken file may give wrong figures or end the program
    #[arg(long)]
    pub no_verify: bool,
}

/// Opens a window on a file: sliders, animation, clips, spheres, a probe.
///
/// Starts the program bdtree-view with all that follows; `bdtree view --help` is its help.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct ViewArguments {
    /// The .bdt file and options of bdtree-view
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        required = true,
        value_name = "FILE"
    )]
    pub arguments: Vec<OsString>,
}

/// A subcommand that was not compiled: whatever follows.
#[cfg(not(all(feature = "render", feature = "report")))]
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub(crate) struct LeftOut {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<OsString>,
}

/// A whole number.
fn whole(text: &str) -> Result<u64, String> {
    let number = text
        .parse::<u64>()
        .map_err(|_| "not a whole number, 0 or more");
    Ok(number?)
}

/// A number of cases.
fn cases(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("not a whole number, 1 or more".to_string()),
    }
}

/// A tolerance from 0 on.
fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(e) if e >= 0.0 && e.is_finite() => Ok(e),
        Ok(_) => Err("must be a finite number, 0 or more".to_string()),
        Err(_) => Err("not a number".to_string()),
    }
}
