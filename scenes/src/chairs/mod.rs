//! The paper's falling chairs (figures 1 and 7, P43 to P46): chairs with ten vibration modes fall onto the ground and onto
//! each other.
//!
//! | file | part |
//! |---|---|
//! | `waves` | where and when chairs begin to fall |
//! | `scene` | the world, its bodies and what they have in common |
//! | `checkpoint` | a run's state as a file, and going on from there |
//! | `check` | contacts against brute force, and nothing below the ground |
//! | `log` | what every step did, and the sums |
//! | `show` | pictures |
//! | `updated` | which spheres a step's queries updated |
//! | `progress` | the time left |

mod check;
mod checkpoint;
mod log;
mod progress;
mod run;
mod scene;
mod show;
mod updated;
mod waves;

use std::path::PathBuf;

use clap::Parser;

pub use log::COLUMNS;
pub use run::run;

/// Chairs that vibrate fall onto the ground and onto each other (the paper's figures 1 and 7)
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Number of chairs; the paper has 12 and 3601
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub bodies: u32,
    /// Steps of 1/150 s, those before --resume included
    #[arg(long, default_value_t = 1500)]
    pub steps: u64,
    /// Of the places and orientations at the beginning
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads that step; the motion is the same for any number
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
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
    /// A file for the state, to go on from with --resume; written at the end too
    #[arg(long)]
    pub checkpoint: Option<PathBuf>,
    /// Steps from one checkpoint to the next
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..))]
    pub checkpoint_every: u64,
    /// Goes on from a checkpoint of a run with the same chairs, seed and level
    #[arg(long)]
    pub resume: Option<PathBuf>,
    /// Steps from one comparison of contacts with brute force to the next; 0: none
    #[arg(long, default_value_t = 100)]
    pub check_every: u64,
    /// Folder for chairs.json, chairs-steps.csv (a line per step) and tables
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Folder for a film's pictures: one every five steps, 30 a second
    #[arg(long)]
    pub frames: Option<PathBuf>,
    /// A PNG file for a picture of the end
    #[arg(long)]
    pub picture: Option<PathBuf>,
    /// A PNG file for a picture of the spheres that queries of the last step updated
    #[arg(long)]
    pub updated: Option<PathBuf>,
    /// Width and height of pictures in pixels
    #[arg(long, value_delimiter = 'x', default_value = "1280x720", num_args = 1)]
    pub size: Vec<u32>,
}
