//! The paper's fish on a bridge (P49): fish with three vibration modes fall onto a bridge that sways, a compressed
//! animation. [`falling`] has what it shares with the other scene.
//!
//! | file | part |
//! |---|---|
//! | `assets` | the two assets |
//! | `bridge` | the bridge's motion, and whether anything went through it |
//! | `water` | what becomes of fish that fall off |
//! | `scene` | the world, its bodies and what they have in common |

mod assets;
mod bridge;
mod scene;
mod water;

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;

use crate::falling::{self, Options, log};
use crate::report::Report;
use bridge::Bridge;
use scene::Fish;

/// Fish that vibrate fall onto a swaying bridge (section 6 of the paper)
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Number of fish; the paper has 12000
    #[arg(long, default_value_t = 12_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub bodies: u32,
    /// Steps of 1/480 s, those before --resume included
    #[arg(long, default_value_t = 7200)]
    pub steps: u64,
    /// Folder of fish.bdt and bridge.bdt; what is not there is baked and kept there. Without it they are baked anew
    #[arg(long)]
    pub assets: Option<PathBuf>,
    /// Level of the fish's contact spheres (0: the root's); without it, the one that has about a hundred
    #[arg(long)]
    pub level: Option<usize>,
    /// Pictures show the whole bridge; without it, its middle
    #[arg(long)]
    pub whole: bool,
    /// What all scenes have.
    #[command(flatten)]
    pub options: Options,
}

/// Columns of the table of steps.
pub fn columns() -> Vec<&'static str> {
    log::names::<scene::Own>()
}

/// Simulates, and writes what is asked for.
///
/// # Errors
/// Files that cannot be read or written, a bake that fails, a bridge whose animation cannot be repeated, a checkpoint of
/// another run, a step that failed, a fish that went through the bridge; what was logged until then is written.
pub fn run(arguments: Arguments) -> Result<Report, Box<dyn Error>> {
    let folder = arguments.assets.as_deref();
    let fish = assets::get(folder, "fish", assets::fish)?;
    let bridge = Bridge::new(assets::get(folder, "bridge", assets::bridge)?)?;
    let (steps, options) = (arguments.steps, arguments.options.clone());
    falling::run(Fish::new(arguments, fish, bridge)?, steps, options)
}
