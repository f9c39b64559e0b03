//! The fixtures with the modes that the paper gives each kind of model.

use std::error::Error;

use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::basis::pca::{Modes, PcaOptions, pca_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Silent;
use bdtree_fixtures::models;
use bdtree_runtime::Model;
use clap::ValueEnum;

use crate::contenders::assets::baked_mesh;

/// A model of the paper's Table 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Mesh {
    /// Ten vibration modes.
    Chair,
    /// Ten vibration modes; made when it is first asked for.
    Bridge,
    /// Three vibration modes.
    Fish,
    /// Twelve principal components of an animation.
    Curtain,
}

impl Mesh {
    /// The fixture's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chair => "chair",
            Self::Bridge => "bridge",
            Self::Fish => "fish",
            Self::Curtain => "curtain",
        }
    }

    /// Vertices, faces, M, spheres and levels in the paper's Table 1.
    pub(super) fn of_the_paper(self) -> [usize; 5] {
        match self {
            Self::Chair => [9421, 17_914, 10, 35_827, 19],
            Self::Bridge => [135_304, 240_316, 10, 480_631, 26],
            Self::Fish => [12_531, 24_776, 3, 49_551, 18],
            Self::Curtain => [6184, 12_020, 12, 24_039, 17],
        }
    }
}

/// A model as it is asked.
pub(super) fn baked(mesh: Mesh) -> Result<Model, Box<dyn Error>> {
    let [_, _, mode_count, _, _] = mesh.of_the_paper();
    let own = read_mesh(&models::path(mesh.name()))?;
    let (moved, basis) = if mesh == Mesh::Curtain {
        let frames = models::path("curtain_sway.pc2");
        let sequence = FrameSequence::open(&frames, Some(&own), None, &Silent)?;
        let options = PcaOptions {
            modes: Modes::Count(mode_count),
            ..PcaOptions::default()
        };
        let pca = pca_basis(&own, &sequence, &options, &Silent, &mut Vec::new())?;
        (pca.mesh, pca.basis)
    } else {
        let options = ElasticOptions {
            mode_count,
            ..ElasticOptions::default()
        };
        let (basis, _) = elastic_basis(&own, &options, &Silent, &mut Vec::new())?;
        (own, basis)
    };
    baked_mesh(&moved, &basis)
}
