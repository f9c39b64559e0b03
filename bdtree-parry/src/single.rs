//! Shapes of `parry3d` and bodies of `rapier3d`, in f32.

use parry3d as parry;
#[cfg(feature = "rapier")]
use rapier3d as rapier;

#[path = "casts.rs"]
mod casts;
#[path = "composite.rs"]
mod composite;
#[path = "dispatcher.rs"]
mod dispatcher;
#[cfg(feature = "modes")]
#[path = "flexible.rs"]
mod flexible;
#[path = "lasting.rs"]
mod lasting;
#[path = "manifolds.rs"]
mod manifolds;
#[path = "mass.rs"]
mod mass;
#[cfg(feature = "modes")]
#[path = "modes.rs"]
mod modes;
#[path = "near.rs"]
mod near;
#[cfg(feature = "rapier")]
#[path = "rapier.rs"]
mod physics;
#[path = "points.rs"]
mod points;
#[cfg(feature = "modes")]
#[path = "rest.rs"]
mod rest;
#[path = "shape.rs"]
mod shape;
#[path = "triangles.rs"]
mod triangles;
#[path = "voxels.rs"]
mod voxels;

pub use dispatcher::MeshDispatcher;
#[cfg(feature = "modes")]
pub use flexible::FlexibleBody;
#[cfg(feature = "modes")]
pub use modes::FlexibleOptions;
#[cfg(feature = "rapier")]
pub use physics::FlexibleBodies;
pub use shape::DeformingMesh;
