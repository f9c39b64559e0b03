//! Reading what a studio has: meshes and given fields, into `Raw*` types.
//!
//! [`read_mesh`] is the door for meshes, [`gltf::read_gltf`] that for meshes with morph targets. Vertices keep the source's order, used or not, and a
//! triangle's index is its id, so that fields made elsewhere fit. Everything odd but usable becomes
//! a warning; everything else an error that names file and line, all of them at once.

pub mod gltf;
pub mod obj;
pub mod ply;
pub mod sequence;
pub mod stl;
pub mod volume;

mod degenerate;
mod faces;
mod load;
mod morphs;
pub(crate) mod read_file;
mod skin;
mod skin_arrays;

use crate::vec3::{bounds, diagonal};
pub(crate) use load::forget_folder;
pub use load::{read_mesh, read_model};
pub use morphs::{RawClip, RawModel, RawMorphs, RawTarget};
pub use skin::{
    Animated, KeyInterpolation, Local, RawBone, RawChannel, RawInfluences, RawSkeletonNode,
    RawSkin, RawSkinClip, Rows,
};
pub use skin_arrays::SkinArrays;

/// What becomes of faces that cannot be read: too few corners, a corner that is no vertex.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum BadFaces {
    /// Each is an error.
    #[default]
    Refuse,
    /// They are left out with a warning, and triangle ids count the others (OBJ and PLY).
    Skip,
}

/// A triangle mesh in the source's own coordinates and order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// File name of the source without its folder.
    pub name: String,
    /// SHA-256 of the source file's bytes as they lie on disk.
    pub hash: [u8; 32],
    /// Rest positions, one per source vertex in source order, unused ones included (mesh units).
    pub positions: Vec<[f64; 3]>,
    /// Corner indices into `positions`; the index of a triangle here is its id.
    pub triangles: Vec<[u32; 3]>,
    /// Source groups, in file order; ranges may be empty.
    pub groups: Vec<RawGroup>,
    /// What was odd but kept, each with its place.
    pub warnings: Vec<String>,
}

impl RawMesh {
    /// Least and largest coordinates of all vertices (mesh units).
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        bounds(self.positions.iter().copied()).into()
    }

    /// Diagonal of the box around all vertices (mesh units).
    pub fn diagonal(&self) -> f64 {
        diagonal(self.bounds().into())
    }
}

/// A run of triangles that the source put under one name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawGroup {
    /// What kind of statement named it.
    pub kind: GroupKind,
    /// The name as the source spells it.
    pub name: String,
    /// First triangle id.
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangle_count: u32,
}

/// Which statement of the source named a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GroupKind {
    /// OBJ `o`; a glTF node.
    Object,
    /// OBJ `g`; a glTF primitive.
    Group,
    /// OBJ `usemtl`; a glTF material.
    Material,
}
