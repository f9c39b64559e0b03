//! What `bdtree-bevy` promises.

#[cfg(feature = "render")]
mod drawing;
mod loading;
#[cfg(feature = "render")]
#[path = "../examples/support/mod.rs"]
mod support;
