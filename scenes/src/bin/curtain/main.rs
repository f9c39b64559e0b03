//! The paper's Table 2: see [`bdtree_scenes::curtain`].
//!
//!     cargo run --release -p bdtree-scenes --bin curtain -- --out target/results

use std::error::Error;

use bdtree_scenes::curtain::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    run(&arguments)?.show(arguments.out.as_deref())
}
