//! The paper's fish on a swaying bridge: see [`bdtree_scenes::fish`].
//!
//!     cargo run --release -p bdtree-scenes --bin fish -- --threads 2 --out target/fish

use std::error::Error;

use bdtree_scenes::fish::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let out = arguments.options.out.clone();
    run(arguments)?.show(out.as_deref())
}
