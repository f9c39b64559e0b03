//! Colliders of avian.

use avian3d::parry;
use bdtree_parry as ours;

/// Brute force and shapes of the tests of `bdtree-parry`.
#[allow(dead_code)]
#[path = "../../../bdtree-parry/tests/brute.rs"]
mod brute;
mod flexible;
#[allow(dead_code)]
#[path = "../../../bdtree-parry/tests/support.rs"]
mod parry_shapes;
mod queries;
mod rest;
mod shapes;
mod support;
