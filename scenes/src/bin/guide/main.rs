//! Plots and tables of docs/guide/settings.md: see [`bdtree_scenes::guide`].
//!
//!     BDTREE_CORPUS=FOLDER scripts/guide.sh

use std::error::Error;

use bdtree_scenes::guide::{Arguments, run};
use clap::Parser;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    run(&arguments)?.show(arguments.out.as_deref())
}
