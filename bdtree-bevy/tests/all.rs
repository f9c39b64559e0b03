//! What `bdtree-bevy` promises.

#[cfg(feature = "avian")]
mod avian;
#[cfg(any(feature = "avian", feature = "rapier"))]
mod chair;
mod loading;
#[cfg(feature = "rapier")]
mod rapier;
#[cfg(any(feature = "avian", feature = "rapier"))]
mod scene;
