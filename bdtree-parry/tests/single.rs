//! Every test in f32.

use bdtree_parry as ours;
use parry3d as parry;
use rapier3d as rapier;

#[path = "bodies.rs"]
mod bodies;
#[path = "brute.rs"]
mod brute;
#[path = "every_shape.rs"]
mod every_shape;
#[path = "lasting.rs"]
mod lasting;
#[path = "loads.rs"]
mod loads;
#[path = "mass.rs"]
mod mass;
#[path = "meshes.rs"]
mod meshes;
#[path = "support.rs"]
mod support;
#[path = "voxels.rs"]
mod voxels;
