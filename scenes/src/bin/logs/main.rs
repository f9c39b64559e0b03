//! The logs of `docs/measured/logs`: see [`bdtree_scenes::logs`].
//!
//!     cargo run --release -p bdtree-scenes --bin logs -- keep target/chairs docs/measured/logs/chairs-3601.csv.gz

use std::error::Error;

use bdtree_scenes::logs::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    run(&Arguments::parse())
}
