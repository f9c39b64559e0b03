//! Mutated inputs for the readers of the builder and the tools, as many as wanted
//! (docs/design/fuzzing.md).

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use bdtree_tests::fuzz::memory::Counting;
use bdtree_tests::fuzz::{Campaign, Case, Format, Seeds, Tally};
use clap::Parser;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Reads mutated files and checks what must hold for each: a result or an error that names the
/// file, no panic, bounded time and memory; a share is baked, verified and queried beside brute
/// force. Exit code 1 if something failed; each failure is printed with the arguments that repeat
/// it.
#[derive(Parser)]
struct Options {
    /// Cases per format.
    #[arg(long, default_value_t = 20_000)]
    cases: u64,
    /// Seed of the campaign.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only these formats; may be given several times [default: all].
    #[arg(long)]
    format: Vec<Format>,
    /// Only the case with this number.
    #[arg(long, requires = "format")]
    case: Option<u64>,
    /// Writes the file of --case here.
    #[arg(long, requires = "case")]
    write: Option<PathBuf>,
    /// One in this many files that can be read goes on to a bake and queries; 0: none.
    #[arg(long, default_value_t = 8)]
    follow: u64,
    /// Threads; each takes its share of the cases.
    #[arg(long, default_value_t = 2)]
    threads: u64,
    /// Begins with small files of the corpus (BDTREE_CORPUS) too. Cases have other files then.
    #[arg(long)]
    corpus: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let seeds = match options.corpus {
        false => Seeds::fixtures(),
        true => match Seeds::with_corpus("fuzz-inputs") {
            Some(seeds) => seeds,
            None => return ExitCode::from(2),
        },
    };
    let formats = match options.format.as_slice() {
        [] => &Format::ALL[..],
        some => some,
    };
    let mut failures = 0;
    for &format in formats {
        let begin = Instant::now();
        let tally = match options.case {
            Some(number) => one(&options, &seeds, format, number),
            None => all(&options, &seeds, format),
        };
        println!(
            "{format:<11} {:>3} seed files {tally} in {:.0} s",
            seeds.count(format),
            begin.elapsed().as_secs_f64()
        );
        for failure in &tally.failures {
            let corpus = if options.corpus { " --corpus" } else { "" };
            println!("FAILED fuzz-inputs{corpus} {failure}");
        }
        failures += tally.failure_count;
    }
    ExitCode::from(u8::from(failures > 0))
}

fn one(options: &Options, seeds: &Seeds, format: Format, number: u64) -> Tally {
    let campaign = Campaign::new(seeds, options.follow.min(1));
    if let Some(path) = &options.write {
        let case = Case {
            format,
            seed: options.seed,
            number,
        };
        std::fs::write(path, campaign.file(case)).expect("the file can be written");
    }
    campaign.run(format, options.seed, [number])
}

fn all(options: &Options, seeds: &Seeds, format: Format) -> Tally {
    let threads = options.threads.max(1);
    let share = |first: u64| {
        let numbers = (first..options.cases).step_by(threads as usize);
        Campaign::new(seeds, options.follow).run(format, options.seed, numbers)
    };
    std::thread::scope(|scope| {
        let share = &share;
        let others: Vec<_> = (1..threads)
            .map(|first| scope.spawn(move || share(first)))
            .collect();
        let mut tally = share(0);
        for other in others {
            tally.add(other.join().expect("a thread"));
        }
        tally
    })
}
