//! The options that all programs of falling bodies have.

use std::path::PathBuf;

use clap::Args;

/// What is written and when, and with how many threads.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Of the places and orientations at the beginning
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads that step; the motion is the same for any number
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
    /// A file for the state, to go on from with --resume; written at the end too
    #[arg(long)]
    pub checkpoint: Option<PathBuf>,
    /// Steps from one checkpoint to the next
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..))]
    pub checkpoint_every: u64,
    /// Keeps every checkpoint, as FILE-STEP beside the last one
    #[arg(long, requires = "checkpoint")]
    pub keep_all: bool,
    /// Goes on from a checkpoint of a run with the same bodies, seed and level
    #[arg(long)]
    pub resume: Option<PathBuf>,
    /// Steps from one comparison of contacts with brute force to the next; 0: none
    #[arg(long, default_value_t = 100)]
    pub check_every: u64,
    /// Folder for NAME.json, NAME-steps.csv (a line per step) and tables
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Folder for a film's pictures: 30 a second
    #[arg(long)]
    pub frames: Option<PathBuf>,
    /// A PNG file for a picture of the end
    #[arg(long)]
    pub picture: Option<PathBuf>,
    /// Width and height of pictures in pixels
    #[arg(long, value_delimiter = 'x', default_value = "1280x720", num_args = 1)]
    pub size: Vec<u32>,
}
