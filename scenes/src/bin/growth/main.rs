//! How queries grow: see [`bdtree_scenes::growth`].
//!
//!     cargo run --release -p bdtree-scenes --bin growth -- --out target/results

use std::error::Error;

use bdtree_scenes::growth::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    run(&arguments)?.show(arguments.out.as_deref())
}
