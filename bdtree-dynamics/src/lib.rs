//! Bodies that move their own q: vibration modes, a floating frame, contact forces, worlds.
//!
//! Not a physics engine, but the reduced side of one: what moves q when a body is hit, held or dropped. It stands on the
//! public surface of `bdtree-runtime`.
//!
//! | part | what it does | needs |
//! |---|---|---|
//! | [`Oscillator`] | one mode over a step, exactly | nothing |
//! | [`StrainLimit`] | keeps q below a limit, smoothly and without adding energy | nothing |
//! | [`FrameState`], [`rotation`] | a body's rigid motion; momentum and angular momentum are exact | nothing |
//! | [`ContactLaw`], [`Spring`] | Kelvin–Voigt and Coulomb | nothing |
//! | [`BodyModel`], [`LevelSpheres`] | what bodies of an asset have in common | `alloc` |
//! | [`World`] | many bodies and planes, step by step | `alloc` |
//!
//! ```
#![doc = include_str!("../examples/drop.rs")]
//! ```
//!
//! # The step
//!
//! A body is its frame (position of the center of mass, orientation, momentum, angular momentum) and its modes
//! (s and ṡ of each). Over a step all forces are constant. Positions and modes are then exact; orientation is of second
//! order. Contact forces are those that make springs give back what they take ([`contact_law`](ContactLaw)), found for all
//! contacts together by Gauss–Seidel sweeps. So energy never grows through contacts, whatever the step.
//!
//! # What couples frame and modes
//!
//! *Kept*: contact forces act on both. Modes of a free body have neither momentum nor angular momentum at rest, so to first
//! order in q the frame's motion and the modes do not act on each other. *Dropped*: what is of second order, namely the
//! change of the inertia with q, and centrifugal and Coriolis forces on q. Relative to what is kept they are of the order of
//! the body's deformation over its size, and of (Ω / ω)² for a body that turns at Ω.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "alloc")]
mod body_model;
mod contact_law;
mod error;
#[cfg(feature = "alloc")]
mod field;
mod frame;
#[cfg(feature = "alloc")]
mod level_spheres;
mod limit;
#[cfg(feature = "alloc")]
mod mass;
mod oscillator;
pub mod rotation;
#[cfg(feature = "alloc")]
mod surface;
#[cfg(feature = "alloc")]
mod world;

#[cfg(feature = "alloc")]
pub use body_model::{BodyModel, BodyOptions, ContactShape, Damping};
pub use contact_law::{ContactLaw, Spring};
pub use error::DynamicsError;
#[cfg(feature = "alloc")]
pub use field::Field;
pub use frame::{FrameMass, FrameState};
#[cfg(feature = "alloc")]
pub use level_spheres::{LevelSpheres, usual_level};
pub use limit::StrainLimit;
#[cfg(feature = "alloc")]
pub use mass::{MassProperties, RigidMass};
pub use oscillator::{Oscillator, Transition};
#[cfg(feature = "alloc")]
pub use world::{
    BodyId, BodyState, ContactRecord, Energy, Event, Events, Frame, ModelId, Phase, Plane,
    StepReport, StepTimes, World, WorldOptions,
};
