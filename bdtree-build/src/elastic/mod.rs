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
//! One word for each notion:
//!
//! | word | what it is |
//! |---|---|
//! | surface component | triangles connected through shared positions (users read: piece) |
//! | body | a surface component that is solid or a sheet, with the cavities inside it: what keeps its own motion in a shared cell |
//! | fragment | what one cell cuts out of a triangle |
//! | filling | a body's share of a fine cell |
//! | cell part | what is connected inside one cell: two walls with a gap between them are two parts |
//! | component | cell parts, or given elements, that are connected: vibrates on its own |
//! | block | elements of a component that are connected through faces, hence stiff in themselves; blocks meet at joints |
//!
//! See docs/reference/elastic.md for surfaces and the numbers, docs/reference/volumes.md for volumes. Inside, lengths are cells or
//! elements, Young's modulus and density are 1; `basis::elastic` and `basis::volume` bring units.

pub(crate) mod assemble;
pub(crate) mod constraint;
pub(crate) mod element;
pub(crate) mod lattice;
pub(crate) mod solve;
pub(crate) mod surface;
pub(crate) mod volume;
