//! What `bdtree-bevy` promises.

// Examples have the modules that they share as their own.
#![allow(clippy::duplicate_mod)]

#[cfg(feature = "avian")]
mod avian;
mod bounds;
#[cfg(any(feature = "avian", feature = "rapier"))]
mod chair;
mod clips;
mod common;
mod contacts;
#[cfg(feature = "render")]
mod drawing;
#[cfg(feature = "render")]
mod drawing_changes;
#[cfg(feature = "render")]
mod examples;
#[cfg(all(feature = "render", feature = "gizmos"))]
mod gizmos;
mod loading;
#[cfg(feature = "render")]
mod materials;
#[cfg(feature = "picking")]
mod picking;
#[cfg(feature = "render")]
mod pipelined;
mod queries;
#[cfg(feature = "rapier")]
mod rapier;
mod reload;
#[cfg(all(feature = "render", any(feature = "avian", feature = "rapier")))]
mod scene;
mod sources;
#[cfg(feature = "render")]
#[path = "../examples/support/mod.rs"]
mod support;
#[cfg(feature = "render")]
mod visibility;
