//! The finite elements behind elastic modes: from a surface to its lowest vibrations.
//!
//! One way through: `pieces` (what is solid, what is a sheet) → `lattice` (cubic cells) over `fill` (what
//! fills them) → `element` and `system` (stiffness and mass) → `solve` (`krylov` over
//! `factor`) → `locate` (back to the vertices). See docs/elastic.md for the numbers.
//!
//! Inside, lengths are cells, Young's modulus and density are 1; `basis::elastic` brings units.

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
