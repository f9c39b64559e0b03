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
pub(crate) mod constraint;
pub(crate) mod element;
pub(crate) mod lattice;
pub(crate) mod solve;
pub(crate) mod surface;
pub(crate) mod vec3;
pub(crate) mod volume;
