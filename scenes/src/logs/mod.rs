//! What `docs/measured/logs` has: what a run did, step by step, as a file that stays. The [`results`](crate::results) are
//! read from there, since such runs take longer than all other programs together.
//!
//! | file | part |
//! |---|---|
//! | `file` | the files |
//! | `keep` | of a run that has ended |
//! | `ratios` | deformable chairs beside rigid ones |
//! | `pictures` | what drawing takes |

pub(crate) mod file;
mod keep;
pub(crate) mod pictures;
pub(crate) mod ratios;

use std::error::Error;
use std::path::PathBuf;

use bdtree_measure::machine;
use bdtree_runtime::Model;
use clap::{Args, Parser, Subcommand};

use crate::report::commit;
use crate::tables;
use file::LogFile;

/// Makes the logs of docs/measured/logs, from which `results` takes the paper's longest runs
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Clone, Subcommand)]
enum What {
    /// A line per step of a run of `chairs` or `fish` that has ended
    Keep(Keep),
    /// Deformable chairs, rigid ones and rigid ones with redundant updates, in turns
    Ratios(Ratios),
    /// What pictures of chairs take
    Pictures(Pictures),
}

#[derive(Debug, Clone, Args)]
struct Keep {
    /// The run's --out: NAME.json and NAME-steps.csv are read
    folder: PathBuf,
    /// The log, compressed if its name ends in .gz
    file: PathBuf,
}

/// How checkpoints are gone on from.
#[derive(Debug, Clone, Args)]
struct Begin {
    /// Repetitions of each checkpoint
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Threads that step
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: u16,
    /// The checkpoints' asset, where it is not the chair of fixtures/
    #[arg(long)]
    asset: Option<PathBuf>,
}

impl Begin {
    fn model(&self) -> Result<Model, Box<dyn Error>> {
        Ok(match &self.asset {
            Some(path) => Model::read(path)?,
            None => tables::chair()?,
        })
    }

    /// A table without rows that says what made it.
    fn table(&self, program: &str, columns: &[&str]) -> LogFile {
        let mut table = LogFile {
            columns: columns.iter().map(|name| (*name).to_string()).collect(),
            ..LogFile::default()
        };
        table.say("program", program);
        table.say("commit", commit());
        table.say("machine", machine::processor());
        table.say("threads", self.threads);
        table
    }
}

#[derive(Debug, Clone, Args)]
struct Ratios {
    /// The table to write, compressed if its name ends in .gz
    file: PathBuf,
    /// Checkpoints of a run of `chairs`
    #[arg(long, required = true, num_args = 1..)]
    deformable: Vec<PathBuf>,
    /// Checkpoints of a run of `chairs --rigid` after as many steps, in the same order
    #[arg(long, required = true, num_args = 1..)]
    rigid: Vec<PathBuf>,
    #[command(flatten)]
    begin: Begin,
    /// Steps that are measured
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Steps before those: the first one after a checkpoint asks the trees of all pairs
    #[arg(long, default_value_t = 20)]
    before: u32,
}

#[derive(Debug, Clone, Args)]
struct Pictures {
    /// The table to write, compressed if its name ends in .gz
    file: PathBuf,
    /// Checkpoints of a run of `chairs`
    #[arg(required = true)]
    checkpoints: Vec<PathBuf>,
    #[command(flatten)]
    begin: Begin,
    /// Width and height in pixels
    #[arg(long, value_delimiter = 'x', default_value = "1280x720", num_args = 1)]
    size: Vec<u32>,
}

/// Makes a log.
///
/// # Errors
/// Files that cannot be read or written, a run that has not ended, checkpoints of other chairs, steps that fail.
pub fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    match &arguments.what {
        What::Keep(of) => keep::keep(&of.folder, &of.file),
        What::Ratios(of) => ratios::measure(of),
        What::Pictures(of) => pictures::measure(of),
    }
}
