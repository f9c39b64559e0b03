//! The finite elements behind elastic modes: from a surface or a volume to its lowest vibrations.
//!
//! Each folder is a stage and uses those above it only:
//!
//! * `surface`: what hangs together, what is solid and what is a sheet;
//! * `element`: stiffness and mass of one element, and the lists of nodes that elements have;
//! * `assemble`: elements and constrained points added up to K and M, in an order that is good to factorise;
//! * `lattice`: cubic cells over a surface, what fills them, how many of them; `volume`: given elements;
//! * `constraint`: what `--fix` holds, of a lattice or by nodes;
//! * `solve`: motions without strain, the factorisation, the lowest modes.
//!
//! See docs/elastic.md for surfaces and the numbers, docs/volumes.md for volumes. Inside, lengths are cells or
//! elements, Young's modulus and density are 1; `basis::elastic` and `basis::volume` bring units.

pub(crate) mod assemble;
pub(crate) mod constraint;
pub(crate) mod disjoint_sets;
pub(crate) mod element;
pub(crate) mod lattice;
pub(crate) mod solve;
pub(crate) mod surface;
pub(crate) mod volume;
