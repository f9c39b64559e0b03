//! What `bdtree-bevy` promises.

// Examples have the modules that they share as their own.
#![allow(clippy::duplicate_mod)]

#[cfg(feature = "render")]
mod boxes;
#[cfg(feature = "render")]
mod drawing;
#[cfg(feature = "render")]
mod drawing_changes;
#[cfg(all(feature = "render", feature = "gizmos"))]
mod examples;
#[cfg(all(feature = "render", feature = "gizmos"))]
mod gizmos;
mod loading;
#[cfg(feature = "render")]
#[path = "../examples/support/mod.rs"]
mod support;
#[cfg(feature = "render")]
mod visibility;
