//! The paper's rows beside ours: see [`bdtree_scenes::results`].
//!
//!     cargo run --release -p bdtree-scenes --bin results

use std::error::Error;

use bdtree_scenes::results::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    run(&Arguments::parse())
}
