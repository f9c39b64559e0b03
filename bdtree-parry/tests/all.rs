//! Deforming meshes beside brute force, through parry and rapier.
// The same files test either precision.
#![allow(clippy::duplicate_mod)]

mod double;
mod flexible;
mod single;
