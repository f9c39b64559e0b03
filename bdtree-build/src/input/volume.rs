//! Volume meshes made elsewhere: tetrahedra and hexahedra, with their materials.
//!
//! [`read_volume`] is the door; [`surface()`] is what such a mesh shows. docs/reference/volumes.md says what is
//! read and how.

mod check;
mod draft;
mod gmsh;
mod load;
mod notes;
mod number;
mod shape;
mod source;
mod surface;
pub(crate) mod trilinear;
mod veg;
mod vtk;

pub use load::{parse_volume, read_volume};
pub use surface::surface;
pub(crate) use surface::{Face, boundary};

/// A volume mesh in the source's own coordinates and order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawVolume {
    /// File name of the source without its folder.
    pub name: String,
    /// SHA-256 of the source file's bytes as they lie on disk.
    pub hash: [u8; 32],
    /// Node positions in source order, unused ones included (mesh units).
    pub nodes: Vec<[f64; 3]>,
    /// Corner indices into `nodes`; positively oriented: (b − a) × (c − a) · (d − a) > 0.
    pub tetrahedra: Vec<[u32; 4]>,
    /// Corner indices into `nodes`, in VTK's order: the bottom face counter-clockwise seen from
    /// above, then the top face above it.
    pub hexahedra: Vec<[u32; 8]>,
    /// Materials of the file; empty when it has none.
    pub materials: Vec<RawMaterial>,
    /// Index into `materials` of each element, tetrahedra first; empty when the file has none.
    pub material_of: Vec<u32>,
    /// Named sets of nodes, in file order.
    pub node_sets: Vec<RawNodeSet>,
    /// What was odd but kept, each with its place.
    pub warnings: Vec<String>,
}

/// An isotropic, linear material.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMaterial {
    /// Name in the source, if it has one.
    pub name: Option<String>,
    /// Young's modulus in Pa.
    pub young_pa: f64,
    /// Poisson's ratio, in (−1, 0.5).
    pub poisson: f64,
    /// Density in kg/m³.
    pub density_kg_m3: f64,
}

/// Nodes that the source put under one name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawNodeSet {
    /// The name as the source spells it.
    pub name: String,
    /// Indices into `nodes`, ascending, each once.
    pub nodes: Vec<u32>,
}
