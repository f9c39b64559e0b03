//! The command line.

use std::path::PathBuf;

use bdtree_tools::render::options::PictureSize;
use clap::Parser;

/// Opens a window on a ground where bodies of .bdt files are dropped, pulled, poked and thrown.
///
/// Bodies need mass properties and, to vibrate, elastic modes: bdtree-build MESH --modes 10 -o BODY.bdt. Mesh units are
/// meters unless --scale says otherwise. The files' checksums are checked first. Do not change a file during the run: it is
/// mapped into memory. Needs Vulkan: a graphics card's, or Mesa's in software.
///
/// Exit codes: 0 the window was closed or the steps are done, 1 bad input, no window or a step that failed (one line on
/// standard error), 2 usage.
#[derive(Debug, Parser)]
#[command(name = "bdtree-playground", version)]
pub struct Arguments {
    /// The .bdt files, a kind of bodies each
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Bodies that begin in two layers of a grid above the ground, one file after the other
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=100_000))]
    pub bodies: u32,
    /// Of the orientations of bodies
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads that step; the motion is the same for any number
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// Meters per mesh unit
    #[arg(long, default_value_t = 1.0, value_parser = positive)]
    pub scale: f64,
    /// Steps per simulated second; without it 150, for thin and small bodies a multiple, or that of --resume
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(30..=100_000))]
    pub rate: Option<u32>,
    /// Bodies that do not deform: any file with mass properties will do
    #[arg(long)]
    pub rigid: bool,
    /// Level of the contact spheres (0: the root's), fewer are faster and coarser; without it the one with about a thousand
    #[arg(long)]
    pub level: Option<usize>,
    /// Without a window: make so many steps, print how long they took, and exit
    #[arg(long)]
    pub steps: Option<u64>,
    /// Folder for playground.json and playground-steps.csv, a line per step
    #[arg(long, requires = "steps")]
    pub out: Option<PathBuf>,
    /// With --steps a picture of the end; else copy the window's content once it is drawn, and exit
    #[arg(long, value_name = "OUT.png")]
    pub screenshot: Option<PathBuf>,
    /// Save the state to a file, to go on from with --resume: after the steps; when the window is closed, or by its button
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Go on from a checkpoint, with the same files
    #[arg(long, value_name = "FILE", conflicts_with = "bodies")]
    pub resume: Option<PathBuf>,
    /// Width and height of the window or the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    pub size: PictureSize,
}

fn positive(text: &str) -> Result<f64, String> {
    let x: f64 = text.parse().map_err(|_| format!("{text}: not a number"))?;
    match x > 0.0 && x.is_finite() {
        true => Ok(x),
        false => Err(format!("{text} is not above 0")),
    }
}
