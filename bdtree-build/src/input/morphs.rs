//! Morph targets and their weights over time, as a source has them.

use super::{RawMesh, RawSkin};

/// A mesh with its morph targets and its skin: none for a file that has none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawModel {
    /// The mesh with all weights at 0.
    pub mesh: RawMesh,
    /// What its weights do.
    pub morphs: RawMorphs,
    /// What carries its vertices. Its clips move weights too: `morphs` then has none of its own.
    pub skin: Option<RawSkin>,
}

impl RawModel {
    /// The mesh alone, in its bind pose; a warning tells of a skin.
    pub(crate) fn into_mesh(self) -> RawMesh {
        let mut mesh = self.mesh;
        if self.skin.is_some() {
            let name = &mesh.name;
            let warning =
                format!("{name}: the skin is not used: the mesh is read in its bind pose");
            mesh.warnings.push(warning);
        }
        mesh
    }
}

/// Morph targets and, if the source has one, their weights over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMorphs {
    /// The targets in source order.
    pub targets: Vec<RawTarget>,
    /// The weights over time.
    pub clip: Option<RawClip>,
}

/// One morph target: weight w moves each vertex by w times its displacement.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawTarget {
    /// Name for people, if the source has one.
    pub name: Option<String>,
    /// The weight that the source gives it where nothing is animated.
    pub default_weight: f64,
    /// The largest |weight| that clips of a skin give it; 0 without.
    pub largest_weight: f64,
    /// Vertex and displacement (mesh units per unit of weight), by ascending vertex; vertices left
    /// out do not move.
    pub displacements: Vec<(u32, [f64; 3])>,
}

/// Weights over time; linear between frames.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawClip {
    /// Name of the animation in its source.
    pub name: String,
    /// Seconds of each frame, ascending. Two frames of the same time are a jump.
    pub times_s: Vec<f64>,
    /// `weights[t * M + j]` is the weight of target j in frame t; M is the number of targets.
    pub weights: Vec<f64>,
}
