//! Every test in f64.

use bdtree_parry::double as ours;
use parry3d_f64 as parry;
use rapier3d_f64 as rapier;

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
