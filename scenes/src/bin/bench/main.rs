//! Side-by-side benchmarks: the product beside the paper's plain tree, in one run.
//!
//! Machines that measure are shared, so contenders take turns within a run and what counts are
//! medians of ratios; `docs/benchmarks.md` holds the method and the figures.

mod bake;
mod ball;
mod face;
mod open;
mod scene;

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
    /// Stage times of a bake and the largest resident set
    Bake(bake::Arguments),
    /// Local blend shapes of a face beside dense modes: bytes and time of a ball query
    Face(face::Arguments),
    /// Opening a large file by mapping it
    Open(open::Arguments),
}

fn main() -> Result<(), Box<dyn Error>> {
    match Cli::parse().command {
        Command::Ball(arguments) => ball::run(&arguments),
        Command::Bake(arguments) => bake::run(&arguments),
        Command::Face(arguments) => face::run(&arguments),
        Command::Open(arguments) => open::run(&arguments),
    }
}
