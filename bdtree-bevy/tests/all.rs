//! What `bdtree-bevy` promises.

mod bounds;
mod common;
mod contacts;
mod loading;
#[cfg(feature = "picking")]
mod picking;
mod queries;
mod reload;
mod sources;
