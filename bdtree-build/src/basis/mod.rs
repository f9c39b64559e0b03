//! Displacement fields: where `U` comes from.

pub mod animation;
pub mod dropped;
pub mod elastic;
pub mod embed;
pub mod given;
pub mod modal;
pub mod morph;
pub mod pca;
pub(crate) mod tally;
pub mod volume;

pub use animation::{Animation, RigidMotion};
use serde::Serialize;

use crate::mass::Momentum;
use crate::vec3::norm;
use crate::wrap::RANGE_DIAGONALS;

/// A deformation basis: `p' = p + Σ_j fields[j] q_j`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Basis {
    /// Number of vertices N; equals the mesh's.
    pub vertex_count: usize,
    /// Displacements (mesh units per unit of q), field after field:
    /// `fields[j * vertex_count + i]` is `U_ij`.
    pub fields: Vec<[f64; 3]>,
    /// One entry per field.
    pub modes: Vec<BasisMode>,
    /// q over time, if the source is an animation.
    pub animation: Option<Animation>,
}

/// How far a basis, as the file stores it, is from its source: over all vertices, and over all
/// frames where there are frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BasisError {
    /// Largest distance over the diagonal of the box around the rest positions.
    #[serde(rename = "max")]
    pub max_rel: f64,
    /// Root mean square of the distances over the same diagonal.
    #[serde(rename = "rms")]
    pub rms_rel: f64,
    /// The frame of the largest distance, from 0.
    pub frame: Option<usize>,
    /// The vertex of the largest distance.
    pub vertex: usize,
}

/// What is known about one field.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BasisMode {
    /// Name for people, if the source has one.
    pub name: Option<String>,
    /// Angular frequency ω_j in rad/s, if the field is a vibration mode.
    pub omega_rad_s: Option<f64>,
    /// Modal mass m_j in kg, if the field is a vibration mode.
    pub modal_mass_kg: Option<f64>,
    /// Momentum of the whole body at unit speed, if the field is a vibration mode whose mass is known.
    pub momentum: Option<Momentum>,
    /// Typical largest |q_j|; `None` lets the bake choose it.
    pub q_range: Option<f64>,
    /// The source's default weight, if it has one: for the metadata only.
    pub default_q: Option<f64>,
}

impl Basis {
    /// Number of fields M.
    pub fn mode_count(&self) -> usize {
        self.modes.len()
    }

    /// Gives every field without a range the one that moves its farthest vertex by `length` (mesh
    /// units). Zero fields stay without.
    ///
    /// # Panics
    /// Fewer fields than modes × vertices.
    pub fn set_ranges(&mut self, length: f64) {
        for j in 0..self.mode_count() {
            let longest = self.longest(j);
            let mode = &mut self.modes[j];
            if mode.q_range.is_none() && longest > 0.0 {
                mode.q_range = Some(length / longest);
            }
        }
    }

    /// How far one unit of q moves the farthest vertex of field `j` (mesh units).
    pub(crate) fn longest(&self, j: usize) -> f64 {
        let lengths = self.field(j).iter().map(|&u| norm(u));
        lengths.fold(0.0, f64::max)
    }

    /// The range of |q_j|: the mode's own, else what moves its farthest vertex by the usual share of `diagonal`; 0 for
    /// zero fields without one.
    pub(crate) fn range(&self, j: usize, diagonal: f64) -> f64 {
        let typical = match self.longest(j) {
            longest if longest > 0.0 => RANGE_DIAGONALS * diagonal / longest,
            _ => 0.0,
        };
        self.modes[j].q_range.unwrap_or(typical)
    }

    /// Field `j`: N displacement vectors.
    ///
    /// # Panics
    /// No such field, or fewer than modes × vertices.
    pub fn field(&self, j: usize) -> &[[f64; 3]] {
        &self.fields[j * self.vertex_count..(j + 1) * self.vertex_count]
    }
}
