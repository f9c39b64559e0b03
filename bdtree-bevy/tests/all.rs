//! What `bdtree-bevy` promises.

mod loading;
