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

use bdtree_runtime::{Contact, PairContact};

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

/// A tree that is refitted to deformed vertices.
pub trait Peer {
    /// Deforms all vertices at q, moves them to `place`, calls `deformed` and refits the tree. `scratch` is
    /// memory that bodies share.
    fn update_with(
        &mut self,
        deformer: &Deformer,
        q: &[f32],
        place: &Place,
        scratch: &mut Vec<f32>,
        deformed: &mut dyn FnMut(),
    );

    /// [`Peer::update_with`] without any clock, for what is timed as a whole: looking at one takes as long
    /// as refitting some triangles.
    fn update_untimed(
        &mut self,
        deformer: &Deformer,
        q: &[f32],
        place: &Place,
        scratch: &mut Vec<f32>,
    ) {
        self.update_with(deformer, q, place, scratch, &mut || ());
    }

    /// [`Peer::update_with`], its parts timed.
    fn update(
        &mut self,
        deformer: &Deformer,
        q: &[f32],
        place: &Place,
        scratch: &mut Vec<f32>,
    ) -> Update {
        let start = Clock::start();
        let (mut deform, mut deformed) = (0.0, start);
        self.update_with(deformer, q, place, scratch, &mut || {
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
