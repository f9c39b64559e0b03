//! Side-by-side benchmarks: the product beside the paper's plain tree, in one run.
//!
//! Machines that measure are shared, so contenders take turns within a run and what counts are
//! medians of ratios; `docs/benchmarks.md` holds the method and the figures.

mod bake;
mod ball;
mod broad;
mod depth;
mod face;
mod hard_cases;
mod kernel;
mod open;
mod scene;
mod workloads;

use std::error::Error;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(about = "Side-by-side benchmarks of BD-Trees")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// A small ball against a deforming mesh: product and paper's tree
    Ball(ball::Arguments),
    /// Root spheres of many bodies: grid and sweep
    Broad(broad::Arguments),
    /// Queries that stop at a level: time, spheres and their error
    Depth(depth::Arguments),
    /// Stage times of a bake and the largest resident set
    Bake(bake::Arguments),
    /// Steps that change little: spheres that follow a pose, fronts of pairs
    Coherence(workloads::coherence::Arguments),
    /// Local blend shapes of a face beside dense modes: bytes and time of a ball query
    Face(face::Arguments),
    /// Hard rigid meshes: rays that slip through, distances that are off (feature `peers` for others)
    HardCases(hard_cases::Arguments),
    /// The node kernel alone, beside the machine's limit
    Kernel(kernel::Arguments),
    /// Opening a large file by mapping it
    Open(open::Arguments),
    /// W1 to W4: the product beside libraries that deform and refit (feature `peers`)
    Workloads(workloads::Arguments),
}

fn main() -> Result<(), Box<dyn Error>> {
    match Cli::parse().command {
        Command::Ball(arguments) => ball::run(&arguments),
        Command::Broad(arguments) => broad::run(&arguments),
        Command::Depth(arguments) => depth::run(&arguments),
        Command::Bake(arguments) => bake::run(&arguments),
        Command::Coherence(arguments) => workloads::coherence::run(&arguments),
        Command::Face(arguments) => face::run(&arguments),
        Command::HardCases(arguments) => hard_cases::run(&arguments),
        Command::Kernel(arguments) => kernel::run(&arguments),
        Command::Open(arguments) => open::run(&arguments),
        Command::Workloads(arguments) => workloads::run(&arguments),
    }
}
