//! How right `--advise` is: on real assets, the advised setting beside the best of all that keep the same error.
//!
//! Every number of modes that meets the goal is baked with every leaf size and timed in turn with the asset as it
//! is; the fastest few and the advised setting are then timed once more, all in turn, since the least of many times
//! is less than what it stands for. docs/advice.md holds the figures.

mod assets;
mod sweep;

use std::error::Error;
use std::path::PathBuf;

use bdtree_measure::machine;
use clap::Parser;

#[derive(Parser)]
#[command(about = "The advised setting beside the best of an exhaustive sweep")]
struct Arguments {
    /// Folder of the test data [default: what BDTREE_CORPUS names]
    #[arg(long)]
    corpus: Option<PathBuf>,
    /// Only the assets whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Seconds that timing one setting beside others may take
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let corpus = arguments
        .corpus
        .or_else(|| std::env::var_os("BDTREE_CORPUS").map(PathBuf::from))
        .ok_or("no test data: --corpus FOLDER")?;
    println!("{}", machine::processor());
    println!(
        "| asset | source | triangles | goal | advised | saves, of all modes | best of the sweep | settings | advised / best |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for asset in assets::all() {
        if !asset.name.contains(&arguments.only) {
            continue;
        }
        let (subject, goal) = asset.load(&corpus, arguments.seconds)?;
        let triangles = subject.mesh.triangles.len();
        let found = sweep::run(&subject, &goal)?;
        println!(
            "| {} | {} | {triangles} | {} % | {} | {} | {} | {} | {:.2} |",
            asset.name,
            asset.source,
            100.0 * asset.goal,
            sweep::setting(&found.advice.chosen, &subject),
            sweep::saved(&found.advice),
            sweep::setting(&found.best, &subject),
            found.settings,
            found.ratio
        );
    }
    Ok(())
}
