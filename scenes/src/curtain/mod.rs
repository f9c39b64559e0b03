//! The paper's Table 2: a ball thrown at a compressed animation of a curtain (P38–P40).
//!
//! The fixture's curtain in 110 frames (30 per second) as 12 principal components; the ball flies, falls and
//! bounces off what it touches. Each frame is one question, the triangles that the ball touches, and all
//! contenders must find the same.

mod flight;
mod measure;

use std::error::Error;
use std::path::PathBuf;

use bdtree_build::basis::pca::{Modes, PcaOptions, pca_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models::animation;
use bdtree_measure::Body;
use bdtree_runtime::Model;
use clap::Parser;

use crate::report::Report;
use crate::workloads::curtain::Curtain;

/// A ball is thrown at a curtain that sways: tests and times of BD-Trees and of trees that are refitted (the
/// paper's Table 2)
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Triangles of the curtain, about (220 and more); 12020 is the fixture, and the paper's number
    #[arg(long, default_value_t = 12_020, value_parser = clap::value_parser!(u32).range(220..=20_000_000))]
    pub triangles: u32,
    /// Frames of the flight (1 to 110), 1/30 s each
    #[arg(long, default_value_t = 110, value_parser = clap::value_parser!(u16).range(1..=110))]
    pub frames: u16,
    /// Modes (1 to 110)
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..=110))]
    pub modes: u16,
    /// Radius of the ball in metres (the curtain is 1.8 m wide), more than 0
    #[arg(long, default_value_t = 0.1, value_parser = flight::radius)]
    pub radius: f32,
    /// How often every contender answers all frames; each frame's median counts (1 and more)
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u16).range(1..))]
    pub repeat: u16,
    /// Folder for curtain.json, curtain.csv and curtain.svg
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Measures.
///
/// # Errors
/// Files that cannot be made or read, contenders that do not find the same.
pub fn run(arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    let (mesh, frames) = animation::curtain(arguments.triangles as usize)?;
    let mesh = read_mesh(&mesh)?;
    let sequence = FrameSequence::open(&frames, Some(&mesh), Some(30.0), &Silent)?;
    let options = PcaOptions {
        modes: Modes::Count(usize::from(arguments.modes)),
        ..PcaOptions::default()
    };
    let pca = pca_basis(&mesh, &sequence, &options, &Silent, &mut Vec::new())?;
    let baked = bake_fields(
        &pca.mesh,
        &pca.basis,
        &BakeSettings::default(),
        &Provenance::default(),
        &Silent,
    )?;
    let model = Model::from_bytes(&baked.bytes)?;
    let asset = model.asset();
    if asset.unit() != 1.0 || asset.origin() != [0.0; 3] {
        // Contenders would each need their own way from the world to stored units.
        return Err("the curtain is not stored in its own coordinates".into());
    }
    let count = usize::from(arguments.frames).min(asset.frame_count());
    let mut q = Vec::with_capacity(count * asset.mode_count());
    for frame in 0..count {
        q.extend_from_slice(asset.frame(frame).ok_or("the file has fewer frames")?.q());
    }
    let work = Curtain {
        balls: flight::flight(asset, &q, arguments.radius)?,
        body: Body::of_asset(asset)?,
        q,
    };
    measure::measure(arguments, asset, &work, pca.error.max_rel)
}
