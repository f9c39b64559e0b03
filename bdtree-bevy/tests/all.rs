//! What `bdtree-bevy` promises.

#[cfg(feature = "avian")]
mod avian;
mod loading;
