//! What an instance keeps during a step: node spheres and deformed leaves, in the caller's memory.
//!
//! The paper updates a node when a step first visits it and reuses the result from then on (3.4). Here
//! the result goes into a [`StepCache`] of whatever size the caller grants: a slot that is taken by
//! another node only means that the node is evaluated again. Queries return the same with and
//! without.

mod posed;
mod slots;
mod step;
#[cfg(test)]
mod tests;

pub(crate) use posed::{OwnCache, Posed, deform};
pub(crate) use slots::{CHUNK, LeafChunk};
pub(crate) use step::Kept;
pub use step::{CacheSize, StepCache};
