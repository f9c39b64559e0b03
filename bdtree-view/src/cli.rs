//! The command line.

use std::path::PathBuf;
use std::str::FromStr;

use bdtree_tools::PostureArguments;
use bdtree_tools::render::options::{PictureSize, numbers};
use bdtree_tools::render::{UprightArguments, level};
use clap::Parser;

/// Opens a window on a .bdt file: sliders for q, its animation and clips, spheres of its tree colored by
/// growth, and a ball that shows what it touches and which nodes that visits.
///
/// The file's checksums are checked first. Do not change the file during the run: it is mapped into memory. Needs
/// Vulkan: a graphics card's, or Mesa's in software.
///
/// Exit codes: 0 the window was closed, 1 bad input or no window (one line on standard error), 2 usage.
#[derive(Debug, Parser)]
#[command(name = "bdtree-view", version)]
pub struct Arguments {
    /// The .bdt file
    pub file: PathBuf,
    /// How the mesh is posed at the beginning.
    #[command(flatten)]
    pub posture: PostureArguments,
    /// Begin with the clip of --clip playing, or else the animation
    #[arg(long, conflicts_with_all = ["q", "joints"])]
    pub play: bool,
    /// Show the spheres of a level of the tree, 0 being the root's, and the leaves above it
    #[arg(long, value_name = "LEVEL", value_parser = level)]
    pub spheres: Option<usize>,
    /// Show the probe: center and radius, world units
    #[arg(long, value_name = "X,Y,Z,R", allow_hyphen_values = true)]
    pub probe: Option<ProbeText>,
    /// Which way is up.
    #[command(flatten)]
    pub upright: UprightArguments,
    /// Width and height of the window in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    pub size: PictureSize,
    /// Copy the window's content to a picture once it is drawn, and exit
    #[arg(long, value_name = "OUT.png")]
    pub screenshot: Option<PathBuf>,
    /// Do not check the checksums first
    #[arg(long)]
    pub no_verify: bool,
}

/// `X,Y,Z,R`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeText {
    /// Center.
    pub center: [f64; 3],
    /// Radius, 0 or more.
    pub radius: f64,
}

impl FromStr for ProbeText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = numbers(text)?;
        match *numbers {
            [x, y, z, radius] if radius >= 0.0 => Ok(Self {
                center: [x, y, z],
                radius,
            }),
            [.., radius] if numbers.len() == 4 => Err(format!("radius: {radius} is negative")),
            _ => Err("four numbers as X,Y,Z,R are needed".to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_are_four_numbers() {
        let probe = ProbeText {
            center: [-1.0, 0.5, 2e3],
            radius: 0.0,
        };
        assert_eq!("-1, .5,2e3,0".parse(), Ok(probe));
        for wrong in ["", "1,2,3", "1,2,3,-1", "1,2,3,4,5", "1,2,nan,1", "1,2,x,1"] {
            assert!(wrong.parse::<ProbeText>().is_err(), "{wrong}");
        }
    }
}
