//! The paper's falling chairs (figures 1 and 7, P43 to P46): chairs with ten vibration modes fall onto the ground and onto
//! each other. [`falling`] has what it shares with the other scene.
//!
//! | file | part |
//! |---|---|
//! | `scene` | the world, its bodies and what they have in common |
//! | `kept` | chairs of a checkpoint |
//! | `ground` | that nothing is below the ground |
//! | `updated` | which spheres queries updated |

mod ground;
mod kept;
mod scene;
mod updated;

use std::error::Error;
use std::path::PathBuf;

use bdtree_runtime::Model;
use clap::Parser;

use crate::falling::{self, Options, log};
use crate::report::Report;
use crate::tables;

pub(crate) use kept::Kind;
pub(crate) use scene::Chairs;

/// Chairs that vibrate fall onto the ground and onto each other (the paper's figures 1 and 7)
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Number of chairs; the paper has 12 and 3601
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub bodies: u32,
    /// Steps of 1/150 s, those before --resume included
    #[arg(long, default_value_t = 1500)]
    pub steps: u64,
    /// Chairs that do not deform: q stays 0
    #[arg(long)]
    pub rigid: bool,
    /// Spheres of rigid chairs are updated as if they deformed, which changes nothing but the time
    #[arg(long, requires = "rigid")]
    pub redundant_updates: bool,
    /// A baked file with mass properties and vibration modes instead of the chair of fixtures/ with ten modes
    #[arg(long)]
    pub asset: Option<PathBuf>,
    /// Level of the contact spheres (0: the root's); without it, the one that has about a thousand
    #[arg(long)]
    pub level: Option<usize>,
    /// A PNG file for a picture of the spheres that were updated for the answers that the last step used
    #[arg(long)]
    pub updated: Option<PathBuf>,
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
/// Files that cannot be read or written, a checkpoint of another run, a step that failed, something below the ground; what
/// was logged until then is written.
pub fn run(arguments: Arguments) -> Result<Report, Box<dyn Error>> {
    let model = match &arguments.asset {
        Some(path) => Model::read(path)?,
        None => tables::chair()?,
    };
    let (steps, options) = (arguments.steps, arguments.options.clone());
    falling::run(Chairs::new(arguments, model)?, steps, options)
}
