//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::q::QText;

/// Looks into, checks, compares, deforms and queries .bdt files.
///
/// Exit codes: 0 done, 1 bad input (every problem on standard error with its place), 2 usage.
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
}

/// Prints what a file holds: counts, modes, sections, sphere sizes per tree level.
///
/// Reads header, tables and tree without checking checksums; `verify` checks them.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// The .bdt file
    pub file: PathBuf,
    /// Print one JSON object (lengths in mesh units, unknown values null)
    #[arg(long)]
    pub json: bool,
}

/// Checks every rule of the format: checksums, padding, records and every stored bound.
///
/// Exit code 0 when the file is sound, else 1. At most 1000 broken rules are listed. The file is
/// read into memory, not mapped.
#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// The .bdt file
    pub file: PathBuf,
    /// Print one JSON object: ok, errors [{section, byte, rule, expected, found}]; with --stress
    /// also stress {cases, seed, poses, vertices, kernels, violations, unbounded, tightest,
    /// certainty_rel}
    #[arg(long)]
    pub json: bool,
    /// Try the bounds as well: deformed vertices against the spheres above them, in exact
    /// arithmetic, at q that is made to break them; prints how close it came
    #[arg(long)]
    pub stress: bool,
    /// Cases to try: nodes at a q
    #[arg(long, value_name = "N", default_value = "1000000", requires = "stress",
          value_parser = clap::value_parser!(u64).range(1..))]
    pub cases: u64,
    /// The same seed tries the same cases, on processors of the same kind
    #[arg(long, value_name = "S", default_value = "0", requires = "stress")]
    pub seed: u64,
}

/// Compares two files: structure exactly, numbers within a tolerance.
///
/// Structure is counts, sections, tree, triangles, groups, names and settings. A number's
/// difference is measured against the largest magnitude of its quantity in both files: positions
/// and sphere centres against the mesh's size, each mode's field against that mode's largest
/// displacement, and so on. The version of the builder is shown but does not count.
///
/// Exit code 0 when they are the same, 1 when they differ, 2 when one cannot be read.
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
}

/// Writes the deformed mesh: origin + p + U q in f64, mesh units, in the source's order.
///
/// A frame's rigid motion, if one was taken out, is put back: R (origin + p + U q) + t.
///
/// The file's checksums are checked first; it must not change meanwhile.
#[derive(Debug, Args)]
pub struct DeformArguments {
    /// The .bdt file
    pub file: PathBuf,
    /// One number per mode, separated by commas, each at most the mode's q_limit in magnitude
    /// (`info` shows it); the unit is the basis's, for elastic modes: 1 moves the farthest vertex
    /// by one mesh unit [default: zeros]
    #[arg(long, allow_hyphen_values = true, value_name = "Q1,Q2,…")]
    pub q: Option<QText>,
    /// Frame of the file's animation, counted from 0, instead of --q (`info` shows how many there
    /// are)
    #[arg(long, value_name = "T", conflicts_with = "q")]
    pub frame: Option<u64>,
    /// Where to: .obj, or .npy with shape (N, 3), f64 [default: OBJ on standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Do not check the checksums first
    #[arg(long)]
    pub no_verify: bool,
}

/// Answers a scene's queries: one JSON line each, in order.
///
/// The whole scene is checked before the first line is printed, and so are the checksums of its
/// assets; they must not change meanwhile. Coordinates and lengths are world, in and out.
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

/// A tolerance from 0 on.
fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(e) if e >= 0.0 && e.is_finite() => Ok(e),
        Ok(_) => Err("must be a finite number, 0 or more".to_string()),
        Err(error) => Err(error.to_string()),
    }
}
