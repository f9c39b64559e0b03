//! The paper's tables over the fixtures: see [`bdtree_scenes::tables`].
//!
//!     cargo run --release -p bdtree-scenes --bin tables -- --out target/results

use std::error::Error;

use bdtree_scenes::tables::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    run(&arguments)?.show(arguments.out.as_deref())
}
