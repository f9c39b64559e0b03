//! The paper's falling chairs: see [`bdtree_scenes::chairs`].
//!
//!     cargo run --release -p bdtree-scenes --bin chairs -- --steps 1500 --out target/chairs

use std::error::Error;

use bdtree_scenes::chairs::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let out = arguments.options.out.clone();
    run(arguments)?.show(out.as_deref())
}
