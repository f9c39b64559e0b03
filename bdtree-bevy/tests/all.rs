//! What `bdtree-bevy` promises.

// Examples have the modules that they share as their own.
#![allow(clippy::duplicate_mod)]

mod bounds;
mod common;
mod contacts;
#[cfg(feature = "render")]
mod drawing;
#[cfg(feature = "render")]
mod drawing_changes;
#[cfg(all(feature = "render", feature = "gizmos"))]
mod examples;
#[cfg(all(feature = "render", feature = "gizmos"))]
mod gizmos;
mod loading;
#[cfg(feature = "picking")]
mod picking;
mod queries;
mod reload;
mod sources;
#[cfg(feature = "render")]
#[path = "../examples/support/mod.rs"]
mod support;
#[cfg(feature = "render")]
mod visibility;
