//! Side-by-side benchmarks: the product beside the paper's plain tree, in one run.
//!
//! Machines that measure are shared, so contenders take turns within a run and what counts are
//! medians of ratios; `docs/measured/benchmarks.md` holds the method and the figures. Every command gives tables,
//! which are printed as text or as JSON.

mod bake;
mod ball;
mod broad;
mod characters;
mod depth;
mod hard_cases;
mod kernel;
mod open;
mod record;
mod refining;
mod scene;
mod turns;
mod workloads;

/// What most benchmarks use.
mod prelude {
    pub(crate) use std::error::Error;
    pub(crate) use std::hint::black_box;
    pub(crate) use std::time::Instant;

    pub(crate) use bdtree_fixtures::poses;
    pub(crate) use bdtree_measure::machine;
    pub(crate) use bdtree_measure::ours::{Answer, Ours, frame};
    pub(crate) use bdtree_measure::turns::{Counts, Entry, Role, TOTAL};
    pub(crate) use bdtree_runtime::{Asset, Contact, Model, Pose, Transform, Workspace};
    pub(crate) use bdtree_scenes::report::{Row, Table, table};
    pub(crate) use bdtree_scenes::row;
    pub(crate) use clap::{Args, Parser};
    pub(crate) use rand::RngExt;

    pub(crate) use crate::scene::{Case, Scene, cases};
    pub(crate) use crate::turns::{compare, least_ns, pass, rows};

    pub(crate) type Result<T, E = Box<dyn Error>> = std::result::Result<T, E>;
}

use std::path::{Path, PathBuf};

use bdtree_scenes::report::{Report, write};
use clap::Subcommand;

use prelude::{Parser, Result, Table};

#[derive(Parser)]
#[command(about = "Side-by-side benchmarks of BD-Trees")]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// How often everyone's turn comes [default: what docs/measured/benchmarks.md was measured with]
    #[arg(long, global = true, visible_aliases = ["repeat", "repetitions"], value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// JSON instead of text, or beside it in this file
    #[arg(long, global = true, value_name = "FILE", num_args = 0..=1, default_missing_value = STDOUT)]
    json: Option<PathBuf>,
}

/// What `--json` without a file means.
const STDOUT: &str = "-";

#[derive(Subcommand)]
enum Command {
    /// A small ball against a deforming mesh: product and paper's tree
    Ball(ball::Arguments),
    /// Root spheres of many bodies: the grid of the broad phase
    Broad(scene::Scene),
    /// Characters: spheres and boxes beside the smallest ones over their clips, time of poses
    Characters(characters::Arguments),
    /// Queries that stop at a level: time, spheres and their error
    Depth(depth::Arguments),
    /// Stage times of a bake and the largest resident set
    Bake(scene::Scene),
    /// Steps that change little: spheres that follow a pose, fronts of pairs
    Coherence(workloads::coherence::Arguments),
    /// Hard rigid meshes: rays that slip through, distances that are off (feature `peers` for others)
    HardCases(hard_cases::Arguments),
    /// The node kernel alone, beside the machine's limit
    Kernel(kernel::Arguments),
    /// Opening a large file by mapping it
    Open(open::Arguments),
    /// All benchmarks with their defaults into one CSV file
    Record(record::Arguments),
    /// Questions per step from which on refined poses pay, and step caches that find that out
    Refining(refining::Arguments),
    /// W1 to W5: the product beside libraries that deform and refit (feature `peers`)
    Workloads(workloads::Arguments),
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    if let Command::Record(arguments) = &cli.command {
        return record::run(arguments);
    }
    let (name, tables) = measure(&cli)?;
    let report = Report::of_tables(name, tables);
    if cli.json.as_deref() != Some(Path::new(STDOUT)) {
        report.show(None)?;
    }
    match cli.json {
        Some(path) if path == Path::new(STDOUT) => println!("{:#}", report.json()),
        Some(path) => write(&path, &format!("{:#}\n", report.json()))?,
        None => {}
    }
    Ok(())
}

/// The tables of a benchmark.
fn measure(cli: &Cli) -> Result<(&'static str, Vec<Table>)> {
    let rounds = |default: usize| cli.rounds.map_or(default, |rounds| rounds as usize);
    let (name, tables) = match &cli.command {
        Command::Ball(arguments) => ("ball", ball::run(arguments, rounds(31))),
        Command::Broad(scene) => ("broad", broad::run(scene, rounds(51))),
        Command::Characters(arguments) => ("characters", characters::run(arguments, rounds(101))),
        Command::Depth(arguments) => ("depth", depth::run(arguments, rounds(9))),
        Command::Bake(scene) => ("bake", bake::run(scene)),
        Command::Coherence(arguments) => {
            ("coherence", workloads::coherence::run(arguments, rounds(9)))
        }
        Command::HardCases(arguments) => ("hard-cases", hard_cases::run(arguments)),
        Command::Kernel(arguments) => ("kernel", kernel::run(arguments, rounds(31))),
        Command::Open(arguments) => ("open", open::run(arguments, rounds(200))),
        Command::Record(_) => return Err("a record is no benchmark".into()),
        Command::Refining(arguments) => ("refining", refining::run(arguments, rounds(3))),
        Command::Workloads(arguments) => ("workloads", workloads::run(arguments, rounds(15))),
    };
    Ok((name, tables?))
}
