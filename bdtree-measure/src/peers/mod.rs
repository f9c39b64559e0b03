//! Those who deform all vertices, refit a tree and then ask it: libraries in use today (feature
//! `peers`, obvhs alone with `refit`, Embree with `embree`) and the paper's layered hierarchy.
//!
//! All of them share [`Deformer`], the exact tests of balls and of pairs in [`crate::leaf`] (one triangle
//! after the other), and world coordinates in f32; rays are tested by the libraries' own code where they have
//! some.

#[cfg(feature = "embree")]
pub mod embree;
mod layered;
mod obvhs;
#[cfg(feature = "peers")]
mod parry;
#[cfg(feature = "peers")]
mod tinybvh;
mod vertices;

#[cfg(feature = "embree")]
pub use embree::Embree;
pub use layered::LayeredPeer;
pub use obvhs::Obvhs;
#[cfg(feature = "peers")]
pub use parry::Parry;
#[cfg(feature = "peers")]
pub use tinybvh::TinyBvh;

use std::ops::AddAssign;

use bdtree_runtime::{BoneMap, Contact, PairContact};

use crate::Place;
use crate::clock::Clock;
use crate::deform::Deformer;

/// Seconds that bringing a body up to date took.
#[derive(Debug, Clone, Copy, Default)]
pub struct Update {
    /// Deforming and moving all vertices.
    pub deform: f64,
    /// Refitting the tree.
    pub refit: f64,
}

impl AddAssign for Update {
    fn add_assign(&mut self, other: Self) {
        self.deform += other.deform;
        self.refit += other.refit;
    }
}

/// What a body is brought to.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// The body's.
    pub deformer: &'a Deformer,
    /// How it is deformed …
    pub q: &'a [f32],
    /// … where its bones are ([`bdtree_runtime::Pose::bone_maps`], none without a skin) …
    pub bones: &'a [BoneMap],
    /// … and where it stands.
    pub place: &'a Place,
}

impl<'a> Target<'a> {
    /// Of a body without bones.
    pub fn without_bones(deformer: &'a Deformer, q: &'a [f32], place: &'a Place) -> Self {
        Self {
            deformer,
            q,
            bones: &[],
            place,
        }
    }

    /// Writes x, y, z of all vertices there to `out`.
    fn write(&self, scratch: &mut Vec<f32>, out: &mut [f32]) {
        let Self {
            deformer,
            q,
            bones,
            place,
        } = *self;
        deformer.deform_at(q, bones, place, scratch, out);
    }
}

/// A tree that is refitted to deformed vertices.
pub trait Peer {
    /// Deforms and moves all vertices, calls `deformed` and refits the tree. `scratch` is memory that bodies
    /// share.
    fn update_with(&mut self, to: Target<'_>, scratch: &mut Vec<f32>, deformed: &mut dyn FnMut());

    /// [`Peer::update_with`] without any clock, for what is timed as a whole: looking at one takes as long
    /// as refitting some triangles.
    fn update_untimed(&mut self, to: Target<'_>, scratch: &mut Vec<f32>) {
        self.update_with(to, scratch, &mut || ());
    }

    /// [`Peer::update_with`], its parts timed.
    fn update(&mut self, to: Target<'_>, scratch: &mut Vec<f32>) -> Update {
        let start = Clock::start();
        let (mut deform, mut deformed) = (0.0, start);
        self.update_with(to, scratch, &mut || {
            deform = start.seconds();
            deformed = Clock::start();
        });
        Update {
            deform,
            refit: deformed.seconds(),
        }
    }

    /// Appends the triangles within a ball.
    fn ball(&mut self, center: [f64; 3], radius: f64, found: &mut Vec<Contact>);

    /// Distance along a unit direction to the first triangle that is met.
    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64>;
}

/// A tree that two bodies are tested with.
pub trait PairPeer: Peer {
    /// Appends the touching pairs of triangles of two bodies.
    fn pair(&mut self, other: &mut Self, found: &mut Vec<PairContact>);
}
