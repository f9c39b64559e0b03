//! Deforming meshes beside brute force, through parry and rapier.
// The same files test either precision.
#![allow(clippy::duplicate_mod)]

// Numbers are of its type already.
#[allow(clippy::unnecessary_cast, clippy::useless_conversion)]
mod double;
mod flexible;
mod single;
