//! Opens, verifies and queries damaged files by the million (docs/design/fuzzing.md).

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use bdtree_fixtures::hostile::{Case, Run, Sources};
use clap::Parser;

/// Makes damaged `.bdt` files, opens, verifies and queries each; a case that panics is told with its
/// number, one that hangs ends the program.
#[derive(Parser)]
struct Options {
    /// How many files.
    #[arg(long, default_value_t = 100_000)]
    cases: u64,
    /// Number of the first case.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of the random numbers: seed and number say all of a case.
    #[arg(long, default_value_t = 2004)]
    seed: u64,
    /// Threads; 0 for as many as there are processors.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Longest time for one case, in seconds.
    #[arg(long, default_value_t = 20)]
    limit: u64,
    /// Only this case, whose panic ends the program with its backtrace.
    #[arg(long)]
    case: Option<u64>,
    /// Where to write the file of --case.
    #[arg(long, requires = "case")]
    write: Option<PathBuf>,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let sources = Sources::new();
    if let Some(number) = options.case {
        return one(&options, number, &sources);
    }
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let run = Run {
        seed: options.seed,
        first: options.first,
        cases: options.cases,
        threads,
        limit: Duration::from_secs(options.limit),
    };
    let begin = std::time::Instant::now();
    let summary = run.go(&sources, |done, took| {
        eprintln!("{done} files after {:.0} s", took.as_secs_f64());
    });
    print!("{summary}");
    println!(
        "{:.1} s on {threads} threads",
        begin.elapsed().as_secs_f64()
    );
    if summary.failures.is_empty() {
        return ExitCode::SUCCESS;
    }
    let (case, _) = summary.failures[0];
    println!("again: fuzz-files --seed {} --case {case}", options.seed);
    ExitCode::FAILURE
}

fn one(options: &Options, number: u64, sources: &Sources) -> ExitCode {
    let case = Case {
        seed: options.seed,
        number,
    };
    let (source, damage, bytes, _) = case.file(sources);
    println!("{source}, {damage:?}: {} bytes", bytes.len());
    if let Some(path) = &options.write
        && let Err(error) = fs::write(path, &bytes)
    {
        eprintln!("{}: {error}", path.display());
        return ExitCode::FAILURE;
    }
    println!("{:?}", case.examine(sources));
    ExitCode::SUCCESS
}
