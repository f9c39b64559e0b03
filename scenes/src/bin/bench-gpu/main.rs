//! Skinning on a GPU, held against what the device copies; normals from fields beside exact ones; and drawing thousands of bodies.
//!
//! Method and figures: `docs/reference/gpu-deformation.md`.

mod crowd;
mod normals;
mod skin;
mod timer;

use std::error::Error;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(about = "Skinning and drawing on a GPU: time, bytes, accuracy of normals")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Positions and normals of one large mesh and of thousands of chairs, beside the device's copy bandwidth
    Skin(skin::Arguments),
    /// Angles between normals from fields and exact ones at a given displacement (needs no GPU)
    Normals(normals::Arguments),
    /// Pictures of a heap of chairs: time, how many of them are seen, memory
    Crowd(crowd::Arguments),
}

fn main() -> Result<(), Box<dyn Error>> {
    match Cli::parse().command {
        Command::Skin(arguments) => skin::run(&arguments),
        Command::Normals(arguments) => normals::run(&arguments),
        Command::Crowd(arguments) => crowd::run(&arguments),
    }
}
