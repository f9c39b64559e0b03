//! The finite elements behind elastic modes: from a surface or a volume to its lowest vibrations.
//!
//! From a surface: `pieces` (what is solid, what is a sheet) → `lattice` (cubic cells) over `fill` (what
//! fills them) → `element` and `component` (stiffness and mass) → `solve` → `locate` (back to the
//! vertices). See docs/elastic.md for the numbers.
//!
//! From a volume: `volume` (parts that hang together, their `joints`) → `tetrahedron` and
//! `hexahedron` → `solve`. See docs/volumes.md.
//!
//! Both meet in `assemble` and `system` (K, M, what is held), which `solve` takes through `rigid`
//! (motions without strain), `krylov` and `factor`.
//!
//! Inside, lengths are cells or elements, Young's modulus and density are 1; `basis::elastic` and
//! `basis::volume` bring units.

pub(crate) mod assemble;
#[cfg(test)]
mod bars;
pub(crate) mod canonical;
pub(crate) mod component;
#[cfg(test)]
pub(crate) mod dense;
pub(crate) mod dissection;
pub(crate) mod element;
pub(crate) mod factor;
pub(crate) mod fill;
pub(crate) mod fix;
pub(crate) mod grid;
pub(crate) mod hexahedron;
pub(crate) mod hold;
pub(crate) mod hold_nodes;
pub(crate) mod joints;
pub(crate) mod krylov;
pub(crate) mod lattice;
pub(crate) mod law;
pub(crate) mod locate;
pub(crate) mod moments;
pub(crate) mod node_list;
pub(crate) mod ordering;
pub(crate) mod pieces;
pub(crate) mod resolution;
pub(crate) mod rigid;
pub(crate) mod slice;
pub(crate) mod solve;
pub(crate) mod system;
pub(crate) mod table;
pub(crate) mod tetrahedron;
pub(crate) mod vec3;
pub(crate) mod volume;
