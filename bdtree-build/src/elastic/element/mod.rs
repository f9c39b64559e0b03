//! Finite elements: stiffness and mass of one cell, hexahedron or tetrahedron.

pub(crate) mod hexahedron;
pub(crate) mod law;
pub(crate) mod moments;
pub(crate) mod spline;
pub(crate) mod tetrahedron;
