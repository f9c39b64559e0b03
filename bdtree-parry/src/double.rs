//! Shapes of `parry3d-f64` and bodies of `rapier3d-f64`: what the crate has for f32, in f64.

use parry3d_f64 as parry;
#[cfg(feature = "rapier-f64")]
use rapier3d_f64 as rapier;

#[path = "casts.rs"]
mod casts;
#[path = "composite.rs"]
mod composite;
#[path = "dispatcher.rs"]
mod dispatcher;
#[cfg(feature = "modes-f64")]
#[path = "flexible.rs"]
mod flexible;
#[path = "lasting.rs"]
mod lasting;
#[path = "manifolds.rs"]
mod manifolds;
#[path = "mass.rs"]
mod mass;
#[cfg(feature = "modes-f64")]
#[path = "modes.rs"]
mod modes;
#[path = "near.rs"]
mod near;
#[cfg(feature = "rapier-f64")]
#[path = "rapier.rs"]
mod physics;
#[path = "points.rs"]
mod points;
#[cfg(feature = "modes-f64")]
#[path = "rest.rs"]
mod rest;
#[path = "shape.rs"]
mod shape;
#[path = "triangles.rs"]
mod triangles;
#[path = "voxels.rs"]
mod voxels;

pub use dispatcher::MeshDispatcher;
#[cfg(feature = "modes-f64")]
pub use flexible::FlexibleBody;
#[cfg(feature = "modes-f64")]
pub use modes::FlexibleOptions;
#[cfg(feature = "rapier-f64")]
pub use physics::FlexibleBodies;
pub use shape::DeformingMesh;
