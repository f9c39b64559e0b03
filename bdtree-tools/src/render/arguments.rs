//! The command line of `bdtree render`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::options::{AgainstChoice, FrameRange, PictureSize, ScaleChoice, UpAxis, View};
use crate::posture::PostureArguments;

/// Draws pictures: the deformed mesh, spheres of its tree, what queries visit.
///
/// Spheres are colored by growth: their radius over that at rest (q = 0, bones at rest). With the scale of the
/// paper, dark blue is no growth and dark red is 1.44 (three times the volume) or more; with viridis,
/// dark purple and yellow are.
/// Needs Vulkan: a graphics card's, or Mesa's in software.
///
/// The file's checksums are checked first. Do not change the file during the run: all commands except verify
/// map it into memory.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("drawn spheres").args(["spheres", "query"]).multiple(true))]
pub struct Arguments {
    /// The .bdt file
    pub file: PathBuf,
    /// Output file: .png; with --frames a name with %d or %0Nd, where the frame's number goes
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)] // clap would print it
    pub posture: PostureArguments,
    /// Frames A to B of the file's animation, one picture each, all seen by the same camera
    #[arg(long, value_name = "A..B", conflicts_with_all = ["q", "frame", "clip", "joints"])]
    pub frames: Option<FrameRange>,
    /// Draw the spheres of one level of the tree (0 is the root's; `info` lists the levels). Where a branch ends earlier, its
    /// leaf spheres are drawn too, so that the spheres together cover the mesh
    #[arg(long, value_name = "LEVEL", value_parser = level)]
    pub spheres: Option<usize>,
    /// Place FILE and the other instances as the scene does, run the scene's queries, and draw the spheres of FILE at which
    /// they went no deeper (with --spheres: those of visited nodes of that level). --q, --frame, --clip or --joints replaces
    /// the pose of all instances of FILE. Planes and frusta are not drawn
    #[arg(long, value_name = "SCENE.json", conflicts_with = "frames")]
    pub query: Option<PathBuf>,
    /// What a sphere's radius is divided by for its color: that of the same sphere at rest, as in
    /// the paper, or that of the smallest ball around the deformed vertices it holds; with --spheres or --query
    #[arg(
        long,
        value_enum,
        default_value = "rest",
        value_name = "WHAT",
        requires = "drawn spheres"
    )]
    pub against: AgainstChoice,
    /// The scale of colors: the paper's, or viridis, which color-blind readers can read too
    #[arg(long, value_enum, default_value = "paper", value_name = "SCALE")]
    pub scale: ScaleChoice,
    /// Where the scale of colors ends, above 1; greater growth has its last color
    #[arg(
        long,
        value_name = "GROWTH",
        default_value = "1.44",
        value_parser = scale_max,
        requires = "drawn spheres"
    )]
    pub scale_max: f64,
    /// How opaque spheres are, 0 to 1
    #[arg(long, value_name = "A", default_value = "0.35", value_parser = share)]
    pub opacity: f64,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x960")]
    pub size: PictureSize,
    /// Where it is seen from, in degrees: around the up axis (with y up, 0 is from +z and 90 from +x; with
    /// z up, 0 is from -y and 90 from +x), from above (-90 to 90); and how near, 1 being where all of
    /// it just fits (above 1 it fills the picture, with the text over it)
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION[,ZOOM]",
        default_value = "30,20,1",
        allow_hyphen_values = true
    )]
    pub view: View,
    #[command(flatten)]
    #[allow(missing_docs)] // clap would print it
    pub upright: UprightArguments,
    /// Draw the mesh's shadow on a level ground at its lowest vertex, under a light from above and a little from the
    /// left. Spheres throw none and may reach below the ground
    #[arg(long)]
    pub shadow: bool,
    /// No text and no scale of colors
    #[arg(long)]
    pub no_legend: bool,
    /// Print one JSON object per picture instead of a line: output, frame, q, level, nodes_visited, growth {mean, max},
    /// spheres [{node, lane, center, radius, growth, pixel}] (world units; growth null where it is
    /// infinite)
    #[arg(long)]
    pub json: bool,
    /// Do not check the checksums first
    #[arg(long)]
    pub no_verify: bool,
}

/// Which way is up in pictures.
#[derive(Debug, Clone, Args)]
pub struct UprightArguments {
    /// The axis of the mesh that points up in the picture
    #[arg(
        long,
        value_enum,
        value_name = "AXIS",
        default_value = "y",
        allow_hyphen_values = true
    )]
    pub up: UpAxis,
}

/// The number of a level.
///
/// # Errors
/// It is none.
pub fn level(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>();
    number.map_err(|_| "not a whole number, 0 or more".to_string())
}

/// The end of a scale that begins at 1.
fn scale_max(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 1.0 && x <= 1e6 => Ok(x),
        Ok(_) => Err("must be a number above 1, at most 1e6".to_string()),
        Err(_) => Err("not a number".to_string()),
    }
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        Ok(_) => Err("must be a number from 0 to 1".to_string()),
        Err(_) => Err("not a number".to_string()),
    }
}
