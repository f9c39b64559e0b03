//! Physics against closed forms, and what worlds promise: momentum, energy, the same bytes.

mod balls;
mod elastic;
mod errors;
mod frames;
mod oscillators;
mod parts;
mod regions;
mod sleep;
mod support;
mod surfaces;
mod worlds;
