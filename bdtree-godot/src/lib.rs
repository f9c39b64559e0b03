//! Collision and proximity queries on rigged meshes in Godot 4: an extension with one node, `BdtCollider3D`, that asks
//! `.bdt` files in the pose of a `MeshInstance3D`. `docs/guide/godot.md` is its page.
//!
//! Only `node` and `entry` speak to Godot. What it decides and computes is in modules that are tested without.

mod body;
mod entry;
mod fault;
mod names;
mod node;
mod place;
mod shared;
